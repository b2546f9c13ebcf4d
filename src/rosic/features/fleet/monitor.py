"""Looks at the fleet now and then: who is lost, what is late, what could begin.

While no task is open nobody looks at anything.
"""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from rosic.core.fleet import events as e
from rosic.core.fleet.candidates import CandidateRobot, by_priority, may
from rosic.core.fleet.task import FleetMembership, Task, TaskReason, TaskState, idle_first
from rosic.core.i18n import joined
from rosic.core.robot.profile import Slots
from rosic.core.time_units import SECOND_NS
from rosic.errors import RecordUnavailable
from rosic.features.fleet import multi_robot_messages as words
from rosic.features.fleet.messages import waits_for
from rosic.organiser.planning.solver import assign, is_loaded, load

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock
    from rosic.core.fleet.state import FleetState
    from rosic.core.fleet.task import TaskId
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import Presence, RobotId
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.gateway.components import Components


# ---- readiness ----

# Why a robot would not begin at once, and so why a task waits.

NAMED_AT_MOST: Final = 3


def why_not_ready(rooms: Components, fleet: FleetState, robot: RobotId, who: PrincipalId) -> str:
    """Return why a robot would not begin at once for somebody; empty if it would."""
    presence, profile = rooms.linker.presence(robot), rooms.profiles[robot]
    holder = rooms.organiser.whose(robot)
    battery, described = presence.values.get("battery"), profile.telemetry.get("battery")
    least = described.alert_below if described is not None else None
    low = least is not None and isinstance(battery, int | float) and battery < least
    hindrances = (
        (presence.online is False, words.NOT_THERE),
        (fleet.standing(robot) is not FleetMembership.ACTIVE, words.NO_PART),
        (rooms.stops[robot].latched, words.STOPPED),
        (holder is not None and holder != who, words.ANOTHERS),
        (rooms.linker.current(robot) is not None, words.AT_WORK),
        (presence.moves, words.NOT_AT_REST),
        (low, words.BATTERY_LOW),
    )
    return next((why for so, why in hindrances if so), "")


def why_waits(rooms: Components, fleet: FleetState, task: Task, visible: frozenset[RobotId]) -> str:
    """Return what a task waits for, as whoever sees these robots may read it; empty: for nothing.

    One robot that is ready is enough: then it begins as soon as it is its turn.
    """
    if not fleet.ready(task):
        return waits_for(task.after)
    why = {robot: why_not_ready(rooms, fleet, robot, task.author) for robot in task.left}
    if not why or not all(why.values()):
        return ""
    told = [
        words.state(rooms.profiles[robot].shown, reason)
        for robot, reason in why.items()
        if robot in visible
    ]
    more = len(why) - len(told[:NAMED_AT_MOST])
    if told and more > 0:
        return joined("; ", (*told[:NAMED_AT_MOST], words.so_many_more(more)))
    return joined("; ", told)


# ---- monitor ----


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
        await self._dispatching.feed(e.TaskOverdue(task.id, whole), happened=True)
        if task.due.cancels_all if whole else task.due.cancels:
            fleet = self._dispatching.fleet
            await self._cancel(fleet.mission(task.mission) if task.mission else (task,))

    async def _cancel(self, tasks: Iterable[Task]) -> None:
        for task in idle_first(tasks):
            if not task.over and not (task.leaving and task.why is TaskReason.CANCELLED):
                await self._dispatching.feed(
                    e.TaskHeld(task.id, TaskReason.CANCELLED), happened=True
                )


# ---- looking now and then ----

EVERY_S: Final = 0.5
LOST_AFTER_NS: Final = 3 * SECOND_NS
"""A robot that is at work and not heard of for so long has lost its task."""
AT_ONCE: Final = 200
"""So many tasks are weighed at once; a stop does not wait while the others are looked at."""
PAIRS_AT_ONCE: Final = 40_000
"""Of tasks and robots. Where there are many robots, fewer tasks are weighed at once."""

log = logging.getLogger("rosic.fleet")


