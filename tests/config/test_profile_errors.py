"""Each sentence about a profile, by a file that causes it, on the line that is to blame."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.config.profiles import check_profile, load_profile, read_profile
from rosic.errors import ConfigurationError
from tests.config.profile_text import DIALOGUE, GOOD, MARK, marked_line, spoil, write

if TYPE_CHECKING:
    from pathlib import Path


class Case(NamedTuple):
    """The line that carries the mark is the one to be named."""

    name: str
    old: str
    new: str
    sentence: str
    hint: str = ""
    base: str = GOOD


AT_REST = "\n".join(GOOD.splitlines()[10:15])
STOP = GOOD.splitlines()[5]

LINE = "rest_timeout_s: 5\n"
BY_TOPIC = "{ name: /rover/file, type: std_msgs/msg/String, message: { data: %s } }"
BY_SERVICE = "{ name: /rover/take, type: std_srvs/srv/SetBool, request: { data: %s } }"


def files(deliver: str, rest: str = "accept: [yaml], inbox: /srv/rover") -> str:
    """Return a profile's files, in one line, marked."""
    return f"{LINE}files: {{ {rest}, deliver: {deliver} }} #!\n"


CASES = [
    # ---- files ----
    Case("files that go nowhere", LINE, f"{LINE}files: {{ accept: [yaml] }} #!\n",
         "Files are taken with both: which kinds to accept, and an inbox or deliver."),
    Case("a file by no way", LINE, files("{ }"),
         "A file is delivered by a topic or by a service: one of them."),
    Case("a file by both ways", LINE,
         files(f"{{ topic: {BY_TOPIC % '$path'}, service: {BY_SERVICE % '$path'} }}"),
         "A file is delivered by a topic or by a service: one of them."),
    Case("what no file has", LINE, files(f"{{ topic: {BY_TOPIC % '$pat'} }}"),
         "$pat is nothing that a file has.", "Did you mean $path?"),
    Case("nothing of the file", LINE, files(f"{{ topic: {BY_TOPIC % 'hello'} }}"),
         "Nothing of the file is sent.", "Write $path where it belongs."),
    Case("a path without an inbox", LINE,
         files(f"{{ topic: {BY_TOPIC % '$path'} }}", "accept: [yaml]"),
         "$path needs an inbox for the file to lie in."),
    Case("a large content in a message", LINE, files(f"{{ topic: {BY_TOPIC % '$text'} }}"),
         "A message holds 0.06 MB at most.", "Set max_mb to 0.06"),
    Case("a receipt of a service", LINE,
         files(f"{{ service: {BY_SERVICE % '$path'}, receipt: {{ topic: /rover/read }} }}"),
         "The answer of a service is its receipt."),
    Case("a checksum of a topic", LINE,
         files(f"{{ topic: {BY_TOPIC % '$path'}, digest: message }}"),
         "Only a service answers; a topic needs a receipt."),
    # ---- keys ----
    Case("misspelt key", "link_loss: hold", "linkloss: hold #!",
         "'linkloss' is not known here.", "Did you mean link_loss?"),
    Case("unknown key", "kind: ros2, namespace: /rover }",
         "kind: ros2, namespace: /rover, zz: 1 } #!",
         "'zz' is not known here.", "Known here: among, dialogue, heartbeat_s, kind, model, "
         "namespace."),
    Case("the id of a skill is its key", "    title: Move\n", "    id: other #!\n",
         "'id' is not known here.", "Known here: action, benchmark, class, "),
    Case("missing id", "id: rover\n", "", "'id' is missing in this file."),
    Case("missing inside", "link: { kind: ros2, namespace: /rover }",
         "link: { namespace: /rover } #!",
         "'kind' is missing in 'link'."),
    Case("empty", "    class: task", "    class: #!",
         "'class' is empty.", "Give a value, or leave the key out."),
    # ---- types ----
    Case("text for a number", "queue_length: 16", "queue_length: many #!",
         "'queue_length' must be a whole number, not a text."),
    Case("number for a text", "title: Rover", "title: 7 #!",
         "'title' must be a text, not a number."),
    Case("truth for a number", "rest_timeout_s: 5", "rest_timeout_s: true #!",
         "'rest_timeout_s' must be a number, not true or false."),
    Case("fraction for a whole number", "queue_length: 16", "queue_length: 1.5 #!",
         "'queue_length' must be a whole number, not a number."),
    Case("text for a list", "words: [buggy]", "words: buggy #!",
         "'words' must be a list, not a text."),
    Case("number in a list", "words: [buggy]", "words:\n  - buggy\n  - 3 #!",
         "2 of 'words' must be a text, not a number."),
    Case("text for a table", "link: { kind: ros2, namespace: /rover }", "link: ros2 #!",
         "'link' must be a table of keys, not a text."),
    Case("list for a value", "request: { data: $state.value }", "request: { data: [$state] } #!",
         "'data' must be "),
    # ---- words to choose from ----
    Case("misspelt choice", "link_loss: hold", "link_loss: hodl #!",
         "'link_loss' must be one of hold, land, return, continue.", "Did you mean hold?"),
    Case("unknown class", "    class: config", "    class: dance #!",
         "'class' must be one of observe, task, motion, config, admin, stop.", "Known here: "),
    Case("stop as a class", "    class: config", "    class: stop",
         "Stop is not a skill: every robot has one."),
    # ---- bounds ----
    Case("queue", "queue_length: 16", "queue_length: 0 #!",
         "'queue_length' must be between 1 and 10000."),
    Case("watchdog", "watchdog_s: 0.5", "watchdog_s: -1 #!",
         "'watchdog_s' must be between 0.05 and 5."),
    Case("rest", "below: 0.01", "below: 0 #!", "'below' must be between 1e-06 and 10."),
    Case("lifetime", "lifetime_s: 5", "lifetime_s: 1e9 #!",
         "'lifetime_s' must be between 0.1 and 3600."),
    Case("stream", "stream_hz: 10", "stream_hz: -1 #!", "'stream_hz' must be between 0 and 100."),
    Case("time-out", "timeout_s: 60", "timeout_s: 0 #!",
         "'timeout_s' must be between 0.05 and 86400."),
    # ---- parameters ----
    Case("no bounds", "distance: { unit: m, min: 0.1, max: 5 }",
         "distance: { unit: m, min: 0.1 } #!",
         "A number needs min and max."),
    Case("bounds the wrong way", "min: 0.1, max: 5 }\n      steps",
         "min: 6, max: 5 } #!\n      steps",
         "Min and max must be finite, and min not above max."),
    Case("default outside", "integer: true, default: 3 }", "integer: true, default: 10 } #!",
         "The default is not a number between min and max."),
    Case("default no choice", "        default: forward", "        default: sideways #!",
         "The default is not one of the choices."),
    Case("choice with a unit", "        default: forward", "        unit: m #!",
         "A choice or a text has no unit and no bounds."),
    Case("half an integer", "integer: true, default: 3 }", "integer: true, default: 1.5 } #!",
         "'default' must be a whole number, as 'integer' is true."),
    Case("unknown unit", "{ unit: m, min", "{ unit: metrs, min",
         "'metrs' is not a unit ROSIC knows.",
         "Did you mean metres?"),
    Case("a unit like no other", "{ unit: m, min", "{ unit: furlong, min",
         "'furlong' is not a unit ROSIC knows."),
    # ---- names ----
    Case("id", "id: rover", "id: Rover #!", "'Rover' is not a name.",
         "Use small letters, digits and _, a letter first, at most 32 characters."),
    Case("id with a line break", "id: rover", 'id: "rover\\n" #!', "'rover\\n' is not a name."),
    Case("group", "groups: [fleet1]", "groups: [ok, all-of-them] #!",
         "'all-of-them' is not a name."),
    Case("skill", "  light:\n", "  Light On: #!\n", "'Light On' is not a name."),
    Case("parameter", "      gain: {", "      Gain: { #!\n       ", "'Gain' is not a name."),
    Case("word", "words: [shift]", 'words: ["a=b"] #!', "'a=b' is not a word people type.",
         "Use at most four words in small letters, each of at most 32 characters."),
    Case("fleet", "id: rover", "id: fleet #!", "'fleet' cannot be a robot: it means all that is "),
    Case("read", "  light:\n", "  read: #!\n",
         "'read' cannot be a skill: it means the same for every robot."),
    # ---- words that would be heard as something else ----
    Case("word of two skills", "  light:\n    class: task\n",
         "  light:\n    class: task\n    words: [shift] #!\n",
         'Robot rover: "shift" means both move and light.', "Choose another word."),
    Case("skill called like a command", "  light:\n", "  status: #!\n",
         "Robot rover: skill 'status' cannot be called \"status\""),
    Case("robot called stop", "words: [buggy]", "words: [halt] #!",
         'Robot rover cannot be called "halt"'),
    Case("word of two choices", "          back: [backwards]", "          back: [ahead]",
         "Robot rover, skill 'move': parameter 'direction': \"ahead\" is both "),
    # ---- ROS ----
    Case("name", "name: /rover/move", "name: rover/move #!", "'rover/move' is not a ROS name.",
         "Write it from the root, for example /omni/odom."),
    Case("node", "node: /rover/driver", "node: /rover/1driver",
         "'/rover/1driver' is not a ROS name."),
    Case("old spelling of a type", "type: std_srvs/srv/SetBool", "type: std_srvs/SetBool #!",
         "'std_srvs/SetBool' is not a ROS service type.",
         "Write package/srv/Type, for example std_srvs/srv/Trigger."),
    Case("a number for yes or no", "on: { value: true }, off: { value: false }",
         "on: { value: 1 }, off: { value: 0 }",
         "'data' of std_srvs/srv/SetBool is true or false, and '$state.value' is neither.",
         "Write true or false, or $state.value with means: { on: { value: true } } and so on."),
    Case("a stop that releases", "stop: { service: /rover/stop, type: std_srvs/srv/Trigger",
         "stop: { service: /rover/stop, type: std_srvs/srv/SetBool",
         "A stop by std_srvs/srv/SetBool has to say data: by itself it is false, which releases a "
         "brake.",
         "Write request: { data: true }, or false where that is what stops this robot."),
    Case("numbers and words of one meaning", "off: { value: false }", "off: { value: slow }",
         "Means must give the same kind of 'value' for every choice."),
    Case("two types of one service", LINE,
         f"{LINE}files: {{ accept: [yaml], inbox: /srv/in, deliver: {{ service: {{ name: "
         "/rover/light, type: std_srvs/srv/Trigger, request: { data: $path } } } } #!\n",
         "The service /rover/light has the type std_srvs/srv/SetBool elsewhere in this profile",
         "Ask the robot which: ros2 service type /rover/light."),
    Case("kind of a type", "type: rosic_interfaces/action/Move",
         "type: rosic_interfaces/msg/Move #!",
         "'rosic_interfaces/msg/Move' is not a ROS action type.",
         "Write package/action/Type, for example rosic_interfaces/action/Move."),
    Case("message type", "type: geometry_msgs/msg/Twist", "type: geometry_msgs/srv/Twist #!",
         "'geometry_msgs/srv/Twist' is not a ROS message type."),
    Case("field", "message: { linear.x: $speed }", "message: { linear..x: $speed } #!",
         "'linear..x' is not a field of a message.",
         "Join fields by dots, as in twist.twist.linear.x."),
    Case("fields at rest", '"twist.twist.linear.x, twist.twist.angular.z"', "twist twist #!",
         "'twist twist' is not a field of a message."),
    Case("placeholder", "distance_m: $distance", "distance_m: $distnce",
         "$distnce is not a parameter of this skill.", "Did you mean distance?"),
    Case("unused parameter",
         "goal: { direction: $direction, distance_m: $distance, steps: $steps }",
         "goal: { direction: $direction, distance_m: $distance }",
         "'steps' is asked of people but never sent to the robot.",
         "Write $steps where it belongs under action.goal."),
    Case("two bindings", "    set_parameters: {",
         "    service: { name: /a, type: a/srv/B }\n    set_parameters: {",
         "A skill has at most one of topic, service, action, set_parameters."),
    Case("no binding", "    set_parameters: { node: /rover/driver, values: { gain: $gain } }\n", "",
         "'tune' says nothing of how ROS carries it out.",
         "Give one of topic, service, action, set_parameters."),
    Case("no namespace", "namespace: /rover }", 'namespace: "" } #!',
         "A ros2 robot needs a namespace.", "For example /rover; / for one that has none."),
    # ---- moving safely ----
    Case("no watchdog", "watchdog_s: 0.5\n", "",
         "Skill 'drive' streams a velocity, but the profile states no watchdog_s"),
    Case("slow stream", "stream_hz: 10", "stream_hz: 2 #!",
         "2 Hz is too slow for a robot that stops by itself after 0.5 s.",
         "Send at 4 Hz or more."),
    Case("a velocity once", "      stream_hz: 10\n", "",
         "A single velocity would keep the robot moving.",
         "Give stream_hz, so that it is sent for a time and ends in zero."),
    Case("stream without an end", "      duration: { unit: s, min: 0.1, max: 5 }\n", "",
         "A stream needs a parameter 'duration' in s that is above 0."),
    Case("stream of no time", "duration: { unit: s, min: 0.1", "duration: { unit: s, min: 0",
         "A stream needs a parameter 'duration' in s that is above 0."),
    Case("nothing to stop it", STOP + "\n", "", "'stop' is missing: nothing would stop this robot.",
         "Give stop a service, a velocity topic to zero, or both."),
    Case("stop that stops nothing", STOP, "stop: { type: std_srvs/srv/Trigger } #!",
         "'stop' names neither a service nor a velocity topic to zero."),
    Case("rest never measured", AT_REST + "\n", "",
         "'at_rest' is missing: a stop of this robot could never be confirmed.",
         "Name a topic and the fields that are near zero when it stands still."),
    Case("nothing left that shows rest", AT_REST, f"{AT_REST}\n  stop_only: no.such #!",
         "What stop_only names has to be some of the fields, and not all."),
    # ---- the text link ----
    Case("text outside a dialogue", "      gain: { min: 0, max: 1, default: 0.5 }",
         "      gain: { text: true } #!", "Free text goes to a robot only over its dialogue.",
         "Set link.dialogue to true, or give choices instead of text."),
    Case("text into a service", "say: { class: task, parameters: { text: { text: true } } }",
         "say: { class: task, parameters: { text: { text: true } }, #!\n"
         "    service: { name: /a, type: a/srv/B, request: { data: $text } } }",
         "Free text never goes into a topic, service or action.", base=DIALOGUE),
    Case("full of what is no share", '    unit: "%"\n', '    unit: V\n    full: 100 #!\n',
         "'full' is of a share: it needs the unit %."),
    Case("half a reported value", "    field: percentage\n", "",
         "A reported value needs topic, type and field, or none of them."),
]  # fmt: skip


