"""Whether this process stood still: then what is read now may have waited for as long.

What programs and pages say carries no time of its own, and waits in the machine while a process is
stopped, suspended or held up. A message that came in meanwhile is not younger than the last moment
at which this process is known to have run.
"""

from __future__ import annotations

import asyncio
import sys
import time
from typing import TYPE_CHECKING, Final

from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Callable

LOOK_S: Final = 0.1
STILL_NS: Final = SECOND_NS
"""A loop that is late by less has stood still for nobody."""
AFTER_NS: Final = SECOND_NS
"""For so long after it, what is read may be what waited: it is read a little at a time."""


def running_ns() -> int:
    """Return the time of a clock that goes on while the machine is suspended."""
    if sys.platform == "linux":
        return time.clock_gettime_ns(time.CLOCK_BOOTTIME)
    return time.monotonic_ns()


class StandstillWatch:
    """Looks at the clock ten times a second, for all that run it.

    Args:
        now_ns: As `running_ns`; not the clock by which orders are dated, which a test may own: what
            stood still is this process.
    """

    def __init__(self, now_ns: Callable[[], int]) -> None:
        self._now_ns = now_ns
        self._looked_ns = now_ns()
        self._stood_ns = self._over_ns = 0
        self._looking = asyncio.Lock()

    async def run(self) -> None:
        """Look until cancelled; of several who run it, the next goes on where one leaves off."""
        async with self._looking:
            self._looked_ns = self._now_ns()
            while True:
                await asyncio.sleep(LOOK_S)
                self.look()

    def look(self) -> None:
        """Take the time."""
        now_ns = self._now_ns()
        stood_ns, self._looked_ns = now_ns - self._looked_ns, now_ns
        if stood_ns > STILL_NS:
            self._stood_ns, self._over_ns = stood_ns, now_ns

    def waited_ns(self) -> int:
        """Return for how long at most what is read now has waited; 0: for no time that counts."""
        since_ns = self._now_ns() - self._over_ns
        if not self._over_ns or since_ns > AFTER_NS:
            return 0
        return self._stood_ns + since_ns
