"""Time that does not go back."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.core.records import Fact
from rosic.testing.clock import ManualClock

DAY_S = 86_400.0


async def test_time_goes_on_when_the_clock_is_set_back() -> None:
    clock = ManualClock()
    time = MonotonicWallClock(clock)
    begun_ns = time.wall_ns()
    clock.jump_wall(-DAY_S)
    assert time.wall_ns() == begun_ns
    await clock.advance(10.0)
    assert time.wall_ns() == begun_ns + 10_000_000_000
    assert time.behind_s() == DAY_S
    clock.jump_wall(DAY_S + 5.0)
    assert time.wall_ns() == begun_ns + 15_000_000_000
    assert time.behind_s() == 0.0


@given(st.lists(st.integers(min_value=-(10**6), max_value=10**6), max_size=30))
def test_it_never_goes_back(jumps: list[int]) -> None:
    clock = ManualClock()
    time = MonotonicWallClock(clock)
    seen = [time.wall_ns()]
    for jump in jumps:
        clock.jump_wall(jump)
        seen.append(time.wall_ns())
    assert seen == sorted(seen)
    assert seen[-1] >= clock.wall_ns()


async def test_the_mark_outlives_a_restart_and_is_written_once_a_minute() -> None:
    clock = ManualClock()
    time = MonotonicWallClock(clock)
    (fact,) = time.due()
    time.apply(fact)
    assert time.due() == ()
    await clock.advance(60.0)
    (fact,) = time.due()
    time.apply(fact)
    highest_ns = time.wall_ns()
    clock.jump_wall(-DAY_S)
    again = MonotonicWallClock(clock)
    assert again.wall_ns() < highest_ns
    again.apply(fact)
    assert again.wall_ns() == highest_ns


async def test_the_owner_can_accept_an_earlier_time() -> None:
    clock = ManualClock()
    clock.jump_wall(365 * DAY_S)  # somebody set the wrong year
    time = MonotonicWallClock(clock)
    time.apply(time.due()[0])
    clock.jump_wall(-365 * DAY_S)
    accepted = time.accept()
    time.apply(accepted)
    assert time.wall_ns() == clock.wall_ns()
    await clock.advance(1.0)
    again = MonotonicWallClock(clock)
    again.apply(accepted)
    assert again.wall_ns() == clock.wall_ns()


@pytest.mark.parametrize("body", [b"", b"\xc1", b"\x80"])
def test_a_mark_that_cannot_be_read_is_none(body: bytes) -> None:
    clock = ManualClock()
    time = MonotonicWallClock(clock)
    time.apply(Fact(kind="high-water", key="wall", body=body))
    assert time.wall_ns() == clock.wall_ns()
