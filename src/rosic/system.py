"""The real clock and the real source of chance."""

from __future__ import annotations

import asyncio
import secrets
import time


class SystemClock:
    """The machine's clocks."""

    # Asked a dozen times for every message: no frame of ours in between.
    wall_ns = staticmethod(time.time_ns)
    monotonic_ns = staticmethod(time.monotonic_ns)

    async def sleep(self, seconds: float) -> None:
        """Wait on the event loop."""
        await asyncio.sleep(seconds)


class SystemEntropy:
    """The operating system's random numbers."""

    def token(self, length: int) -> bytes:
        """Return ``length`` unguessable bytes."""
        return secrets.token_bytes(length)
