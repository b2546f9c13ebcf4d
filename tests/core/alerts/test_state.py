"""An alarm as it goes through time, beside a few lines that say the same of a whole history."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.core.alerts.state import (
    TOLD_AT_MOST,
    AlertEvent,
    AlertReading,
    AlertTimes,
    AlertWatch,
    Phase,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

S = 1_000_000_000
BAD, BETWEEN, GOOD, MISSING = (
    AlertReading.BAD,
    AlertReading.BETWEEN,
    AlertReading.GOOD,
    AlertReading.MISSING,
)


class Look(NamedTuple):
    """One look at the robot."""

    at_ns: int
    reading: AlertReading
    muted: bool = False


def _history(steps: Sequence[tuple[int, AlertReading, bool]]) -> list[Look]:
    at, looks = 0, []
    for gap, reading, muted in steps:
        at += gap * S
        looks.append(Look(at, reading, muted))
    return looks


LOOKS = st.lists(
    st.tuples(
        st.integers(0, 4),
        st.sampled_from([BAD, BAD, BAD, BETWEEN, GOOD, MISSING]),
        st.booleans(),
    ),
    max_size=60,
).map(_history)
PACES = st.builds(
    AlertTimes, st.integers(0, 8).map(lambda s: s * S), st.sampled_from([0, 3 * S, 10 * S])
)


def raised_at(looks: Sequence[Look], lasting_ns: int) -> list[bool]:
    """Say of each look whether an alarm is open then: the rule in one sentence.

    Open from a look that ends an unbroken row of bad ones as long as wanted, until a good one.
    """
    found: list[bool] = []
    for i, look in enumerate(looks):
        row = i
        while row and looks[row - 1].reading is BAD and look.reading is BAD:
            row -= 1
        begins = look.reading is BAD and look.at_ns - looks[row].at_ns >= lasting_ns
        stays = bool(found) and found[-1] and look.reading is not GOOD
        found.append(begins or stays)
    return found


@given(LOOKS, PACES)
@settings(max_examples=400)
def test_it_is_open_exactly_when_the_history_says(looks: list[Look], pace: AlertTimes) -> None:
    watch = AlertWatch(pace)
    opened = []
    for look in looks:
        watch.feed(look.reading, look.at_ns, muted=look.muted)
        opened.append(watch.open)
    assert opened == raised_at(looks, pace.lasting_ns)


@given(LOOKS, PACES)
@settings(max_examples=400)
def test_it_is_told_once_at_the_beginning_and_once_at_the_end(
    looks: list[Look], pace: AlertTimes
) -> None:
    watch, told = AlertWatch(pace), []
    for look in looks:
        event = watch.feed(look.reading, look.at_ns, muted=look.muted)
        if event is not None:
            assert event is AlertEvent.CLEARED or not look.muted
            told.append(event)
    edges = [event for event in told if event is not AlertEvent.ESCALATED]
    assert (
        edges
        == [AlertEvent.RAISED, AlertEvent.CLEARED] * (len(edges) // 2) + edges[len(edges) & ~1 :]
    )
    assert edges[len(edges) & ~1 :] in ([], [AlertEvent.RAISED])
    for before, event in zip([None, *told], told, strict=False):
        assert event is not AlertEvent.ESCALATED or before in {
            AlertEvent.RAISED,
            AlertEvent.ESCALATED,
        }


@given(LOOKS, PACES, st.sets(st.integers(0, 59), max_size=6))
@settings(max_examples=300)
def test_what_was_seen_is_told_no_more_until_it_is_over(
    looks: list[Look], pace: AlertTimes, seen: set[int]
) -> None:
    watch, quiet = AlertWatch(pace), False
    for i, look in enumerate(looks):
        event = watch.feed(look.reading, look.at_ns, muted=look.muted)
        assert not quiet or event in {None, AlertEvent.CLEARED}
        quiet = quiet and watch.open
        if i in seen and watch.acknowledge():
            quiet = True
        assert quiet == (watch.phase is Phase.ACKNOWLEDGED)


@given(LOOKS, PACES)
@settings(max_examples=300)
def test_escalations_keep_their_distance_and_end(looks: list[Look], pace: AlertTimes) -> None:
    watch, last_ns, count = AlertWatch(pace), 0, 0
    for look in looks:
        event = watch.feed(look.reading, look.at_ns, muted=look.muted)
        if event is AlertEvent.ESCALATED:
            assert pace.escalate_ns
            assert look.at_ns - last_ns >= pace.escalate_ns
            count += 1
            assert watch.level == count < TOLD_AT_MOST
        elif event is AlertEvent.RAISED:
            count = 0
        if event is not None:
            last_ns = look.at_ns


def feed(watch: AlertWatch, *looks: tuple[int, AlertReading]) -> list[AlertEvent | None]:
    return [watch.feed(reading, at_s * S) for at_s, reading in looks]


def test_a_single_good_look_begins_the_waiting_anew() -> None:
    watch = AlertWatch(AlertTimes(5 * S))
    assert feed(watch, (0, BAD), (4, GOOD), (5, BAD), (9, BAD), (10, BAD)) == [
        None,
        None,
        None,
        None,
        AlertEvent.RAISED,
    ]


@pytest.mark.parametrize("gap", [BETWEEN, MISSING])
def test_what_is_neither_bad_nor_good_ends_no_alarm_and_begins_none(gap: AlertReading) -> None:
    watch = AlertWatch(AlertTimes(5 * S))
    assert not any(feed(watch, (0, BAD), (3, gap), (6, BAD), (9, gap)))
    assert feed(watch, (10, BAD), (15, BAD), (16, gap), (17, BAD), (18, GOOD)) == [
        None,
        AlertEvent.RAISED,
        None,
        None,
        AlertEvent.CLEARED,
    ]


def test_it_goes_on_being_told_a_bounded_number_of_times() -> None:
    watch = AlertWatch(AlertTimes(0, 60 * S))
    events = [watch.feed(BAD, minute * 60 * S) for minute in range(100)]
    assert sum(event is not None for event in events) == TOLD_AT_MOST


def test_what_is_muted_is_told_when_that_ends_and_what_is_over_then_is_not() -> None:
    watch = AlertWatch(AlertTimes(0))
    assert watch.feed(BAD, 0, muted=True) is None
    assert watch.feed(GOOD, S, muted=True) is None
    assert watch.feed(BAD, 2 * S, muted=True) is None
    assert watch.feed(BAD, 3 * S) is AlertEvent.RAISED
    watch.hush()
    assert watch.feed(BAD, 4 * S, muted=True) is None
    assert watch.feed(BAD, 5 * S) is AlertEvent.AGAIN
    watch.hush()
    assert watch.feed(GOOD, 6 * S, muted=True) is AlertEvent.CLEARED


def test_an_alarm_of_an_earlier_run_is_told_again_unless_it_was_seen() -> None:
    watch = AlertWatch(AlertTimes(5 * S))
    watch.restore(100 * S, acknowledged=False, level=0)
    assert feed(watch, (100, BAD), (101, BAD), (102, GOOD)) == [
        AlertEvent.AGAIN,
        None,
        AlertEvent.CLEARED,
    ]
    watch = AlertWatch(AlertTimes(5 * S, 60 * S))
    watch.restore(100 * S, acknowledged=True, level=0)
    assert feed(watch, (100, BAD), (900, BAD), (901, GOOD)) == [None, None, AlertEvent.CLEARED]


def test_after_a_restart_a_robot_that_was_not_heard_yet_may_still_say_that_it_is_over() -> None:
    watch = AlertWatch(AlertTimes(5 * S))
    watch.restore(100 * S, acknowledged=False, level=0)
    assert feed(watch, (101, MISSING), (102, GOOD)) == [None, AlertEvent.CLEARED]
    watch.restore(100 * S, acknowledged=False, level=0)
    assert feed(watch, (101, MISSING), (105, MISSING)) == [None, AlertEvent.AGAIN]
