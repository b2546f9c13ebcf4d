"""A clock that runs faster than the wall's, for whoever has no half a minute."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock


class FastClock:
    """Another clock, so many times as fast. Everything on it keeps its proportions.

    Args:
        clock: The real one.
        factor: At least 1.

    Attributes:
        factor: The same.
    """

    def __init__(self, clock: Clock, factor: float) -> None:
        self._clock = clock
        self.factor = factor
        self._wall_ns = clock.wall_ns()
        self._began_ns = clock.monotonic_ns()

    def wall_ns(self) -> int:
        """Return the wall clock, as if more time had passed since this was made."""
        return self._wall_ns + self._past_ns()

    def monotonic_ns(self) -> int:
        """Return the monotonic clock, likewise."""
        return self._began_ns + self._past_ns()

    async def sleep(self, seconds: float) -> None:
        """Wait for so long on this clock."""
        await self._clock.sleep(seconds / self.factor)

    def _past_ns(self) -> int:
        return int((self._clock.monotonic_ns() - self._began_ns) * self.factor)
