# ruff: noqa: RUF001 - people type what is ambiguous
from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.language import (
    Do,
    Halt,
    Help,
    Line,
    LineContext,
    Misunderstood,
    Resume,
    Robots,
    Start,
    Status,
    Use,
    Vocabulary,
    understand,
)
from rosic.core.language.skill_values import is_understood
from rosic.core.order import SpokenValue

if TYPE_CHECKING:
    from tests.core.language.conftest import Means

S = SpokenValue


def done(line: Line) -> tuple[tuple[str, ...], str, tuple[SpokenValue, ...]]:
    assert isinstance(line, Do), line
    assert len(line.robots) == len(line.skills)
    return line.robots, line.skills[0].id, line.spoken


@pytest.mark.parametrize(
    ("text", "robot", "skill", "spoken"),
    [
        ("omni move 50 cm left", "omni", "move", (S("", 50, "cm"), S("", None, "left"))),
        ("omni move forward 0.5", "omni", "move", (S("", None, "forward"), S("", 0.5, ""))),
        ("omni move 0.5 forward", "omni", "move", (S("", 0.5, ""), S("", None, "forward"))),
        ("Omni Move 50CM Left!", "omni", "move", (S("", 50, "CM"), S("", None, "left"))),
        ("omni, move 1 m.", "omni", "move", (S("", 1, "m"),)),
        (
            "please omni move by 1 m to the left",
            "omni",
            "move",
            (S("", 1, "m"), S("", None, "left")),
        ),
        ("omni please shift 1 m", "omni", "move", (S("", 1, "m"),)),
        ("rover move 1m straight on", "omni", "move", (S("", 1, "m"), S("", None, "straight on"))),
        ("omni move 1,5 m", "omni", "move", (S("", 1.5, "m"),)),
        ("omni move 1/2 m", "omni", "move", (S("", 0.5, "m"),)),
        ("omni move half a metre", "omni", "move", (S("", 0.5, "metre"),)),
        ("omni move a metre left", "omni", "move", (S("", 1, "metre"), S("", None, "left"))),
        ("omni move two m", "omni", "move", (S("", 2, "m"),)),
        ("omni move １m", "omni", "move", (S("", 1, "m"),)),
        (
            "omni move 2 m at 0.3 metres per second",
            "omni",
            "move",
            (S("", 2, "m"), S("", 0.3, "metres per second")),
        ),
        ("omni go home", "omni", "go_home", ()),
        ("omni gohome", "omni", "go_home", ()),
        ("omni go back to the dock", "omni", "go_home", ()),
        ("kuka1 grasp force=20", "kuka1", "grasp", (S("force", 20, ""),)),
        ("kuka1 grasp force = 20 N", "kuka1", "grasp", (S("force", 20, "N"),)),
        ("kuka1 grasp force 20 N", "kuka1", "grasp", (S("force", 20, "N"),)),
        ("kuka1 grab with force of 20N", "kuka1", "grasp", (S("force", 20, "N"),)),
        ("KUKA iiwa grasp", "kuka1", "grasp", ()),
        ("kuka1 move joint 3 30 deg", "kuka1", "move_joint", (S("", 3, ""), S("", 30, "deg"))),
        (
            "kuka1 move_joint joint=3 angle=-30°",
            "kuka1",
            "move_joint",
            (S("joint", 3, ""), S("angle", -30, "°")),
        ),
        ("cf1 goto 1 2 1.5", "cf1", "goto", (S("", 1, ""), S("", 2, ""), S("", 1.5, ""))),
        ("cf1 go to 1, 2 and 1.5", "cf1", "goto", (S("", 1, ""), S("", 2, ""), S("", 1.5, ""))),
        (
            "cf1 goto x=1 m y=-2 z=1.5",
            "cf1",
            "goto",
            (S("x", 1, "m"), S("y", -2, ""), S("z", 1.5, "")),
        ),
        ("/move omni 1 m", "omni", "move", (S("", 1, "m"),)),
        ("/move@lab_robots_bot omni 1 m", "omni", "move", (S("", 1, "m"),)),
        ("/omni move 1 m", "omni", "move", (S("", 1, "m"),)),
        ("move the omni 1 m", "omni", "move", (S("", 1, "m"),)),
        ("take off cf2 1 m", "cf2", "takeoff", (S("", 1, "m"),)),
        ("move 1 m", "omni", "move", (S("", 1, "m"),)),
        ("grasp", "kuka1", "grasp", ()),
        ("film", "cf1", "film", ()),
    ],
)
def test_a_command(
    means: Means, text: str, robot: str, skill: str, spoken: tuple[SpokenValue, ...]
) -> None:
    assert done(means(text)) == ((robot,), skill, spoken)


def test_a_command_keeps_what_was_typed(means: Means) -> None:
    line = means("  Omni move 1 m\u200b please ")

    assert isinstance(line, Do)
    assert line.text == "Omni move 1 m please"


