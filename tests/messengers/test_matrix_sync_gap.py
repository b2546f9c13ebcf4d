"""Since when somebody has listened to Matrix without a gap."""

from __future__ import annotations

from rosic.core.time_units import SECOND_NS
from rosic.messengers.matrix.sync_gap import GRACE_NS, SyncGap, SyncMoment


def at(seconds: float, jump_s: float = 0.0) -> SyncMoment:
    return SyncMoment(int((1_000 + seconds + jump_s) * SECOND_NS), int(seconds * SECOND_NS))


def thawed() -> SyncGap:
    gap = SyncGap()
    gap.answered(at(0))
    assert gap.drained(at(0), empty=True)
    return gap


def test_what_came_while_nobody_listened_is_backlog() -> None:
    gap = SyncGap()
    gap.answered(at(0))
    assert gap.stamp(at(0).wall_ns) > at(0).wall_ns
    assert not gap.drained(at(0), empty=False)
    assert gap.frozen


def test_it_is_over_when_a_sync_finds_nothing() -> None:
    gap = thawed()
    assert gap.stamp(at(1).wall_ns) == at(0).wall_ns - GRACE_NS


def test_it_is_over_when_people_write_all_the_time() -> None:
    gap = SyncGap()
    thawing = []
    for second in range(3):
        gap.answered(at(second))
        thawing.append(gap.drained(at(second), empty=False))
    assert thawing == [False, False, True]


def test_a_pause_or_a_clock_that_jumps_begins_it_anew() -> None:
    for later in (at(6), at(1, jump_s=3), at(1, jump_s=-3)):
        gap = thawed()
        gap.answered(later)
        assert gap.frozen
