"""Time at work by the quarter of an hour: added up, asked for, kept over a restart, forgotten."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.core.records import Fact
from rosic.core.time_units import DAY_NS, HOUR_NS, MINUTE_NS, SECOND_NS
from rosic.features.fleet.work_time import DAYS, QUARTER_NS, WorkTime, WorkTimeStore
from rosic.testing.clock import ManualClock

NOON_NS = 20_000 * DAY_NS + 12 * HOUR_NS


@given(
    st.lists(st.tuples(st.integers(0, 9_000), st.integers(0, 9_000)), max_size=20),
    st.integers(0, 700),
)
def test_what_was_added_is_found_since_any_quarter(
    stretches: list[tuple[int, int]], back: int
) -> None:
    hours, at_ns, since_ns = WorkTime(NOON_NS), NOON_NS, NOON_NS + back * QUARTER_NS
    expected_ns = 0
    for idle_s, worked_s in stretches:
        begin_ns = at_ns + idle_s * SECOND_NS
        at_ns = begin_ns + worked_s * SECOND_NS
        hours.add("w1", begin_ns, at_ns)
        expected_ns += max(0, at_ns - max(begin_ns, since_ns))
    found = hours.worked_s("w1", since_ns, at_ns)
    assert found == pytest.approx(expected_ns / SECOND_NS)
    assert hours.worked_s("w2", since_ns, at_ns) == 0


def test_it_is_kept_over_a_restart_and_let_go_after_eight_days() -> None:
    hours = WorkTime(NOON_NS)
    hours.add("w1", NOON_NS, NOON_NS + 20 * MINUTE_NS)
    kept = {fact.key: fact for fact in hours.facts(NOON_NS + HOUR_NS)}
    assert not tuple(hours.facts(NOON_NS + HOUR_NS))  # nothing new, nothing written
    again = WorkTime(NOON_NS + 2 * HOUR_NS)
    again.restore(kept.values())
    now_ns = NOON_NS + 2 * HOUR_NS
    assert again.worked_s("w1", NOON_NS, now_ns) == 20 * 60
    assert again.counted_s(NOON_NS - DAY_NS, now_ns) == 2 * 60 * 60
    [gone] = again.facts(NOON_NS + (DAYS + 1) * DAY_NS)
    assert (gone.key, gone.body) == (next(iter(kept)), b"")
    again.add("w1", NOON_NS, NOON_NS + 400 * DAY_NS)
    assert len(tuple(again.facts(NOON_NS + 400 * DAY_NS))) <= DAYS + 1


def test_a_record_that_cannot_be_read_is_no_work() -> None:
    hours = WorkTime(NOON_NS)
    hours.restore([Fact(kind="work-time", key="w1 20000", body=b"?")])
    assert hours.worked_s("w1", NOON_NS - DAY_NS, NOON_NS) == 0


async def test_what_goes_on_is_written_each_minute_and_at_the_end() -> None:
    clock = ManualClock()
    hours, written = WorkTime(clock.wall_ns()), list[Fact]()

    def settle() -> None:
        now_ns = clock.wall_ns()
        hours.add("w1", now_ns - SECOND_NS, now_ns)

    keeper = WorkTimeStore(hours, clock, settle, written.extend)
    keeper.run()
    await clock.advance(61)
    assert len(written) == 1
    await keeper.close()
    assert len(written) == 2
