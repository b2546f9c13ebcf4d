"""Waits for a time, or until something has happened that may be due sooner."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock


async def sleep_or_wake(clock: Clock, seconds: float, woken: asyncio.Event) -> None:
    """Return when so many seconds are over or the event is set, whichever comes first.

    The event is left as it is: whoever sleeps again clears it before they look at what is due.
    """
    timer = asyncio.create_task(clock.sleep(seconds))
    waking = asyncio.create_task(woken.wait())
    try:
        await asyncio.wait((timer, waking), return_when=asyncio.FIRST_COMPLETED)
    finally:
        timer.cancel()
        waking.cancel()
