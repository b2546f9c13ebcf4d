"""Says that a robot which was stopped and at rest moves all the same: by somebody else's hand."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.core.robot.alert_config import RecipientCircle

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.alerts.recipients import Recipients
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier

log = logging.getLogger("rosic.stop")

EVERY_S: Final = 0.5
AT_ONCE: Final = 500
"""So many robots are looked at in one step of the event loop."""
LOOKS: Final = 2
"""So often in a row it is seen to move: one measurement alone may be a push, or noise."""


class StopViolations:
    """Follows robots that are stopped, from their measured rest on.

    ROSIC sends nothing: whoever drives the robot stands beside it, or has to be found. Whoever
    stopped it is told, once for each stop; where nobody known did, whoever holds or may operate it.
    """

    def __init__(
        self, rooms: Components, reach: Notifier, clock: Clock, circles: Recipients
    ) -> None:
        self._rooms = rooms
        self._reach = reach
        self._clock = clock
        self._circles = circles
        self._rested: dict[RobotId, int] = {}
        self._moved: dict[RobotId, int] = {}
        self._told: dict[RobotId, int] = {}

    async def run(self) -> None:
        """Look until cancelled."""
        while True:
            await self.look()
            await self._clock.sleep(EVERY_S)

    async def look(self) -> None:
        """Look once."""
        for number, (robot, entry) in enumerate(tuple(self._rooms.board.items())):
            if number % AT_ONCE == AT_ONCE - 1:
                await asyncio.sleep(0)
            if entry.latched and self._told.get(robot) != entry.generation:
                self._see(robot, entry.generation)

    def _see(self, robot: RobotId, generation: int) -> None:
        presence = self._rooms.linker.presence(robot)
        if robot in self._rooms.linker.pursuit or not presence.moves:
            self._moved[robot] = 0
            if presence.at_rest:
                self._rested[robot] = generation
        elif self._rested.get(robot) == generation:
            self._moved[robot] += 1
            if self._moved[robot] >= LOOKS:
                self._told[robot] = generation
                self._tell(robot)

    def _tell(self, robot: RobotId) -> None:
        shown = self._rooms.profiles[robot].shown
        log.warning("%s is stopped, was measured at rest, and moves; ROSIC sends nothing", robot)
        text = said(
            "{shown} is stopped and was at rest; now it moves, and not by me. Please look.",
            shown=shown,
        )
        self._reach.tell(self._whom(robot), text, urgent=True)

    def _whom(self, robot: RobotId) -> tuple[PrincipalId, ...]:
        by = self._rooms.board[robot].by
        if by and self._circles.may_hear(by, robot):
            return (by,)
        return self._circles.of(robot, RecipientCircle.HOLDER, 0)
