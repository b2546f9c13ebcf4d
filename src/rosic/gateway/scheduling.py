"""Looks at every robot again and again, a few at a time: what people send passes in between.

A look at five thousand robots at once takes as long as a stop may. In parts it takes as long in
all, and nobody waits longer for it than in a place with fifty.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final, TypeVar

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from rosic.contracts.clock import Clock

T = TypeVar("T")

AT_ONCE: Final = 50


async def go_round(
    clock: Clock,
    every_s: float,
    things: Iterable[T],
    look: Callable[[Sequence[T]], None],
    more: asyncio.Event | None = None,
) -> None:
    """Look at all of them once in so long, evenly spread over that time, until cancelled.

    A round that could not be made in time is not made up for. In a round is looked at what was
    there at its beginning. Without anything to look at it ends.

    Args:
        clock: Waits.
        every_s: How long a round takes.
        things: What there is to look at; may grow.
        look: Looks at some of them.
        more: Instead of ending, wait until this is set: there is something to look at now.
    """
    due_ns = clock.monotonic_ns()
    while True:
        while all_ := tuple(things):
            parts = [all_[at : at + AT_ONCE] for at in range(0, len(all_), AT_ONCE)]
            for part in parts:
                look(part)
                due_ns += int(every_s * 1e9) // len(parts)
                left_ns = due_ns - clock.monotonic_ns()
                if left_ns < -int(every_s * 1e9):
                    due_ns -= left_ns
                await clock.sleep(max(0, left_ns) / 1e9)
        if more is None:
            return
        more.clear()
        await more.wait()
        due_ns = clock.monotonic_ns()


# ---- waiting for a time or an event ----


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
