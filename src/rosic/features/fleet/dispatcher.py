"""Carries out what a fleet decides: written down first, then done, each attempt once.

Whatever happens is an event; `react` says what follows. Nothing here decides anything itself.
"""

from __future__ import annotations

import asyncio
import logging
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from rosic.contracts.background_tasks import BackgroundTasks
from rosic.core.fleet import events as e
from rosic.core.fleet.state import FleetState
from rosic.core.fleet.task import HELD, OVER, RESTING, TaskReason, TaskState, idle_first
from rosic.core.fleet.transitions import react
from rosic.core.order import OrderEnding
from rosic.core.signal import Signal
from rosic.errors import RecordUnavailable, Refusal, RosicError, Unrecognised
from rosic.features.fleet.attempt import TaskRequester, attempt_id, end_after, end_of
from rosic.features.fleet.dispatch_state import RetryBackoff, TaskTexts
from rosic.features.fleet.idempotency import IdempotencyKeys

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Coroutine, Iterable

    from rosic.contracts.clock import Clock
    from rosic.core.fleet.task import Task, TaskId
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.order import Order, Outcome
    from rosic.core.records import Decided, Record
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.attempt import TaskAttempt, TaskAttempts, TaskRecall
    from rosic.features.fleet.dispatch_state import TaskText
    from rosic.gateway.components import Components
    from rosic.gateway.transactions import Transactions

Given: TypeAlias = "tuple[list[tuple[Task, TaskText]], Decided]"

BEHIND_S = 0.1

log = logging.getLogger("rosic.fleet")