class FleetMonitor:
    """Feeds a fleet with what nobody tells it.

    Args:
        engaged: Whether a robot has something else to do than tasks, though it carries out nothing.

    Attributes:
        prefer: Who takes over a task that waits: whoever helps the robot that had it.
    """

    def __init__(
        self,
        rooms: Components,
        dispatching: TaskDispatcher,
        clock: Clock,
        engaged: Callable[[RobotId], bool],
    ) -> None:
        self._engaged = engaged
        self.prefer: dict[TaskId, RobotId] = {}
        self._rooms = rooms
        self._dispatching = dispatching
        self._clock = clock
        self._unheard: dict[RobotId, tuple[TaskId, int]] = {}
        self._watching: asyncio.Task[None] | None = None
        self._running = False
        self._planning = asyncio.Lock()
        self._deadlines = TaskDeadlines(dispatching, clock)

    # ---- now and then ----

    def run(self) -> None:
        """Look from now on, as long as tasks are open."""
        self._running = True
        self.begin()

    def begin(self) -> None:
        """Look, if there is something to look after."""
        if self._running and self._watching is None and self._open():
            self._watching = asyncio.create_task(self._watch())

    def _open(self) -> bool:
        fleet = self._dispatching.fleet
        return bool(fleet.waiting or fleet.holds or fleet.due)

    async def _watch(self) -> None:
        try:
            while self._open():
                try:
                    await self.look()
                except Exception:
                    log.exception("the fleet could not be looked after")
                await self._clock.sleep(EVERY_S)
        finally:
            self._watching = None

    async def close(self) -> None:
        """Look no more."""
        self._running = False
        if self._watching is not None:
            self._watching.cancel()
            await asyncio.gather(self._watching, return_exceptions=True)

    # ---- one look ----

    async def look(self) -> None:
        """Look once."""
        await self._look_after()
        await self._let_expire()
        if self._deadlines.open:
            await self._deadlines.look()
        await self.plan()

    async def _look_after(self) -> None:
        fleet = self._dispatching.fleet
        for robot, key in tuple(fleet.holds.items()):
            task = fleet.tasks[key]
            why = TaskReason.NONE if task.leaving else self._deviates(robot, task)
            if why is not TaskReason.NONE:
                await self._dispatching.feed(e.RobotDeviated(key, task.attempt, why), happened=True)

    def _deviates(self, robot: RobotId, task: Task) -> TaskReason:
        now_ns = self._clock.monotonic_ns()
        if self._rooms.linker.presence(robot).online is not False:
            self._unheard.pop(robot, None)
        elif now_ns - self._unheard_since(robot, task, now_ns) >= LOST_AFTER_NS:
            return TaskReason.LOST
        attempt = self._dispatching.begun.get(task.id)
        if task.state is not TaskState.RUNNING or attempt is None or attempt.number != task.attempt:
            return TaskReason.NONE
        late = task.expected_ns and now_ns - attempt.began_ns > task.expected_ns
        return TaskReason.LATE if late else TaskReason.NONE

    def _unheard_since(self, robot: RobotId, task: Task, now_ns: int) -> int:
        """Return since when a robot is not heard of at this task; an earlier one does not count."""
        of, since_ns = self._unheard.get(robot, ("", 0))
        if of != task.id:
            since_ns = now_ns
            self._unheard[robot] = task.id, now_ns
        return since_ns

    async def _let_expire(self) -> None:
        fleet, now_ns = self._dispatching.fleet, self._clock.wall_ns()
        for key in tuple(fleet.waiting):
            task = fleet.tasks.get(key)
            if task is not None and task.too_late(now_ns):
                await self._dispatching.feed(e.TaskExpired(key), happened=True)

    # ---- choosing ----

    async def plan(self) -> None:
        """Give tasks that wait to robots that are free."""
        if self._planning.locked() or not self._running:
            return
        async with self._planning:
            await self._let_help()
            fleet, now_ns = self._dispatching.fleet, self._clock.wall_ns()
            if not fleet.waiting:
                return
            if not is_loaded():
                await asyncio.to_thread(load)  # a stop does not wait for that
            late, left_alone = self._dispatching.patience.not_now(self._clock.monotonic_ns())
            least = self._least()
            robots = [r for r in self._rooms.profiles if r not in left_alone]
            candidates = {r: self.candidate(r, least) for r in robots}
            at_most, leave = at_once(len(self._rooms.profiles)), late | self.prefer.keys()
            levels = by_priority(fleet, candidates, now_ns, leave=leave, at_most=at_most)
            for task, robot in assign(fleet, levels, candidates, now_ns).pairs:
                await self._choose(task, robot)

    async def _choose(self, task: TaskId, robot: RobotId) -> None:
        try:
            await self._dispatching.feed(e.RobotChosen(task, robot))
        except RecordUnavailable:
            log.warning("task %s waits: nothing can be written down", task)

    async def _let_help(self) -> None:
        """Give tasks to whoever helps the robot that had them, as soon as that one is free."""
        fleet = self._dispatching.fleet
        for key, robot in tuple(self.prefer.items()):
            task = fleet.tasks.get(key)
            waits = task is not None and (task.state is TaskState.QUEUED or task.leaving)
            there = self._rooms.linker.presence(robot).online is not False
            helps = (
                there and self._engaged(robot) and fleet.standing(robot) is FleetMembership.ACTIVE
            )
            if task is None or not waits or not helps:
                del self.prefer[key]
            elif key in fleet.waiting and may(fleet, task, self.candidate(robot, helping=True)):
                del self.prefer[key]
                await self._choose(key, robot)

    def _least(self) -> int:
        """Return how many steps whoever has done least has done: the measure of load."""
        return min(self._dispatching.finished.values(), default=0)

    def candidate(self, robot: RobotId, least: int = 0, *, helping: bool = False) -> CandidateRobot:
        """Return what a look at a robot shows now.

        Args:
            robot: One that helps another has no time for tasks.
            least: How many steps whoever has done least has done.
            helping: It is asked whether it may do what it helps with.
        """
        rooms = self._rooms
        presence = rooms.linker.presence(robot)
        free = (
            presence.online is not False
            and not presence.moves
            and not rooms.stops[robot].latched
            and rooms.linker.current(robot) is None
            and (helping or not self._engaged(robot))
        )
        holder = rooms.organiser.whose(robot)
        if rooms.profiles[robot].slots is Slots.REQUIRED:
            slot = rooms.organiser.calendar.present(robot, rooms.organiser.wall_ns())
            free = free and slot is not None
        battery = presence.values.get("battery")
        finished = self._dispatching.finished
        return CandidateRobot(
            robot=robot,
            free=free,
            holder=holder,
            battery=float(battery) if isinstance(battery, int | float) else None,
            place=_place(presence),
            load=finished.get(robot, 0) - least,
            declined=self._dispatching.patience.declined(robot, self._clock.monotonic_ns()),
        )


def at_once(robots: int) -> int:
    """Return how many tasks are weighed at once where there are so many robots."""
    return max(1, min(AT_ONCE, PAIRS_AT_ONCE // max(1, robots)))


def _place(presence: Presence) -> tuple[float, float] | None:
    if presence.pose is not None:
        return presence.pose.x_m, presence.pose.y_m
    x, y = presence.values.get("x"), presence.values.get("y")
    if isinstance(x, int | float) and isinstance(y, int | float):
        return float(x), float(y)
    return None
