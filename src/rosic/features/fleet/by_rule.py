"""What a rule about alarms does with the task that its robot has."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet import events as e
from rosic.core.fleet.task import FleetMembership, TaskReason
from rosic.errors import RobotBusy
from rosic.gateway.order_services import no_tasks

if TYPE_CHECKING:
    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.gateway.components import Components


class RuleTasks:
    """Pauses a task, or takes it to another robot. See ``alerts.actions.AlertTasks``."""

    def __init__(self, rooms: Components, dispatching: TaskDispatcher) -> None:
        self._rooms = rooms
        self._dispatching = dispatching

    async def pause(self, robot: RobotId, by: PrincipalId, why: str) -> bool:  # noqa: ARG002 - a contract
        """Hold the task; the robot comes to rest. False: it has none."""
        key = self._dispatching.fleet.holds.get(robot)
        if key is None:
            return False
        # What brings a robot to rest waits for no disk.
        return await self._dispatching.feed(e.TaskHeld(key, TaskReason.PAUSED), happened=True)

    async def reallocate(self, robot: RobotId, by: PrincipalId, why: str) -> None:  # noqa: ARG002 - a contract
        """Let the task leave this robot, as if it were late there; another is chosen for it.

        Raises:
            RobotBusy: It has none, or the task is bound to it.
        """
        fleet = self._dispatching.fleet
        key = fleet.holds.get(robot)
        task = None if key is None else fleet.tasks[key]
        if (
            task is None
            or not self._others(task, robot)
            or not await self._dispatching.feed(
                e.RobotDeviated(task.id, task.attempt, TaskReason.LATE), happened=True
            )
        ):
            raise RobotBusy(no_tasks(self._rooms.profiles[robot].shown))

    def _others(self, task: Task, robot: RobotId) -> bool:
        """Whether another robot might take a task, if not now; without one it would only fail."""
        standing = self._dispatching.fleet.standing
        return any(r != robot and standing(r) is not FleetMembership.RETIRED for r in task.left)
