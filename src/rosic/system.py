"""The real clock and the real source of chance."""

from __future__ import annotations

import asyncio
import secrets
import time


class SystemClock:
    """The machine's clocks."""

    def wall_ns(self) -> int:
        """Return Unix time in nanoseconds."""
        return time.time_ns()

    def monotonic_ns(self) -> int:
        """Return the monotonic clock in nanoseconds."""
        return time.monotonic_ns()

    async def sleep(self, seconds: float) -> None:
        """Wait on the event loop."""
        await asyncio.sleep(seconds)


class SystemEntropy:
    """The operating system's random numbers."""

    def token(self, length: int) -> bytes:
        """Return ``length`` unguessable bytes."""
        return secrets.token_bytes(length)
