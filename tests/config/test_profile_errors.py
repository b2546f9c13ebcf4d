"""Each sentence about a profile, by a file that causes it, on the line that is to blame."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.config.profiles import check_profile, load_profile, read_profile
from rosic.errors import ConfigurationError
from tests.config.profile_text import DIALOGUE, GOOD, MARK, marked_line, spoil, write

if TYPE_CHECKING:
    from pathlib import Path
from tests.config.profile_error_cases import CASES, Case
from tests.config.profile_error_cases_of_skills import MORE_CASES

ALL = [*CASES, *MORE_CASES]


def test_the_profile_that_is_spoilt_here_was_good(tmp_path: Path) -> None:
    for text in (GOOD, DIALOGUE):
        assert [str(error) for error in check_profile(write(tmp_path, text))] == []


@pytest.mark.parametrize("case", ALL, ids=[case.name for case in ALL])
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


@pytest.mark.parametrize("case", ALL, ids=[case.name for case in ALL])
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


@pytest.mark.parametrize(
    ("release", "advised"), [("", True), (", release: { data: false }", False)]
)
def test_a_stop_that_may_hold_and_that_nothing_releases_is_named(
    release: str, tmp_path: Path, *, advised: bool
) -> None:
    stop = f"type: std_srvs/srv/SetBool, request: {{ data: true }}{release}"
    read = read_profile(write(tmp_path, spoil("type: std_srvs/srv/Trigger", stop)))
    assert read.errors == []
    told = (
        "If the stop /rover/stop holds until it is told otherwise, nothing releases it: after a "
        "resume the robot would not move. Write release: { data: false } in that case."
    )
    assert [str(advice).partition(": ")[2] for advice in read.advice] == [told] * advised


def test_an_axis_that_is_driven_and_not_measured_is_named(tmp_path: Path) -> None:
    text = spoil("{ linear.x: $speed }", "{ linear.x: $speed, angular.z: 0.1 }")
    text = spoil(", twist.twist.angular.z", "", text)
    read = read_profile(write(tmp_path, text))
    assert read.errors == []
    [advice] = read.advice
    assert "'drive' sends angular.z, which 'at_rest' does not measure" in str(advice)
    assert "Add the field that ends in angular.z" in str(advice)


def test_an_answer_that_nothing_judges_is_named_with_what_looks_like_its_code(
    tmp_path: Path,
) -> None:
    pytest.importorskip("action_msgs.srv", reason="ROS 2 is not here")
    call = "    service: {{ name: /rover/call, type: action_msgs/srv/CancelGoal{more} }}\n"
    for more, advised in (("", 1), (", success: return_code, good: 0", 0)):
        skill = "skills:\n  call_off:\n    class: task\n" + call.format(more=more)
        read = read_profile(write(tmp_path, spoil("skills:\n", skill)))
        assert read.errors == []
        told = (
            "Nothing says by which field an answer of 'call_off' tells success: whatever it "
            "answers reads as done. In action_msgs/srv/CancelGoal, return_code (int8) looks like "
            "it: write success: return_code and good: the number that means success."
        )
        assert [str(advice).partition(": ")[2] for advice in read.advice] == [told] * advised
