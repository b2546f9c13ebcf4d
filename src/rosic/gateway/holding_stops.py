"""Which stops hold what they came in unconfirmed, while the stop file takes its time.

Where it hangs, a hundred stops of one robot would keep a messenger from giving out the next one, of
another robot. Only the newest of each robot is needed after a crash: it stops the same.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import RobotId


class HoldingStops:
    """Knows the newest stop of each robot, by the messenger that would bring it again."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._newest: dict[tuple[str, RobotId], asyncio.Future[None]] = {}
        self._holds: dict[asyncio.Future[None], int] = {}

    async def hold(
        self,
        messenger: str,
        robots: tuple[RobotId, ...],
        latched: asyncio.Task[bool],
        within_s: float,
    ) -> None:
        """Wait until a stop is on disk, or newer ones stop all its robots, or for so long."""
        mine: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        names = [(messenger, robot) for robot in robots]
        self._holds[mine] = len(names)
        for name in names:
            self._succeed(self._newest.get(name))
            self._newest[name] = mine
        patience = asyncio.create_task(self._clock.sleep(within_s))
        try:
            await asyncio.wait((latched, patience, mine), return_when=asyncio.FIRST_COMPLETED)
        finally:
            patience.cancel()
            del self._holds[mine]
            for name in names:
                if self._newest.get(name) is mine:
                    del self._newest[name]

    def _succeed(self, older: asyncio.Future[None] | None) -> None:
        if older is None:
            return
        self._holds[older] -= 1
        if not self._holds[older] and not older.done():
            older.set_result(None)
