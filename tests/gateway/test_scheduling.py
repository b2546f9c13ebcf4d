"""Whoever sleeps until something is due wakes when something sooner comes."""

from __future__ import annotations

import asyncio

from rosic.gateway.scheduling import sleep_or_wake
from rosic.testing.clock import ManualClock, settle


async def test_the_time_is_over_or_something_has_happened_whichever_is_first() -> None:
    clock, woken = ManualClock(), asyncio.Event()
    sleeping = asyncio.create_task(sleep_or_wake(clock, 10.0, woken))
    await clock.advance(9.0)
    assert not sleeping.done()
    await clock.advance(1.0)
    assert sleeping.done()
    sleeping = asyncio.create_task(sleep_or_wake(clock, 10.0, woken))
    await settle()
    woken.set()
    await settle()
    assert sleeping.done()
    assert woken.is_set(), "whoever sleeps says when it counts no more"


async def test_nothing_is_left_behind_when_it_is_ended() -> None:
    before = asyncio.all_tasks()
    sleeping = asyncio.create_task(sleep_or_wake(ManualClock(), 10.0, asyncio.Event()))
    await settle()
    sleeping.cancel()
    await asyncio.gather(sleeping, return_exceptions=True)
    await settle()
    assert asyncio.all_tasks() == before
