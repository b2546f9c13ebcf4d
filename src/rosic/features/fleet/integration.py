"""What others hear of tasks, and do to them: whoever gave one, robots that help, rules."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet import events as e
from rosic.core.fleet.task import HELD, FleetMembership, TaskReason, TaskState
from rosic.core.i18n import joined, said
from rosic.core.messages import label
from rosic.core.time_units import SECOND_NS
from rosic.errors import RobotBusy
from rosic.features.fleet import messages as words
from rosic.features.fleet.task_parser import given_again
from rosic.gateway.order_services import no_tasks
from rosic.organiser.calendar_messages import length

if TYPE_CHECKING:
    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.features.fleet.monitor import FleetMonitor
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.end_buttons import EndButtons, Row


# ---- telling of tasks ----


class TaskNotifications:
    """Says it in private, over a crash too; an order itself is shown where the task was given."""

    def __init__(
        self, rooms: Components, reach: Notifier, dispatching: TaskDispatcher, ends: EndButtons
    ) -> None:
        self._rooms = rooms
        self._ends = ends
        self._reach = reach
        self._dispatching = dispatching

    def tell(self, before: Task, after: Task) -> None:
        """Say what has changed, if whoever gave the task would want to know."""
        text = self._text(before, after)
        if text:
            rows = (*words.choices(after), *self._row(before, after))
            self._reach.tell((after.author,), text, rows)

    def _row(self, before: Task, after: Task) -> Row:
        """Return what stands beneath the end of a task, whichever way it ended."""
        if after.due != before.due or not (after.over or after.state is TaskState.FAILED):
            return ()
        text = self._dispatching.letters.get(after.id)
        anew = after.over and text is not None and not after.mission
        again = given_again(after, text.lines) if anew and text is not None else ""
        reads = self._reach.read_by(after.author)
        whom = before.robot or after.robot or after.wanted
        return self._ends.of_task(whom, again, reads)

    def what(self, task: Task, who: PrincipalId) -> str:
        """Return what a task is about: in its author's words for them alone (I11)."""
        if who == task.author:
            text = self._dispatching.letters.get(task.id)
            return words.ERASED if text is None else text.shown
        profile = self._rooms.profiles.get(task.among[0])
        skills = {} if profile is None else profile.skills
        return joined("; ", (label(skills[s]) if s in skills else s for s in task.skills))

    def shown(self, robot: RobotId) -> str:
        """Return how people read a robot; one that is gone, by its id."""
        profile = self._rooms.profiles.get(robot)
        return robot if profile is None else profile.shown

    def _text(self, before: Task, after: Task) -> str:
        what, shown = (
            self.what(after, after.author),
            self.shown(before.robot) if before.robot else "",
        )
        if after.due != before.due:
            return self._late(after, what, whole=after.due.said_all != before.due.said_all)
        if after.state in HELD:
            return self._of_held(before, after, what)
        if after.state is TaskState.QUEUED:
            if after.moves > before.moves and after.why is not TaskReason.RESTARTED:
                rested = self._dispatching.rested.get(after.id, True)
                return words.waits(after, what, rested=rested, shown=shown)
            return ""
        if after.state is TaskState.DONE:
            return words.over(after, what, shown)
        return words.stands(after, what, shown, self._dispatching.why.get(after.id, ""))

    def _late(self, task: Task, what: str, *, whole: bool) -> str:
        """Return that a task, or all of its mission, is not done by when it was to be."""
        if not whole:
            return words.task(
                task.id, what, length(task.due.lasts_ns // SECOND_NS), task.due.cancels
            )
        tasks = self._dispatching.fleet.mission(task.mission)
        done = sum(one.state is TaskState.DONE for one in tasks)
        at = self._rooms.organiser.moment("", task.due.at_ns)
        return words.mission(task.mission, at, (done, len(tasks)), task.due.cancels_all)

    def _of_held(self, before: Task, after: Task, what: str) -> str:
        shown = self.shown(after.robot)
        if after.leaving:
            asked = after.why in {TaskReason.PAUSED, TaskReason.CANCELLED}
            return "" if asked or before.leaving else words.leaves(after, what, shown)
        begins = before.state is TaskState.ASSIGNED and after.state is TaskState.RUNNING
        return words.goes_on(after, what, shown) if begins and self._moved(after) else ""

    def _moved(self, task: Task) -> bool:
        """Whether it is new with this robot, after another."""
        return task.moves > 0 and task.asked == task.done and bool(task.tried or task.moves)


# ---- robots that help each other ----


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
        """Take their tasks from both; see `rosic.contracts.robot.Tasks`.

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
        if not await self._dispatching.feed(
            e.RobotDeviated(task.id, task.attempt, TaskReason.TAKEN)
        ):
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


# ---- tasks, as rules about alarms see them ----


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