def test_a_group_is_its_visible_members_that_can(means: Means) -> None:
    line = means("crazyflies takeoff 1 m")
    assert isinstance(line, Do)
    assert (line.group, line.robots) == ("crazyflies", ("cf1", "cf2", "cf3"))
    assert [skill.id for skill in line.skills] == ["takeoff"] * 3

    line = means("crazyflies takeoff 1 m", visible=frozenset({"omni", "cf3", "cf1"}))
    assert isinstance(line, Do)
    assert line.robots == ("cf1", "cf3")

    line = means("crazyflies film")
    assert isinstance(line, Do)
    assert (line.group, line.robots) == ("crazyflies", ("cf1",))


def test_a_chosen_robot_needs_no_name(means: Means) -> None:
    assert done(means("move 1 m", "omni"))[0] == ("omni",)
    assert done(means("takeoff 1 m", "cf2"))[0] == ("cf2",)
    assert done(means("takeoff", "crazyflies"))[0] == ("cf1", "cf2", "cf3")
    assert done(means("kuka1 grasp", "omni"))[0] == ("kuka1",)
    assert means("status", "omni") == Status(("omni",))
    assert means("status all", "cf2", frozenset({"cf2", "omni"})) == Status(("omni", "cf2"))
    assert means("resume", "omni") == Resume(("omni",))


def test_a_chosen_robot_that_is_no_longer_visible_is_not_chosen(means: Means) -> None:
    line = means("takeoff", "cf2", frozenset({"cf1", "omni"}))

    assert done(line)[0] == ("cf1",)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("status", Status()),
        ("/status", Status()),
        ("STATUS?", Status()),
        ("status omni", Status(("omni",))),
        ("omni status", Status(("omni",))),
        ("status of omni and KUKA iiwa", Status(("omni", "kuka1"))),
        ("status crazyflies", Status(("cf1", "cf2", "cf3"))),
        ("help", Help()),
        ("/help@lab_robots_bot", Help()),
        ("help omni", Help("omni")),
        ("help with crazyflies", Help("crazyflies")),
        ("omni", Help("omni")),
        ("omni help", Help("omni")),
        ("robots", Robots()),
        ("use omni", Use("omni")),
        ("/use KUKA iiwa", Use("kuka1")),
        ("use crazyflies", Use("crazyflies")),
        ("use", Use()),
        ("use nothing", Use()),
        ("resume omni", Resume(("omni",), named=True)),
        ("omni resume", Resume(("omni",), named=True)),
        ("resume crazyflies and omni", Resume(("cf1", "cf2", "cf3", "omni"), named=True)),
        ("resume", Resume()),
        ("/start", Start()),
        ("/start aZ9-_x", Start("aZ9-_x")),
    ],
)
def test_a_verb(means: Means, text: str, line: Line) -> None:
    assert means(text) == line


@pytest.mark.parametrize(
    ("text", "spared"),
    [
        ("resume all but omni", {"omni"}),
        ("/resume all except omni and kuka1", {"omni", "kuka1"}),
        ("resume everything but the crazyflies", {"cf1", "cf2", "cf3"}),
        ("resume everyone, except for omni!", {"omni"}),
        ("resume all apart from cf1", {"cf1"}),
        ("resume alle außer omni", {"omni"}),
        ("resume alles bis auf omni und cf2", {"omni", "cf2"}),
        ("resume alle roboter wieder ohne KUKA iiwa", {"kuka1"}),
        ("resume all now", set()),
        ("resume omni and all", set()),
    ],
)
def test_who_is_left_out_stays_as_they_are(
    means: Means, everyone: frozenset[str], text: str, spared: set[str]
) -> None:
    line = means(text)
    assert isinstance(line, Resume), line
    assert set(line.robots) == everyone - spared
    assert set(line.spared) == spared
    assert not line.named
    assert means(text.replace("resume", "status", 1)) == Status(line.robots)


def test_all_before_a_name_is_all_of_that_name(means: Means) -> None:
    drones = ("cf1", "cf2", "cf3")
    assert means("resume all crazyflies") == Resume(drones, named=True)
    assert means("resume crazyflies except cf2") == Resume(("cf1", "cf3"), True, ("cf2",))
    assert means("resume all of omni", "cf1") == Resume(("omni",), named=True)


@pytest.mark.parametrize(
    "text",
    [
        "resume all foo bar",
        "/resume all but",
        "resume all but nobody's",
        "resume all but omni later",
        "resume all but all",
        "resume everything but the drones",
        "resume omni but omni",
        "resume not omni",
        "resume but omni",
        "resume all in 5 minutes",
        "use omni later",
        "use omni and kuka1",
    ],
)
def test_no_word_behind_a_verb_is_left_out(means: Means, text: str) -> None:
    line = means(text)
    assert isinstance(line, Misunderstood), line
    assert all(not isinstance(means(offer), Misunderstood) for offer in line.offers)