def test_the_profile_that_is_spoilt_here_was_good(tmp_path: Path) -> None:
    for text in (GOOD, DIALOGUE):
        assert [str(error) for error in check_profile(write(tmp_path, text))] == []


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_what_is_wrong_is_said(case: Case, tmp_path: Path) -> None:
    text = spoil(case.old, case.new, case.base)
    path = write(tmp_path, text)

    errors = check_profile(path)

    assert len(errors) == 1, [str(error) for error in errors]
    [error] = errors
    said = str(error).removeprefix(f"{error.where}: ")
    assert said.startswith(case.sentence)
    assert case.hint in error.hint
    if MARK in text:
        assert error.where == f"{path}:{marked_line(text)}"
    with pytest.raises(ConfigurationError) as raised:
        load_profile(path)
    assert str(raised.value) == str(error)


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_it_is_one_sentence_and_perhaps_a_hint(case: Case, tmp_path: Path) -> None:
    [error] = check_profile(write(tmp_path, spoil(case.old, case.new, case.base)))
    for part in (str(error), error.hint):
        assert "\n" not in part
        assert "!" not in part
        assert not part or part.rstrip()[-1] in ".?"


JUNK = ("", "7", "true", "[[]]", "{x: {}}", "$x")


@pytest.mark.parametrize("number", range(len(GOOD.splitlines())))
def test_whatever_is_wrong_is_said_and_raises_nothing(number: int, tmp_path: Path) -> None:
    lines = GOOD.splitlines()
    before = lines[number]
    for junk in JUNK:
        lines[number] = f"{before.partition(': ')[0].rstrip(':')}: {junk}"
        for error in check_profile(write(tmp_path, "\n".join(lines))):
            assert error.where


