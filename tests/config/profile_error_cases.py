"""Profiles that are each wrong in one place, and what is said of it."""

from __future__ import annotations

from typing import NamedTuple

from tests.config.profile_text import GOOD


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
    Case(
        "files that go nowhere",
        LINE,
        f"{LINE}files: {{ accept: [yaml] }} #!\n",
        "Files are taken with both: which kinds to accept, and an inbox or deliver.",
    ),
    Case(
        "a file by no way",
        LINE,
        files("{ }"),
        "A file is delivered by a topic or by a service: one of them.",
    ),
    Case(
        "a file by both ways",
        LINE,
        files(f"{{ topic: {BY_TOPIC % '$path'}, service: {BY_SERVICE % '$path'} }}"),
        "A file is delivered by a topic or by a service: one of them.",
    ),
    Case(
        "what no file has",
        LINE,
        files(f"{{ topic: {BY_TOPIC % '$pat'} }}"),
        "$pat is nothing that a file has.",
        "Did you mean $path?",
    ),
    Case(
        "nothing of the file",
        LINE,
        files(f"{{ topic: {BY_TOPIC % 'hello'} }}"),
        "Nothing of the file is sent.",
        "Write $path where it belongs.",
    ),
    Case(
        "a path without an inbox",
        LINE,
        files(f"{{ topic: {BY_TOPIC % '$path'} }}", "accept: [yaml]"),
        "$path needs an inbox for the file to lie in.",
    ),
    Case(
        "a large content in a message",
        LINE,
        files(f"{{ topic: {BY_TOPIC % '$text'} }}"),
        "A message holds 0.06 MB at most.",
        "Set max_mb to 0.06",
    ),
    Case(
        "a receipt of a service",
        LINE,
        files(f"{{ service: {BY_SERVICE % '$path'}, receipt: {{ topic: /rover/read }} }}"),
        "The answer of a service is its receipt.",
    ),
    Case(
        "a checksum of a topic",
        LINE,
        files(f"{{ topic: {BY_TOPIC % '$path'}, digest: message }}"),
        "Only a service answers; a topic needs a receipt.",
    ),
    # ---- keys ----
    Case(
        "misspelt key",
        "link_loss: hold",
        "linkloss: hold #!",
        "'linkloss' is not known here.",
        "Did you mean link_loss?",
    ),
    Case(
        "unknown key",
        "kind: ros2, namespace: /rover }",
        "kind: ros2, namespace: /rover, zz: 1 } #!",
        "'zz' is not known here.",
        "Known here: among, dialogue, heartbeat_s, kind, model, namespace.",
    ),
    Case(
        "the id of a skill is its key",
        "    title: Move\n",
        "    id: other #!\n",
        "'id' is not known here.",
        "Known here: action, benchmark, class, ",
    ),
    Case("missing id", "id: rover\n", "", "'id' is missing in this file."),
    Case(
        "missing inside",
        "link: { kind: ros2, namespace: /rover }",
        "link: { namespace: /rover } #!",
        "'kind' is missing in 'link'.",
    ),
    Case(
        "empty",
        "    class: task",
        "    class: #!",
        "'class' is empty.",
        "Give a value, or leave the key out.",
    ),
    # ---- types ----
    Case(
        "text for a number",
        "queue_length: 16",
        "queue_length: many #!",
        "'queue_length' must be a whole number, not a text.",
    ),
    Case(
        "number for a text", "title: Rover", "title: 7 #!", "'title' must be a text, not a number."
    ),
    Case(
        "truth for a number",
        "rest_timeout_s: 5",
        "rest_timeout_s: true #!",
        "'rest_timeout_s' must be a number, not true or false.",
    ),
    Case(
        "fraction for a whole number",
        "queue_length: 16",
        "queue_length: 1.5 #!",
        "'queue_length' must be a whole number, not a number.",
    ),
    Case(
        "text for a list",
        "words: [buggy]",
        "words: buggy #!",
        "'words' must be a list, not a text.",
    ),
    Case(
        "number in a list",
        "words: [buggy]",
        "words:\n  - buggy\n  - 3 #!",
        "2 of 'words' must be a text, not a number.",
    ),
    Case(
        "text for a table",
        "link: { kind: ros2, namespace: /rover }",
        "link: ros2 #!",
        "'link' must be a table of keys, not a text.",
    ),
    Case(
        "list for a value",
        "request: { data: $state.value }",
        "request: { data: [$state] } #!",
        "'data' must be ",
    ),
    # ---- words to choose from ----
    Case(
        "misspelt choice",
        "link_loss: hold",
        "link_loss: hodl #!",
        "'link_loss' must be one of hold, land, return, continue.",
        "Did you mean hold?",
    ),
    Case(
        "unknown class",
        "    class: config",
        "    class: dance #!",
        "'class' must be one of observe, task, motion, config, admin, stop.",
        "Known here: ",
    ),
    Case(
        "stop as a class",
        "    class: config",
        "    class: stop",
        "Stop is not a skill: every robot has one.",
    ),
    # ---- bounds ----
    Case(
        "queue",
        "queue_length: 16",
        "queue_length: 0 #!",
        "'queue_length' must be between 1 and 10000.",
    ),
    Case(
        "watchdog",
        "watchdog_s: 0.5",
        "watchdog_s: -1 #!",
        "'watchdog_s' must be between 0.05 and 5.",
    ),
    Case("rest", "below: 0.01", "below: 0 #!", "'below' must be between 1e-06 and 10."),
    Case(
        "lifetime",
        "lifetime_s: 5",
        "lifetime_s: 1e9 #!",
        "'lifetime_s' must be between 0.1 and 3600.",
    ),
    Case("stream", "stream_hz: 10", "stream_hz: -1 #!", "'stream_hz' must be between 0 and 100."),
    Case(
        "time-out",
        "timeout_s: 60",
        "timeout_s: 0 #!",
        "'timeout_s' must be between 0.05 and 86400.",
    ),
    # ---- parameters ----
    Case(
        "no bounds",
        "distance: { unit: m, min: 0.1, max: 5 }",
        "distance: { unit: m, min: 0.1 } #!",
        "A number needs min and max.",
    ),
    Case(
        "bounds the wrong way",
        "min: 0.1, max: 5 }\n      steps",
        "min: 6, max: 5 } #!\n      steps",
        "Min and max must be finite, and min not above max.",
    ),
    Case(
        "default outside",
        "integer: true, default: 3 }",
        "integer: true, default: 10 } #!",
        "The default is not a number between min and max.",
    ),
    Case(
        "default no choice",
        "        default: forward",
        "        default: sideways #!",
        "The default is not one of the choices.",
    ),
    Case(
        "choice with a unit",
        "        default: forward",
        "        unit: m #!",
        "A choice or a text has no unit and no bounds.",
    ),
    Case(
        "half an integer",
        "integer: true, default: 3 }",
        "integer: true, default: 1.5 } #!",
        "'default' must be a whole number, as 'integer' is true.",
    ),
    Case(
        "unknown unit",
        "{ unit: m, min",
        "{ unit: metrs, min",
        "'metrs' is not a unit ROSIC knows.",
        "Did you mean metres?",
    ),
    Case(
        "a unit like no other",
        "{ unit: m, min",
        "{ unit: furlong, min",
        "'furlong' is not a unit ROSIC knows.",
    ),
    # ---- names ----
    Case(
        "id",
        "id: rover",
        "id: Rover #!",
        "'Rover' is not a name.",
        "Use small letters, digits and _, a letter first, at most 32 characters.",
    ),
    Case("id with a line break", "id: rover", 'id: "rover\\n" #!', "'rover\\n' is not a name."),
    Case(
        "group", "groups: [fleet1]", "groups: [ok, all-of-them] #!", "'all-of-them' is not a name."
    ),
    Case("skill", "  light:\n", "  Light On: #!\n", "'Light On' is not a name."),
    Case("parameter", "      gain: {", "      Gain: { #!\n       ", "'Gain' is not a name."),
    Case(
        "word",
        "words: [shift]",
        'words: ["a=b"] #!',
        "'a=b' is not a word people type.",
        "Use at most four words in small letters, each of at most 32 characters.",
    ),
    Case("fleet", "id: rover", "id: fleet #!", "'fleet' cannot be a robot: it means all that is "),
    Case(
        "read",
        "  light:\n",
        "  read: #!\n",
        "'read' cannot be a skill: it means the same for every robot.",
    ),
    # ---- words that would be heard as something else ----
]
