"""Time as an argument."""

from __future__ import annotations

from typing import Protocol


class Clock(Protocol):
    """Two clocks and a way to wait. Durations are taken on the monotonic one."""

    def wall_ns(self) -> int:
        """Return Unix time in nanoseconds; may jump."""
        ...

    def monotonic_ns(self) -> int:
        """Return nanoseconds that never go back, on every machine-wide reading in one process."""
        ...

    async def sleep(self, seconds: float) -> None:
        """Wait; other tasks run meanwhile."""
        ...