def test_who_is_not_seen_is_left_out_by_no_name(means: Means) -> None:
    line = means("resume all but kuka1", "", frozenset({"omni", "cf1"}))
    assert isinstance(line, Misunderstood)
    assert "kuka1" not in " ".join(line.offers)


def test_several_lines_keep_their_order(vocabulary: Vocabulary, everyone: frozenset[str]) -> None:
    lines = understand(
        "omni move 1 m\r\n\n  \nmvoe\nstatus\nstop omni", vocabulary, LineContext("", everyone)
    )

    assert [type(line) for line in lines] == [Do, Misunderstood, Status, Halt]
    assert lines[-1] == Halt(("omni",))


@pytest.mark.parametrize(
    ("text", "selected", "name", "named"),
    [
        ("omni move 1 m", "", "omni", True),
        ("please omni, move 1 m", "", "omni", True),
        ("move omni 1 m", "", "omni", True),
        ("omni move 1 m", "omni", "omni", True),
        ("rover move 1 m", "kuka1", "omni", True),
        ("crazyflies takeoff", "", "crazyflies", True),
        ("takeoff crazyflies", "", "crazyflies", True),
        ("move 1 m", "omni", "omni", False),
        ("/move 1 m", "omni", "omni", False),
        ("takeoff", "crazyflies", "crazyflies", False),
        ("handover", "", "yumi", False),
        ("echo Hello there", "", "echo", True),
        ("echo say Hello there", "", "echo", True),
        ("Hello there", "echo", "echo", False),
        ("say Hello there", "echo", "echo", False),
    ],
)
def test_an_order_knows_whether_its_line_names_whom_it_is_for(
    means: Means, text: str, selected: str, name: str, named: bool
) -> None:
    line = means(text, selected)
    assert isinstance(line, Do)
    assert (line.name, line.named) == (name, named)


@pytest.mark.parametrize(
    ("text", "understood"),
    [
        ("omni move 1 m", True),
        ("omni move 40 m", True),
        ("omni turn", True),
        ("crazyflies takeoff 1 m", True),
        ("stop", True),
        ("status", True),
        ("echo Hello there", True),
        ("say Hello there", True),
        ("Hello there", False),
        ("/mvoe", False),
        ("omni mvoe 1 m", False),
        ("omni move was what I meant", False),
        ("omni move 1 kg", False),
        ("crazyflies takeoff is at noon", False),
    ],
)
def test_what_is_surely_a_command_is_read_to_its_end(
    means: Means, vocabulary: Vocabulary, text: str, understood: bool
) -> None:
    assert is_understood(means(text, "echo"), vocabulary) is understood


class TestDialogue:
    def text(self, line: Line) -> str:
        robots, skill, spoken = done(line)
        assert (robots, skill) == (("echo",), "say")
        (value,) = spoken
        assert (value.name, value.number) == ("text", None)
        return value.word

    @pytest.mark.parametrize(
        "text", ["echo Hello there,  you = 5!", "echo say Hello there,  you = 5!"]
    )
    def test_a_text_reaches_the_robot_as_it_was_typed(self, means: Means, text: str) -> None:
        assert self.text(means(text)) == "Hello there,  you = 5!"

    def test_a_chosen_robot_hears_what_means_nothing_else(self, means: Means) -> None:
        assert self.text(means("What is it?", "echo")) == "What is it?"
        assert self.text(means("word " * 100, "echo")) == ("word " * 100).strip()
        assert means("status", "echo") == Status(("echo",))
        assert done(means("omni move 1 m", "echo"))[0] == ("omni",)
        assert isinstance(means("omni mvoe 1 m", "echo"), Misunderstood)
        assert isinstance(means("/mvoe", "echo"), Misunderstood)

    def test_a_stop_is_not_said_to_it(self, means: Means) -> None:
        assert means("stop", "echo") == Halt()
        assert means("echo stop") == Halt(("echo",))


def test_numbers_are_not_joined_by_their_typography(means: Means) -> None:
    # Under NFKC alone these would be 102 and 112.
    assert done(means("omni move 10² cm"))[2][0] == S("", None, "10²")
    assert done(means("omni move 1½ m"))[2][0] == S("", None, "1½")


@pytest.mark.parametrize(
    "text",
    [
        "omni battery",
        "omni where",
        "where is omni",
        "Where is omni?",
        "battery omni",
        "wo ist omni",
    ],
)
def test_where_a_robot_is_and_how_charged_is_said_by_its_status(means: Means, text: str) -> None:
    assert means(text) == Status(("omni",))


@pytest.mark.parametrize("text", ["where is my coffee", "where", "battery", "omni where to"])
def test_what_names_no_robot_or_says_more_asks_for_no_status(means: Means, text: str) -> None:
    assert not isinstance(means(text, "omni"), Status)
