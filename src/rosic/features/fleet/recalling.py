"""Takes a task from its robot: what it does for the task ends, and it is at rest or cut off."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.fleet.task import TaskReason
from rosic.features.fleet import messages as words
from rosic.gateway.resting import comes_to_rest

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.fleet.events import Recall
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.alerts.actions import AlertActionServices
    from rosic.gateway.components import Components

CUT_OFF: Final = frozenset({TaskReason.LOST})
"""Nobody can see whether it rests: it is stopped, and stays so until a person has looked."""


class TaskRecall:
    """Ends what a robot does for a task, and nothing else that it does."""

    def __init__(self, rooms: Components, hands: AlertActionServices, clock: Clock) -> None:
        self._rooms = rooms
        self._hands = hands
        self._clock = clock

    async def recall(self, doing: Recall, author: PrincipalId, cid: CommandId) -> bool:
        """Return once the robot rests, or once nothing counts that it does for the task.

        Args:
            doing: Which robot, and why.
            author: In whose name it was asked.
            cid: Of the order.

        Returns:
            Whether it was seen at rest, or its side cannot say. If not it was stopped: everything
            that it was asked before is void, however late it hears of it.
        """
        robot, linker = doing.robot, self._rooms.linker
        if doing.why in CUT_OFF or linker.presence(robot).online is False:
            self._cut_off(robot, author)
            return False
        await self._hands.lives.cut_order(robot, cid, words.reason(doing.task, doing.why))
        rested = await comes_to_rest(linker, self._clock, robot)
        if not rested:
            self._cut_off(robot, author)
        else:
            self._give_back(robot, author)
        return rested

    def _cut_off(self, robot: RobotId, author: PrincipalId) -> None:
        """Stop it, and take it from whoever has it: late answers and late orders are void."""
        self._hands.stop_lane.stop_robots((robot,), "")
        if self._rooms.organiser.holder(robot) == author:
            self._rooms.organiser.release(robot)

    def _give_back(self, robot: RobotId, author: PrincipalId) -> None:
        organiser = self._rooms.organiser
        if organiser.holder(robot) == author and not organiser.lease(robot).active:
            organiser.release(robot)