@pytest.mark.parametrize("text", ["[]", "7", "x", "null", "- id: omni"])
def test_a_file_that_holds_no_table_is_said(text: str, tmp_path: Path) -> None:
    [error] = check_profile(write(tmp_path, text))
    assert "The file" in str(error)


def test_everything_is_said_at_once(tmp_path: Path) -> None:
    text = GOOD
    for old, new in (
        ("queue_length: 16", "queue_length: 0"),
        ("link_loss: hold", "link_loss: hodl"),
        ("{ unit: m, min", "{ unit: metrs, min"),
        ("type: std_srvs/srv/SetBool", "type: std_srvs/SetBool"),
        ("values: { gain: $gain }", "values: { gain: $gian }"),
    ):
        text = spoil(old, new, text)
    lines = [int(error.where.rpartition(":")[2]) for error in check_profile(write(tmp_path, text))]
    assert lines == sorted(lines)
    assert len(lines) == 5


def test_a_robot_reached_in_another_way_is_checked_for_that_way(tmp_path: Path) -> None:
    text = spoil(
        "link: { kind: ros2, namespace: /rover }", "link: { kind: simulated, model: omni }"
    )
    path = write(tmp_path, text)
    assert read_profile(path).errors == []
    [error] = read_profile(path, link="ros2").errors
    assert "needs a namespace" in str(error)


def test_what_could_be_better_is_no_error(tmp_path: Path) -> None:
    text = spoil("type: geometry_msgs/msg/Twist", "type: custom_msgs/msg/Step")
    text = spoil("      name: /rover/cmd_vel\n", "      name: /rover/step\n", text)
    text = spoil("      stream_hz: 10\n", "", text)
    text = spoil("      duration: { unit: s, min: 0.1, max: 5 }\n", "", text)
    read = read_profile(write(tmp_path, text))
    assert read.errors == []
    [advice] = read.advice
    assert "'drive' is sent over a topic, which does not acknowledge." in str(advice)


def test_an_axis_that_is_driven_and_not_measured_is_named(tmp_path: Path) -> None:
    text = spoil("{ linear.x: $speed }", "{ linear.x: $speed, angular.z: 0.1 }")
    text = spoil(", twist.twist.angular.z", "", text)
    read = read_profile(write(tmp_path, text))
    assert read.errors == []
    [advice] = read.advice
    assert "'drive' sends angular.z, which 'at_rest' does not measure" in str(advice)
    assert "Add the field that ends in angular.z" in str(advice)
