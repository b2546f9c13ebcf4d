"""Robots that help each other have no time for tasks: what they do goes to others meanwhile."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet import events as e
from rosic.core.fleet.task import Why
from rosic.core.saying import joined, said

if TYPE_CHECKING:
    from rosic.core.robot import RobotId
    from rosic.pipeline.fleet.dispatching import Dispatching
    from rosic.pipeline.rooms import Rooms


class Assisting:
    """Adjusts the tasks of a robot that helps and of the one that is helped.

    A task leaves either as it leaves a robot that somebody takes over: that one comes to rest
    first, what is done stays done, and another robot goes on, or this one when the help is over.
    """

    def __init__(self, rooms: Rooms, dispatching: Dispatching) -> None:
        self._rooms = rooms
        self._dispatching = dispatching

    async def helped(self, helper: RobotId, asker: RobotId) -> str:
        """Take their tasks from both; see `rosic.contracts.among.Tasks`.

        Raises:
            RecordUnavailable: One could not be written down; it stays where it is.
        """
        changed = [await self._leave(robot) for robot in (asker, helper) if robot]
        return joined("\n", filter(None, changed))

    async def _leave(self, robot: RobotId) -> str:
        fleet = self._dispatching.fleet
        task = fleet.tasks.get(fleet.holds.get(robot, ""))
        if task is None or task.leaving:
            return ""
        if not await self._dispatching.feed(e.Deviated(task.id, task.attempt, Why.TAKEN)):
            return ""
        shown = self._rooms.profiles[robot].shown
        return said("Task {task} leaves {robot} and waits for a robot.", task=task.id, robot=shown)
