"""From the ROS thread to the event loop: bounded, in order, one wake-up for a burst."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

_PER_TURN = 256


class LoopBridge:
    """Carries callables from any thread to the event loop.

    A wake-up of the loop costs a system call, so one is made for a whole burst. Sources keep what
    they have to say themselves and stand here at most once, so the length is bounded by their
    number; ``limit`` is the fence behind that rule.

    Attributes:
        refused: How many were turned away because the limit was reached.
    """

    def __init__(self, loop: asyncio.AbstractEventLoop, limit: int = 8192) -> None:
        self._loop = loop
        self._limit = limit
        self._waiting: deque[Callable[[], None]] = deque()
        self._awake = False
        self.refused = 0

    def offer(self, deliver: Callable[[], None]) -> bool:
        """Have ``deliver`` called on the loop; from any thread.

        Returns:
            False when it will not be called: too many are waiting, or the loop is closed.
        """
        if len(self._waiting) >= self._limit:
            self.refused += 1
            return False
        self._waiting.append(deliver)
        # Set after the append and cleared before the first take: whoever sees it still set has
        # appended early enough to be taken.
        if self._awake:
            return True
        self._awake = True
        try:
            self._loop.call_soon_threadsafe(self._drain)
        except RuntimeError:
            self._waiting.clear()
            return False
        return True

    def _drain(self) -> None:
        """Deliver what waits, at most so many at a time: the loop has other work."""
        self._awake = False
        try:
            for _ in range(min(len(self._waiting), _PER_TURN)):
                self._waiting.popleft()()
        finally:  # whatever one of them raised, the rest is delivered
            if self._waiting and not self._awake:
                self._awake = True
                self._loop.call_soon(self._drain)
