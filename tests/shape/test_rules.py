"""Each rule about shape catches what it is there for, and lets the honest neighbour pass."""

from __future__ import annotations

import pytest

from tests.shape import rules

PAIR = ("emergency", "stop")  # never side by side in this file's own words


def test_a_module_of_501_lines_is_too_long() -> None:
    texts = {"src/a.py": "x = 1\n" * 501, "src/b.py": "x = 1\n" * 500}

    assert rules.too_long(texts) == ["src/a.py: 501 lines"]


def test_a_vague_name_is_found_as_module_and_as_package() -> None:
    vague = ["src/rosic/utils.py", "src/rosic/common/units.py", "tests/_helpers.py"]

    assert rules.vaguely_named([*vague, "src/rosic/units.py", "src/rosic/database.py"]) == vague


def test_tests_of_a_package_that_is_not_there_are_found() -> None:
    sources = ["src/rosic/features/booking/book.py", "src/rosic_sim/robots/robot.py"]
    beside = ["tests/features/booking/test_book.py", "tests/features/test_x.py", "tests/bounded.py"]
    beside += ["tests/rosic_sim/robots/test_robot.py", "tests/journeys/test_stops.py"]
    astray = ["tests/features/times/test_book.py", "tests/rosic_sim/machines/test_kuka.py"]

    assert rules.without_source([*beside, *astray], sources) == [
        "tests/features/times",
        "tests/rosic_sim/machines",
    ]


@pytest.mark.parametrize("between", [" ", "-", "_", "\n", "  "])
def test_the_two_words_are_found_however_they_are_joined(between: str) -> None:
    said = "# " + between.join(PAIR).upper()

    assert len(rules.claims_of_safety({"src/a.py": said})) == 1


def test_the_disclaimer_stands_on_its_own_pages_only() -> None:
    sentence = f"It is not an {' '.join(PAIR)}\n(IEC 60204-1, ISO 13850), carries no rating."

    assert rules.claims_of_safety({"SECURITY.md": sentence}) == []
    assert len(rules.claims_of_safety({"docs/linker.md": sentence})) == 1
    assert len(rules.claims_of_safety({"SECURITY.md": f"An {' '.join(PAIR)} for all."})) == 1


@pytest.mark.parametrize(
    "trace",
    [
        "/wor" + "k/main/src",
        "/hom" + "e/sam/rosic",
        "/roo" + "t/.cache",
        "see /opt/pyp" + "i/simple",
        "~/.pyen" + "v/shims",
        "https://mirror.example/simpl" + "e/pint",
        "--extra-inde" + "x-url x",
        "https://pyp" + "i.org/project/pint",
    ],
)
def test_a_trace_of_a_machine_is_found(trace: str) -> None:
    assert len(rules.traces_of_a_machine({"requirements/core.txt": f"a\n{trace}\n"})) == 1


def test_ordinary_paths_and_addresses_are_no_traces() -> None:
    text = "/kuka1/cmd_vel docs/homework/plan.md /usr/bin/env /tmp/x"
    text += " https://core.telegram.org/bots/api"

    assert rules.traces_of_a_machine({"docs/a.md": text}) == []


@pytest.mark.parametrize(
    "planted",
    [
        'if profile.link.kind != "ros2":',
        "    zero_type: str = 'geometry_msgs/msg/Twist'",
        "class ServiceBinding(msgspec.Struct):",
        "import rclpy",
        "# the ROS namespace",
        '    """Set ROS 2 parameters."""',
        "from rosic.robots.ros2.profile import AtRest",
        "depth: QoS",
        "if skill.topic is not None:",
        "if skill.set_parameters is None:",
        "hz = binding.stream_hz",
        "sends an action goal",
    ],
)
def test_a_word_of_ros_is_found_with_its_line(planted: str) -> None:
    clean = '"""Carries an order of the organiser across."""\n'
    [*found] = rules.words_of_ros({"src/rosic/core/robot/skill.py": f"{clean}{planted}\n"})

    assert found
    assert all(one.startswith("src/rosic/core/robot/skill.py:2: ") for one in found)


