"""When we have listened without a gap, and when not: see the docstring of `Inbound`."""

from __future__ import annotations

import pytest

from rosic.core.time_units import SECOND_NS
from rosic.messengers.telegram.errors import NetworkState
from rosic.messengers.telegram.polling_gap import (
    BETWEEN_NS,
    CALM_NS,
    GRACE_NS,
    SHORT_POLLS,
    Outage,
    PollingGap,
    PollMoment,
)

START = PollMoment(1_700_000_000 * SECOND_NS, 50 * SECOND_NS)


def after(seconds: float, *, wall_also: float = 0.0) -> PollMoment:
    ns = int(seconds * SECOND_NS)
    return PollMoment(START.wall_ns + ns + int(wall_also * SECOND_NS), START.monotonic_ns + ns)


def thawed() -> PollingGap:
    listening = PollingGap()
    listening.answered(START)
    assert listening.drained(START, empty=True, full=False)
    return listening


def is_backlog(listening: PollingGap, received_ns: int) -> bool:
    return received_ns < listening.stamp(received_ns)


def test_everything_is_backlog_until_a_poll_comes_back_empty() -> None:
    listening = PollingGap()
    listening.answered(START)
    assert is_backlog(listening, START.wall_ns)
    assert not listening.drained(START, empty=False, full=True)
    assert is_backlog(listening, START.wall_ns)
    assert listening.drained(after(1), empty=True, full=False)
    assert not is_backlog(listening, after(2).wall_ns)


def test_with_people_writing_all_the_time_a_few_short_polls_will_do() -> None:
    listening = PollingGap()
    results = [listening.drained(START, empty=False, full=False) for _ in range(SHORT_POLLS)]
    assert results == [False] * (SHORT_POLLS - 1) + [True]


def test_a_full_answer_that_was_seen_before_hides_what_is_behind_it() -> None:
    listening = PollingGap()
    assert not listening.drained(START, empty=True, full=True)


def test_a_message_sent_in_the_very_second_of_thawing_is_fresh() -> None:
    listening = thawed()
    sent_ns = START.wall_ns // SECOND_NS * SECOND_NS
    assert listening.stamp(after(0.3).wall_ns) <= sent_ns
    assert listening.stamp(after(0.3).wall_ns) == START.wall_ns - GRACE_NS


def test_five_seconds_without_an_answer_are_a_gap() -> None:
    listening = thawed()
    listening.answered(after(4.9))
    assert not listening.frozen
    listening.answered(after(4.9 + 5.1))
    assert listening.frozen


def test_a_clock_that_is_set_or_a_machine_that_slept_is_a_gap() -> None:
    for seconds in (3.0, -3.0, 3600.0):
        listening = thawed()
        listening.answered(after(1, wall_also=seconds))
        assert listening.frozen, seconds
    listening = thawed()
    listening.answered(after(1, wall_also=0.5))
    assert not listening.frozen


def test_somebody_else_receiving_freezes_until_it_has_been_calm_for_a_while() -> None:
    listening = thawed()
    listening.contested(after(1))
    calm_s = 1 + CALM_NS / SECOND_NS
    assert is_backlog(listening, after(1).wall_ns)
    assert not listening.drained(after(2), empty=True, full=False)
    assert not listening.calm(after(calm_s - 0.1))
    assert listening.drained(after(calm_s), empty=True, full=False)


S = SECOND_NS


def at(seconds: float, *, wall_ahead_ns: int = 0, more_ns: int = 0) -> PollMoment:
    passed_ns = int(seconds * S) + more_ns
    return PollMoment(1_000 * S + passed_ns + wall_ahead_ns, passed_ns)


def thawed_at_20() -> PollingGap:
    listening = PollingGap()
    listening.answered(at(20))
    assert listening.drained(at(20), empty=True, full=False) is True
    return listening


@pytest.mark.parametrize(
    ("later", "frozen"),
    [
        (at(25), False),
        (at(25, more_ns=1), True),
        (at(21, wall_ahead_ns=2 * S), False),
        (at(21, wall_ahead_ns=2 * S + 1), True),
        (at(21, wall_ahead_ns=-2 * S), False),
        (at(21, wall_ahead_ns=-2 * S - 1), True),
    ],
)
def test_a_gap_and_a_clock_that_was_set_begin_to_the_nanosecond(
    later: PollMoment, *, frozen: bool
) -> None:
    listening = thawed_at_20()
    listening.answered(later)
    assert listening.frozen is frozen


