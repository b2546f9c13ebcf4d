"""What was to be done by a time and is not: said once, and the rest cancelled where so written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet import events as e
from rosic.core.fleet.task import Task, TaskReason, idle_first

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.clock import Clock
    from rosic.features.fleet.dispatcher import TaskDispatcher


class TaskDeadlines:
    """Follows the tasks that have one. Where none has, nothing is looked at."""

    def __init__(self, dispatching: TaskDispatcher, clock: Clock) -> None:
        self._dispatching = dispatching
        self._clock = clock

    @property
    def open(self) -> bool:
        """Whether a deadline may still pass."""
        return bool(self._dispatching.fleet.due)

    async def look(self) -> None:
        """Look once. What was begun before a crash is gone on with: it is all in the tasks."""
        fleet = self._dispatching.fleet
        for key in tuple(fleet.due):
            task = fleet.tasks.get(key)
            if task is None or key not in fleet.due:
                continue
            now_ns = self._clock.wall_ns()
            if task.due.at_ns and now_ns > task.due.at_ns:
                await self._late(task, whole=True)
            elif self._own_is_over(task, now_ns):
                await self._late(task, whole=False)

    def _own_is_over(self, task: Task, now_ns: int) -> bool:
        """Whether it takes too long since it could begin: since all before it was done."""
        fleet = self._dispatching.fleet
        if not task.due.lasts_ns or not fleet.ready(task):
            return False
        before = (fleet.tasks[other].since_ns for other in task.after)
        return now_ns > max((task.given_ns, *before)) + task.due.lasts_ns

    async def _late(self, task: Task, *, whole: bool) -> None:
        await self._dispatching.feed(e.Overdue(task.id, whole), happened=True)
        if task.due.cancels_all if whole else task.due.cancels:
            fleet = self._dispatching.fleet
            await self._cancel(fleet.mission(task.mission) if task.mission else (task,))

    async def _cancel(self, tasks: Iterable[Task]) -> None:
        for task in idle_first(tasks):
            if not task.over and not (task.leaving and task.why is TaskReason.CANCELLED):
                await self._dispatching.feed(
                    e.TaskHeld(task.id, TaskReason.CANCELLED), happened=True
                )
