"""Wishes as people write them: every line gives a wish, or one sentence that says what is wrong."""

from __future__ import annotations

import json

import pytest

from rosic.core.local_time import LocalTime
from rosic.organiser.planning.figures import plan_text
from rosic.organiser.planning.greedy import first_come_first_served
from rosic.organiser.planning.problem import LeftOverReason, PlanningProblem
from rosic.organiser.planning.solver import propose
from rosic.organiser.planning.wish_file import (
    MOST_CHARACTERS,
    MOST_WISHES,
    WishNames,
    opening_hours,
    wishes_from_csv,
    wishes_from_json,
)
from rosic.organiser.timezones import zone_named

HEADING = "person,robots,length,earliest,latest,priority\n"
MIN = 60_000_000_000
VIENNA = zone_named("Europe/Vienna")
ROBOTS = {"kuka1": ("kuka1",), "yumi": ("yumi",), "arms": ("kuka1", "yumi")}
NAMES = WishNames(ROBOTS, VIENNA, {"Ann": "p1", "Bob": "p2"})


def test_a_table_is_read() -> None:
    read = wishes_from_csv(
        "\ufeff"
        + HEADING
        + "Ann,kuka1,90,2026-11-02 14:00,2026-11-02 16:00,2\n\n"
        + '"Bob",arms,1 h 30 min,2026-11-03,2026-11-04,\n',
        "week.csv",
        NAMES,
    )

    ann, bob = read.wishes
    assert read.complaints == ()
    assert (ann.id, ann.principal, ann.robots, ann.priority) == ("week.csv:2", "p1", ("kuka1",), 2)
    assert (ann.length_s, ann.latest_ns - ann.earliest_ns) == (5400, 120 * MIN)
    assert VIENNA.local(ann.earliest_ns) == LocalTime(2026, 11, 2, 14, 0)
    assert (bob.robots, bob.length_s, bob.priority) == (("kuka1", "yumi"), 5400, 1)
    assert bob.latest_ns - bob.earliest_ns == 2 * 24 * 60 * MIN  # to the end of the last day


def test_semicolons_do_and_so_does_another_order_of_columns() -> None:
    text = "latest;earliest;person;length;robots\n2026-11-02 16:00;2026-11-02 14:00;Ann;2h;yumi\n"

    (wish,) = wishes_from_csv(text, "week.csv", NAMES).wishes

    assert (wish.robots, wish.length_s) == (("yumi",), 7200)


def test_a_list_of_objects_is_read_and_bad_ones_are_named_by_their_line() -> None:
    text = """[
      {"person": "Ann", "robots": ["arms", "yumi"], "length": 30,
       "earliest": "2026-11-02T14:00+01:00", "latest": "2026-11-02T15:00Z", "priority": 3},
      {"person": "Bob"},
      7
    ]"""

    read = wishes_from_json(text, "week.json", NAMES)

    (wish,) = read.wishes
    assert (wish.id, wish.robots, wish.priority) == ("week.json:2", ("kuka1", "yumi"), 3)
    assert wish.latest_ns - wish.earliest_ns == 120 * MIN
    assert read.complaints == (
        "week.json:4: The earliest is missing.",
        "week.json:5: The earliest is missing.",
    )


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("Ann,hal,30,2026-11-02,2026-11-03,", 'I know no robot called "hal".'),
        ("Eve,yumi,30,2026-11-02,2026-11-03,", 'I know nobody called "Eve".'),
        ("Ann,yumi,,2026-11-02,2026-11-03,", "The length is missing."),
        ("Ann,yumi,30,2026-11-02", "The latest is missing."),
        (
            "Ann,yumi,0,2026-11-02,2026-11-03,",
            '"0" is not a length: write 90 or 1 h 30 min, up to 7 days.',
        ),
        (
            "Ann,yumi,-5,2026-11-02,2026-11-03,",
            '"-5" is not a length: write 90 or 1 h 30 min, up to 7 days.',
        ),
        (
            "Ann,yumi,\u0663\u0660,2026-11-02,2026-11-03,",
            '"\u0663\u0660" is not a length: write 90 or 1 h 30 min, up to 7 days.',
        ),
        (
            "Ann,yumi,30,tomorrow,2026-11-03,",
            '"tomorrow" is not a time: write 2026-11-02 14:00.',
        ),
        ("Ann,yumi,30,0001-01-01,2026-11-03,", '"0001-01-01" is too far away.'),
        ("Ann,yumi,30,2026-11-03,2026-11-01,", "The window ends before it begins."),
        (
            "Ann,yumi,90,2026-11-02 14:00,2026-11-02 15:00,",
            "The window is shorter than 90.",
        ),
        ("Ann,yumi,30,2026-01-01,2026-12-31,", "A window may be 62 days wide at most."),
        ("Ann,yumi,30,2026-11-02,2026-11-03,9", "A priority is a number from 1 to 5."),
        (
            "Ann,yumi,30,2026-03-29 02:30,2026-03-29 06:00,",
            '"2026-03-29 02:30" does not exist: the clocks go forward then.',
        ),
        (
            "Ann,yumi,30,2026-10-25 02:30,2026-10-25 06:00,",
            (
                '"2026-10-25 02:30" comes twice, because the clocks go back. '
                "The first is 00:30 UTC: write 2026-10-25 00:30Z for that, or an hour more."
            ),
        ),
    ],
)
def test_one_sentence_for_a_line_that_is_wrong(line: str, sentence: str) -> None:
    good = "Bob,kuka1,30,2026-11-02,2026-11-02,\n"

    read = wishes_from_csv(f"{HEADING}{good}{line}\n{good}", "week.csv", NAMES)

    assert read.complaints == (f"week.csv:3: {sentence}",)
    assert len(read.wishes) == 2