def test_who_listens_already_does_not_begin_anew_with_every_empty_poll() -> None:
    listening = thawed_at_20()
    since_ns = listening.since_ns
    assert listening.drained(at(24), empty=True, full=False) is False
    assert listening.since_ns == since_ns


def drained(listening: PollingGap, *full: bool) -> list[bool]:
    return [listening.drained(at(60), empty=False, full=each) for each in full]


def test_three_polls_in_a_row_that_were_not_full_show_that_nothing_waits() -> None:
    assert drained(PollingGap(), False, False, False) == [False, False, True]
    broken = (False, False, True, False, False, False)
    assert drained(PollingGap(), *broken) == [False, False, False, False, False, True]


def test_after_a_gap_the_polls_are_counted_anew() -> None:
    listening = PollingGap()
    assert drained(listening, False, False) == [False, False]
    listening.contested(at(30))
    assert drained(listening, False, False, False) == [False, False, True]


# ---- when the network was away ----

AWAY, SILENT, THERE = NetworkState.AWAY, NetworkState.SILENT, NetworkState.THERE
WITHIN_S = 40.0


def polled(*shown: NetworkState) -> Outage:
    """Return what is known after polls that failed at 0, 10, 20 ... s; one at 100 s is answered."""
    outage = Outage()
    for number, network in enumerate(shown):
        outage.failed(after(number * 10), after(number * 10 + 5), network, WITHIN_S)
    outage.answered(after(100))
    return outage


@pytest.mark.parametrize(
    ("shown", "said"),
    [
        ((AWAY,), True),
        ((SILENT, AWAY, AWAY), True),
        ((AWAY, SILENT), True),
        ((), False),
        ((SILENT, SILENT), False),
        ((THERE,), False),
        ((AWAY, THERE), False),
        ((THERE, AWAY), False),
    ],
)
def test_the_network_was_away_if_there_was_no_way_and_nobody_answered(
    shown: tuple[NetworkState, ...], said: bool
) -> None:
    outage = polled(*shown)
    assert outage.covers(after(50).wall_ns) is said
    assert outage.covers(after(0).wall_ns) is said, "from the first poll that failed"
    assert not outage.covers(after(-1).wall_ns), "sent before"
    assert not outage.covers(after(99.5).wall_ns), "perhaps sent after"
    outage.over()
    assert not outage.covers(after(50).wall_ns)


def test_of_a_time_in_which_we_did_not_run_nothing_is_said() -> None:
    outage = Outage()
    outage.failed(after(0), after(0, wall_also=8 * 3600), AWAY, WITHIN_S)  # asleep while it asked
    outage.answered(after(10, wall_also=8 * 3600))
    assert not outage.covers(after(3600).wall_ns)
    assert outage.covers(after(2, wall_also=8 * 3600).wall_ns)

    outage = Outage()
    outage.failed(after(0), after(1), AWAY, WITHIN_S)
    outage.failed(after(7200), after(7201), AWAY, WITHIN_S)  # asleep between two
    outage.answered(after(7210))
    assert not outage.covers(after(3600).wall_ns)
    assert outage.covers(after(7202).wall_ns)


@pytest.mark.parametrize(("more_ns", "one"), [(0, True), (1, False)])
def test_polls_that_far_apart_are_of_one_outage_and_no_further(more_ns: int, *, one: bool) -> None:
    outage = Outage()
    outage.failed(at(0), at(1), AWAY, WITHIN_S)
    again = at(1, more_ns=BETWEEN_NS + more_ns)
    outage.failed(again, again, AWAY, WITHIN_S)
    outage.answered(at(80))
    assert outage.covers(at(30).wall_ns) is one


def test_of_one_outage_nothing_is_left_for_the_next() -> None:
    outage = polled(AWAY)
    outage.failed(after(100.5), after(101), SILENT, WITHIN_S)
    outage.answered(after(110))
    assert not outage.covers(after(105).wall_ns), "nobody said that there was no way"

    outage = polled(THERE)
    outage.failed(after(100.5), after(101), AWAY, WITHIN_S)
    outage.answered(after(110))
    assert outage.covers(after(105).wall_ns)

    outage = Outage()
    for second in (0, 6):
        outage.failed(after(second), after(second + 3), AWAY, WITHIN_S)
        outage.answered(after(second + 5))
    assert outage.covers(after(8).wall_ns)
    assert not outage.covers(after(2).wall_ns), "it was answered in between"


def test_another_outage_is_another() -> None:
    outage = polled(AWAY)
    outage.failed(after(110), after(115), THERE, WITHIN_S)
    outage.answered(after(120))
    assert outage.covers(after(50).wall_ns)
    assert not outage.covers(after(116).wall_ns)