class TaskDispatcher:
    """The one place where a fleet changes.

    Attributes:
        fleet: As it is.
        letters: What was said for each task.
        origins: Which messages have had their effect.
        begun: The newest attempt of each task that has a robot.
        why: What a robot or a room said last about a task that did not go on.
        rested: Whether the robot that a task left last was seen at rest.
        finished: How many steps each robot has done since the start.
        patience: Who is not asked again yet.
        tell: Hears of a task before and after a change that people may want to know.
        changed: Called after every change: there may be something to choose.
        behind: Whether what people sent while nobody listened may still come.
    """

    def __init__(
        self,
        rooms: Components,
        changes: Transactions,
        clock: Clock,
        attempting: TaskAttempts,
        recalling: TaskRecall,
        behind: Callable[[], bool],
    ) -> None:
        self.fleet = FleetState()
        self.letters = TaskTexts()
        self.origins = IdempotencyKeys()
        self.begun: dict[TaskId, TaskAttempt] = {}
        self.why: dict[TaskId, str] = {}
        self.rested: dict[TaskId, bool] = {}
        self.finished: dict[RobotId, int] = {}
        self.patience = RetryBackoff()
        self.tell: Signal[[Task, Task]] = Signal()
        self.changed: Signal[[]] = Signal()
        self.behind = behind
        self._rooms = rooms
        self._changes = changes
        self._clock = clock
        self._attempting = attempting
        self._recalling = recalling
        self._tasks: BackgroundTasks[None] = BackgroundTasks()
        self._closing = False

    # ---- what happens ----

    async def feed(self, event: e.Event, *records: Record, happened: bool = False) -> bool:
        """Let an event happen: decided, written down, so; then what follows is begun.

        Args:
            event: What happened.
            records: Written with it.
            happened: It is so already, written down or not: what a robot did, whom it lost.

        Returns:
            Whether it changed anything.

        Raises:
            RecordUnavailable: It could not be written, and nothing has changed.
        """
        if self._closing:
            return False
        async with self._changes.turn() as turn:
            step = react(self.fleet, event, self._clock.wall_ns())
            facts = self.fleet.facts(step)
            if not facts:
                return False
            if happened:
                await turn.act((*records, *facts))
            else:
                await turn.write((*records, *facts))
        self._do(step.doings)
        self.changed.emit()
        return True

    async def give(self, cid: CommandId, make: Callable[[], Given]) -> list[tuple[Task, TaskText]]:
        """Take tasks in: all of them or none. What need not be known any more is let go.

        Args:
            cid: Of the line that gives them.
            make: Returns the tasks, and what is decided with them. Called once nothing else can
                change meanwhile, so that no two tasks have one number.

        Raises:
            Repeated: The message had its effect already.
            Refusal: From `make`; nothing was taken in.
            RecordUnavailable: Nothing was taken in.
        """
        now_ns = self._clock.wall_ns()
        async with self._changes.turn() as turn:
            self.origins.check(cid)
            given, decided = make()
            stale = self.fleet.stale()
            facts = [*self.fleet.forgotten(stale), *self.letters.forgotten(stale)]
            facts += self.origins.facts(cid, now_ns)
            for task, said in given:
                facts.append(self.letters.fact(task.id, task.author, said))
                facts += self.fleet.facts(react(self.fleet, e.TaskGiven(task), now_ns))
            await turn.write((decided, *facts))
        for gone in stale:
            self.why.pop(gone, None)
            self.rested.pop(gone, None)
        self.changed.emit()
        return given

    async def ended(self, author: PrincipalId) -> None:
        """Cancel everything that somebody wants: they are nobody any more."""
        for task in idle_first(task for task in self.fleet.open() if task.author == author):
            self.why.pop(task.id, None)
            await self._feed(e.TaskHeld(task.id, TaskReason.CANCELLED))

    async def hold(
        self, author: PrincipalId, robots: Collection[RobotId], why: TaskReason
    ) -> tuple[Task, ...]:
        """Pause or cancel what somebody has under way, and what of it waits for a robot.

        What they have paused is cancelled, too: it is theirs still, and would go on some day.

        Args:
            author: Whose tasks.
            robots: Those of these robots, and those that are for nobody else; none: all.
            why: `TaskReason.PAUSED` or `TaskReason.CANCELLED`.

        Returns:
            The tasks that were held, as they were.
        """
        held: dict[TaskId, Task] = {}
        for _ in range(2):  # once more for what was being given, and is so when it comes to that
            for task in idle_first(t for t in self.fleet.open() if t.author == author):
                concerns = not robots or task.robot in robots or set(task.among) <= set(robots)
                paused = why is TaskReason.CANCELLED and task.state is TaskState.PAUSED
                holds = paused or task.state not in RESTING
                if concerns and holds and task.id not in held:
                    held[task.id] = task
                    self.why.pop(task.id, None)
                    await self._feed(e.TaskHeld(task.id, why))
            async with self._changes.turn():
                pass
        return tuple(held.values())

    async def first_time(self, cid: CommandId) -> None:
        """See that a message has its effect once, whatever crashes after this.

        Raises:
            Repeated: It had.
            RecordUnavailable: Nothing may follow from it now.
        """
        async with self._changes.turn() as turn:
            self.origins.check(cid)
            await turn.write(tuple(self.origins.facts(cid, self._clock.wall_ns())))

    def _do(self, doings: Iterable[e.Doing]) -> None:
        for doing in doings:
            if isinstance(doing, e.BeginAttempt):
                self._spawn(self._begin(doing))
            elif isinstance(doing, e.RecallAttempt):
                self._spawn(self._recall(doing))
            else:
                self._forget_attempt(doing.after)
                self.tell.emit(doing.before, doing.after)

    def _forget_attempt(self, task: Task) -> None:
        if task.state not in HELD:
            self.begun.pop(task.id, None)
        if task.state in OVER or task.state in RESTING:
            self.patience.forget(task.id)

    def _spawn(self, work: Coroutine[object, object, None]) -> None:
        self._tasks.begin(work)

    # ---- what follows ----

    async def _begin(self, doing: e.BeginAttempt) -> None:
        while self.behind():  # a stop may be on its way: until it is heard nothing begins
            await self._clock.sleep(BEHIND_S)
        task = self.fleet.tasks.get(doing.task)
        if task is not None and task.attempt == doing.attempt and self._counts(task):
            await self._ask(task, doing)  # else it was called back before it began

    async def _ask(self, task: Task, doing: e.BeginAttempt) -> None:
        said = self.letters.get(task.id)
        if said is None:
            await self._feed(e.TaskHeld(task.id, TaskReason.CANCELLED))
            return
        asker = TaskRequester(partial(self._over, task), partial(self._counts, task))
        try:
            attempt = await self._attempting.attempt(task, doing, said, asker)
        except Refusal as refusal:
            if self._counts(task):
                await self._refused(task, refusal)
        except (RosicError, Exception):
            log.exception("task %s could not be given to %s", task.id, doing.robot)
            await self._feed(e.AttemptEnded(task.id, doing.attempt, e.AttemptEnd.UNKNOWN))
        else:
            if attempt is None:
                self._give_back(doing.robot, task.author)
                return
            before = self.begun.get(task.id)
            took = attempt.took or (before is not None and before.took)  # with an earlier step
            self.begun[task.id] = attempt._replace(took=took)
            await self._feed(e.AttemptBegun(task.id, doing.attempt))

    async def _refused(self, task: Task, refusal: Refusal) -> None:
        """An attempt was not admitted, or not claimed."""
        self.why[task.id] = refusal.sentence
        self.patience.refused(task.id, task.robot, self._clock.monotonic_ns())
        if isinstance(refusal, Unrecognised):
            await self._feed(e.TaskHeld(task.id, TaskReason.PAUSED))
        else:
            await self._feed(e.AttemptEnded(task.id, task.attempt, end_of(refusal)))

    def _counts(self, task: Task) -> bool:
        """Whether the attempt that a task had is still the one to be made."""
        now = self.fleet.tasks.get(task.id)
        return (
            now is not None
            and now.attempt == task.attempt
            and now.state in HELD
            and not now.leaving
        )

    def _over(self, task: Task, order: Order, outcome: Outcome) -> None:
        """An order has ended, and that is on disk."""
        attempt, robot = self.begun.get(task.id), order.robot
        number = task.attempt
        if self._closing:
            self._note(e.AttemptEnded(task.id, number, e.AttemptEnd.SHUT_DOWN), outcome)
            return
        current = self.fleet.tasks.get(task.id)
        if current is not None and current.author != task.author:
            self._give_back(robot, task.author)  # it was handed over meanwhile
        stopped = self._rooms.stops[robot].generation != order.permit.stop_generation
        end = end_after(outcome, stopped=stopped)
        self.why[task.id] = outcome.note  # not what an earlier attempt came to
        if end is e.AttemptEnd.DONE:
            self.finished[robot] = self.finished.get(robot, 0) + 1
        if end is e.AttemptEnd.BUSY:
            self.patience.refused(task.id, robot, self._clock.monotonic_ns())
        self._spawn(self._ended(e.AttemptEnded(task.id, number, end), robot, attempt))

    async def _ended(
        self, event: e.AttemptEnded, robot: RobotId, attempt: TaskAttempt | None
    ) -> None:
        await self._feed(event)
        took = attempt is not None and attempt.number == event.attempt and attempt.took
        if took and robot not in self.fleet.holds:
            self._give_back(robot, self.fleet.tasks[event.task].author)

    def _give_back(self, robot: RobotId, author: str) -> None:
        """Let others have a robot at once that was taken for a task alone."""
        organiser = self._rooms.organiser
        if organiser.holder(robot) == author and not organiser.lease(robot).active:
            organiser.release(robot)
            self.changed.emit()

    def _note(self, event: e.AttemptEnded, outcome: Outcome) -> None:
        """ROSIC is being shut down: what is known is kept, and nothing begins because of it."""
        known = self.fleet.tasks.get(event.task)
        ends: e.Event = event
        if outcome.ending is OrderEnding.DONE:
            ends = e.AttemptEnded(event.task, event.attempt, e.AttemptEnd.DONE)
        elif known is not None and known.leaving:
            ends = e.RobotRested(event.task, event.attempt)
        step = react(self.fleet, ends, self._clock.wall_ns())
        self._changes.note(self.fleet.facts(step))

    async def _recall(self, doing: e.RecallAttempt) -> None:
        task = self.fleet.tasks[doing.task]
        cid = attempt_id(task, doing.attempt)
        self.rested[task.id] = await self._recalling.recall(doing, task.author, cid)
        await self._feed(e.RobotRested(doing.task, doing.attempt))

    async def _feed(self, event: e.Event) -> None:
        try:
            await self.feed(event, happened=True)
        except RecordUnavailable:
            log.warning("what became of task %s could not be written down", event)

    # ---- beginning and ending ----

    async def settle(self, ends: Callable[[Task], e.AttemptEnd | None]) -> None:
        """Settle tasks that had a robot when the last run ended.

        Args:
            ends: Returns what is known of the order of such a task; None: it was claimed, and
                nobody saw its end.
        """
        for key in tuple(self.fleet.holds.values()):
            await self._feed(e.TaskFound(key, ends(self.fleet.tasks[key])))

    def shut(self) -> None:
        """From now on nothing begins; what ends is still noted."""
        self._closing = True

    async def close(self) -> None:
        """Give up what is still being asked for."""
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
