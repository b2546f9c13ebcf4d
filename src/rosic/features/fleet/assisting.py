"""Robots that help each other: whoever helps takes over, and has no time for other tasks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet import events as e
from rosic.core.fleet.task import FleetMembership, TaskReason
from rosic.core.i18n import joined, said

if TYPE_CHECKING:
    from rosic.core.fleet.task import Task
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.features.fleet.monitor import FleetMonitor
    from rosic.gateway.components import Components


class AssistCommands:
    """Adjusts the tasks of a robot that helps and of the one that is helped.

    A task leaves either as it leaves a robot that somebody takes over: that one comes to rest
    first, and what is done stays done. What the helped one did, or has just failed at, goes to the
    one that helps if that one can do it; everything else to others, or back when the help is over.
    """

    def __init__(
        self, rooms: Components, dispatching: TaskDispatcher, watching: FleetMonitor
    ) -> None:
        self._rooms = rooms
        self._dispatching = dispatching
        self._watching = watching

    async def helped(self, helper: RobotId, asker: RobotId) -> str:
        """Take their tasks from both; see `rosic.contracts.among.Tasks`.

        Raises:
            RecordUnavailable: One could not be written down; it stays where it is.
        """
        hers = self._task_of(asker)
        changed = [await self._leave(robot, helper) for robot in (asker, helper) if robot]
        if hers is None and (failed := self._failed_at(asker, helper)) is not None:
            self._watching.prefer[failed.id] = helper
            changed.append(self._goes(failed, asker, helper))
        return joined("\n", filter(None, changed))

    def _task_of(self, robot: RobotId) -> Task | None:
        fleet = self._dispatching.fleet
        return fleet.tasks.get(fleet.holds.get(robot, ""))

    def _failed_at(self, asker: RobotId, helper: RobotId) -> Task | None:
        """Return the task that waits because the one who asks has just failed at it."""
        fleet = self._dispatching.fleet
        waiting = (fleet.tasks[key] for key in fleet.waiting)
        lately = (task for task in waiting if task.tried[-1:] == (asker,))
        return next((task for task in lately if self._takes_part(helper, task)), None)

    def _takes_part(self, helper: RobotId, task: Task) -> bool:
        active = self._dispatching.fleet.standing(helper) is FleetMembership.ACTIVE
        return active and helper in task.left

    async def _leave(self, robot: RobotId, helper: RobotId) -> str:
        task = self._task_of(robot)
        if task is None:
            return ""
        takes_over = robot != helper and self._takes_part(helper, task)
        if takes_over:
            self._watching.prefer[task.id] = helper
        if task.leaving:
            return self._goes(task, robot, helper) if takes_over else ""
        if not await self._dispatching.feed(e.Deviated(task.id, task.attempt, TaskReason.TAKEN)):
            return ""
        if takes_over:
            return self._goes(task, robot, helper)
        shown = self._rooms.profiles[robot].shown
        return said("Task {task} leaves {robot} and waits for a robot.", task=task.id, robot=shown)

    def _goes(self, task: Task, robot: RobotId, helper: RobotId) -> str:
        shown, by = self._rooms.profiles[robot].shown, self._rooms.profiles[helper].shown
        return said(
            "Task {task} goes from {robot} to {helper}.", task=task.id, robot=shown, helper=by
        )
