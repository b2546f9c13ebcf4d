"""Time as an argument."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Iterable

# ---- time ----


class Clock(Protocol):
    """Two clocks and a way to wait.

    Durations are taken on the monotonic one. What has a lifetime ends by both: while a machine
    is suspended both run on; while a virtual machine is paused neither does, and the wall clock
    jumps when it goes on.
    """

    def wall_ns(self) -> int:
        """Return Unix time in nanoseconds; may jump."""
        ...

    def monotonic_ns(self) -> int:
        """Return nanoseconds that never go back and run on while the machine is suspended.

        ``CLOCK_BOOTTIME``, not Python's ``time.monotonic``: that one stands still in suspend, and
        so does the event loop's. The same for all processes of one machine.
        """
        ...

    async def sleep(self, seconds: float) -> None:
        """Wait; other tasks run meanwhile. Time in suspend may not count: look at the clock."""
        ...


class ClockReading(NamedTuple):
    """Both clocks at one moment."""

    monotonic_ns: int
    wall_ns: int


def reading(clock: Clock) -> ClockReading:
    """Return what both clocks show now."""
    return ClockReading(clock.monotonic_ns(), clock.wall_ns())


def passed_ns(clock: Clock, since: ClockReading) -> int:
    """Return how much time has passed since then, by the clock that says more."""
    return max(clock.monotonic_ns() - since.monotonic_ns, clock.wall_ns() - since.wall_ns)


async def done_within(clock: Clock, seconds: float, tasks: Iterable[asyncio.Future[Any]]) -> bool:
    """Wait until tasks are done, but no longer than so. They go on, whatever comes of the wait.

    Returns:
        Whether all are done.
    """
    tasks = tuple(tasks)
    if all(task.done() for task in tasks):
        return True
    both = asyncio.create_task(_all_done(tasks))
    patience = asyncio.create_task(clock.sleep(seconds))
    try:
        await asyncio.wait((both, patience), return_when=asyncio.FIRST_COMPLETED)
    finally:
        both.cancel()
        patience.cancel()
    return all(task.done() for task in tasks)


async def _all_done(tasks: tuple[asyncio.Future[Any], ...]) -> None:
    await asyncio.wait(tasks)  # unlike gather, it leaves them be when cut off


# ---- chance ----


class Entropy(Protocol):
    """Unguessable bytes."""

    def token(self, length: int) -> bytes:
        """Return ``length`` bytes fit for secrets; a test may own the sequence."""
        ...