def test_words_that_only_look_like_ros_pass() -> None:
    text = "rosic across prose TopicBindings chat.topic shared.topic serviceable a_msg gross"

    assert rules.words_of_ros({"src/rosic/core/a.py": text}) == []


@pytest.mark.parametrize("word", ["authorize", "Behavior", "color", "canceled", "Organizer"])
def test_an_american_spelling_is_found_with_its_line(word: str) -> None:
    assert rules.american_spellings({"docs/a.md": f"\nto_{word} x"}) == [f"docs/a.md:2: {word}"]


def test_british_spellings_and_names_of_others_pass() -> None:
    text = (
        "authorise organiser colour cancelled behaviour centre dialogue laboratory "
        "unicodedata.normalize('NFKC', x) NO_COLOR GoalStatus.STATUS_CANCELED"
    )

    assert rules.american_spellings({"docs/a.md": text}) == []


def test_a_package_without_a_docstring_is_found() -> None:
    texts = {"src/a/__init__.py": "", "src/b/__init__.py": '"""B."""\n', "src/c.py": ""}

    assert rules.without_docstring(texts) == ["src/a/__init__.py"]


def test_a_link_that_leads_nowhere_is_found() -> None:
    page = (
        "[a](b.md) [b](../LICENSE#top) [c](https://ros.org/x) [d](#here) [e](decisions) [f](no.md)"
    )
    paths = ["docs/a.md", "docs/b.md", "docs/decisions/0.md", "LICENSE"]

    assert rules.broken_links({"docs/a.md": page}, paths) == ["docs/a.md: no.md"]


def test_every_way_to_import_counts() -> None:
    source = "import yaml.nodes\ndef f():\n    from nacl.bindings import x\nfrom . import y\n"

    assert rules.imported_packages([source]) == {"yaml", "nacl"}


def test_a_requirement_without_hash_or_without_pin_is_found() -> None:
    good = "# note\npint==0.25 \\\n    --hash=sha256:ab\n    # via x\n"
    text = f"{good}yarl==1\nmako>=1 --hash=sha256:cd\n"

    assert [line.split()[0] for line in rules.without_hash(text)] == ["yarl==1", "mako>=1"]
    assert rules.pins(text) == {"pint": "0.25", "yarl": "1"}


def test_a_translator_that_something_else_hides_is_found() -> None:
    imported = "from rosic.core.i18n import figure, said\n"
    own = "def f(said):\n    pass\nclass A:\n    said: str\nsaid = f(1)\n"

    assert rules.hidden_translators({"a.py": own, "b.py": f"{imported}said('x')"}) == []
    assert rules.hidden_translators({"a.py": imported + own}) == ["a.py:6", "a.py:2"]


RAISING = """
import msgspec
from graphlib import TopologicalSorter
from rosic.core.order import Order

class Damaged(ValueError): pass
class Torn(Damaged): pass
class Slot: pass

async def read():
    \"\"\"Read it.

    Raises:
        %s: The file is not what was written, or it
            was: not closed.

    Cancelling it: does nothing.
    \"\"\"
"""


@pytest.mark.parametrize("name", ["Unreadable", "Torn, Unreadable", "Slot", "Order", "x.Torn"])
def test_a_docstring_that_names_no_exception_is_found(name: str) -> None:
    found = rules.unknown_exceptions({"src/a.py": RAISING % name})

    assert found == [f"src/a.py:10: {name.removeprefix('Torn, ')}"]


@pytest.mark.parametrize(
    "name",
    ["OSError", "Damaged, Torn", "msgspec.MsgspecError", "graphlib.CycleError"],
)
def test_exceptions_of_python_of_the_source_and_of_libraries_pass(name: str) -> None:
    assert rules.unknown_exceptions({"src/a.py": RAISING % name}) == []