def test_what_the_sentence_about_a_time_that_comes_twice_offers_is_accepted() -> None:
    line = "Ann,yumi,30,2026-10-25 00:30Z,2026-10-25 06:00,\n"

    (wish,) = wishes_from_csv(HEADING + line, "week.csv", NAMES).wishes

    assert VIENNA.local(wish.earliest_ns) == LocalTime(2026, 10, 25, 2, 30)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "f:1: The first line names the columns: person, robots, length, earliest, latest."),
        ("person,robots\n", "f:1: There is no column length. The first line names them."),
        (HEADING + 'Ann,"yumi,30', "f:2: This is not a table: unexpected end of data."),
        ("x" * (MOST_CHARACTERS + 1), f"f:1: This is longer than {MOST_CHARACTERS} characters."),
    ],
)
def test_a_table_that_is_none(text: str, complaint: str) -> None:
    assert wishes_from_csv(text, "f", NAMES) == ((), (complaint,))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "f:1: A list of wishes begins with [."),
        ("{}", "f:1: A list of wishes begins with [."),
        ("[\n{", "f:2: This is not JSON: Expecting property name enclosed in double quotes."),
        ("[\n\n", "f:3: This is not JSON: Expecting value."),
        ("[\n" + "[" * 100_000, "f:2: This is not a wish."),
        ("[\n" + "9" * 5_000, "f:2: This is not a wish."),
    ],
)
def test_a_list_that_is_none(text: str, complaint: str) -> None:
    assert wishes_from_json(text, "f", NAMES) == ((), (complaint,))


def test_strange_values_give_sentences_too() -> None:
    strange: list[object] = [None, True, 1.5, [], {}, [1], "\x00", "\ud800", 10**30]
    fine = {
        "person": "Ann",
        "robots": "yumi",
        "length": 30,
        "earliest": "2026-11-02",
        "latest": "2026-11-03",
        "priority": 1,
    }
    for key in fine:
        for value in strange:
            read = wishes_from_json(json.dumps([fine | {key: value}]), "f", NAMES)
            assert len(read.wishes) + len(read.complaints) == 1
            assert read.complaints or (key, value) == ("priority", None)


def test_no_more_wishes_are_read_than_can_be_planned() -> None:
    line = "Ann,yumi,30,2026-11-02,2026-11-03,\n"

    read = wishes_from_csv(HEADING + line * (MOST_WISHES + 5), "f", NAMES)

    assert len(read.wishes) == MOST_WISHES
    assert read.complaints == (
        f"f:{MOST_WISHES + 2}: Only {MOST_WISHES} wishes are planned at a time.",
    )


# ---- the weeks in which the clocks change ----


def days(first: LocalTime, count: int) -> range:
    return range(first.day_number, first.day_number + count)


def test_opening_hours_follow_the_clock_on_the_wall() -> None:
    spans = opening_hours(days(LocalTime(2026, 3, 28), 3), 8 * 60, 18 * 60, VIENNA)
    nights = opening_hours(days(LocalTime(2026, 3, 28), 1), 22 * 60, 30 * 60, VIENNA)

    assert [VIENNA.local(begin).time_text() for begin, _ in spans] == ["08:00"] * 3
    assert (spans[1][0] - spans[0][0]) // MIN == 23 * 60
    assert (nights[0][1] - nights[0][0]) // MIN == 7 * 60


@pytest.mark.parametrize(
    ("day", "real_min"), [("2026-03-29", 120), ("2026-03-30", 180), ("2026-10-25", 240)]
)
def test_a_slot_is_as_long_as_it_says_on_the_day_the_clocks_change(day: str, real_min: int) -> None:
    """Between one and four at night are two, three or four hours."""
    lines = "".join(
        f"Ann,yumi,{length},{day} 01:00,{day} 04:00,\n" for length in (real_min, real_min + 30)
    )
    read = wishes_from_csv(HEADING + lines, "f", NAMES)
    year, month, date = map(int, day.split("-"))
    problem = PlanningProblem(
        wishes=read.wishes,
        robots=("yumi",),
        openings=opening_hours(days(LocalTime(year, month, date), 1), 0, 24 * 60, VIENNA),
    )

    assert read.complaints == (f"f:3: The window is shorter than {real_min + 30}.",)
    for plan in (first_come_first_served(problem), propose(problem)):
        (given,) = plan.allocations
        assert (given.end_ns - given.start_ns) // MIN == real_min
        assert "  01:00 to 04:00  yumi  p1" in plan_text(plan, zone=VIENNA)


def test_a_night_that_the_clocks_make_shorter_does_not_hold_a_long_slot() -> None:
    text = HEADING + "Ann,yumi,8h,2026-03-28 12:00,2026-03-29 12:00,\n"
    wishes = wishes_from_csv(text, "f", NAMES).wishes
    night = opening_hours(days(LocalTime(2026, 3, 28), 1), 22 * 60, 30 * 60, VIENNA)

    plan = propose(PlanningProblem(wishes=wishes, robots=("yumi",), openings=night))

    assert [left.why for left in plan.left] == [LeftOverReason.CLOSED]
