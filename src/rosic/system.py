"""The real clock and the real source of chance."""

from __future__ import annotations

import asyncio
import secrets
import sys
import time
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable


def _running_on() -> Callable[[], int]:
    """Return the reading of a clock that never goes back and does not stand still in suspend."""
    if sys.platform == "linux":
        return partial(time.clock_gettime_ns, time.CLOCK_BOOTTIME)
    if sys.platform == "darwin":
        # There it runs on; what Python calls monotonic is another clock, which does not.
        return partial(time.clock_gettime_ns, time.CLOCK_MONOTONIC)
    return time.monotonic_ns


class SystemClock:
    """The machine's clocks."""

    # Asked a dozen times for every message: no frame of ours in between.
    wall_ns = staticmethod(time.time_ns)
    monotonic_ns = staticmethod(_running_on())

    async def sleep(self, seconds: float) -> None:
        """Wait on the event loop."""
        await asyncio.sleep(seconds)


class SystemEntropy:
    """The operating system's random numbers."""

    def token(self, length: int) -> bytes:
        """Return ``length`` unguessable bytes."""
        return secrets.token_bytes(length)
