"""``/task`` and ``/tasks``: what people ask about tasks, and of them."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.core.fleet import events as e
from rosic.core.fleet.task import (
    HELD,
    OVER,
    RESTING,
    Task,
    TaskNeed,
    TaskReason,
    TaskState,
)
from rosic.core.i18n import joined
from rosic.core.language.suggestions import did_you_mean
from rosic.core.messages import no_robot_or_group
from rosic.core.policy.scope import FLEET
from rosic.core.records import Decided
from rosic.errors import NotPermitted, NotUnderstood, Refusal, TooManyRequests
from rosic.features.fleet import messages as words
from rosic.features.fleet.alternatives import refused
from rosic.features.fleet.dispatch_state import TaskText
from rosic.features.fleet.monitor import why_waits
from rosic.features.fleet.task_parser import (
    ANYBODY,
    PermittedSteps,
    RobotSteps,
    able,
    check_units,
    read_wish,
    readings,
)
from rosic.gateway.cancel import CancelGeneration
from rosic.gateway.commands import Reply
from rosic.gateway.pending_work import TaskEntry
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.core.fleet.state import FleetState
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.alternatives import MissingPart
    from rosic.features.fleet.dispatcher import Given, TaskDispatcher
    from rosic.features.fleet.integration import TaskNotifications
    from rosic.features.fleet.task_parser import CapableRobots, TaskWish
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.translation import ChatLanguages

OPEN_AT_MOST: Final = 2_000
OF_ONE_AT_MOST: Final = 500
"""So many are one person's, so that nobody keeps the others from giving any."""
SHOWN_AT_MOST: Final = 20
READINGS_OF_ONE: Final = 200
"""So many readings of a step cost somebody as much of their rate as one more line."""
ANY: Final = frozenset({ANYBODY, "anybody", "anyone", "irgendwer"})
ASSIGN: Final = "assign"


class TaskCommands:
    """The handler of tasks.

    Attributes:
        dispatching: Where they change.
    """

    def __init__(
        self,
        rooms: Components,
        dispatching: TaskDispatcher,
        telling: TaskNotifications,
        languages: ChatLanguages,
    ) -> None:
        self._rooms = rooms
        self.dispatching = dispatching
        self._telling = telling
        self._languages = languages
        self._acts = {
            "pause": self._pause,
            "cancel": self._cancel,
            "go": self._go,
            "resume": self._go,
            "retry": self._go,
            "done": self._was_done,
            # In German.
            "pausieren": self._pause,
            "abbrechen": self._cancel,
            "weiter": self._go,
            "erledigt": self._was_done,
        }

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("task", self.task)
        commands.register("tasks", self.tasks)

    # ---- looking ----

    async def tasks(self, asked: CommandContext) -> Reply:
        """List the tasks that are open, as far as their robots may be seen."""
        return Reply(self._list(asked.caller.principal))

    def open_for(self, who: PrincipalId) -> list[Task]:
        """Return the open tasks that somebody may see, those that have a robot first."""
        visible = self._rooms.organiser.visible(who)
        found = [t for t in self.dispatching.fleet.open() if self._sees(who, t, visible)]
        found.sort(key=lambda task: (task.state not in HELD, -task.priority))
        return found

    def entry(self, task: Task, who: PrincipalId) -> TaskEntry:
        """Return one task, as somebody may read it."""
        why = self._waits(task, who) if task.state is TaskState.QUEUED else ""
        return TaskEntry(task, self._telling.what(task, who), why)

    def _list(self, who: PrincipalId) -> str:
        found = self.open_for(who)
        if not found:
            return words.NONE_OPEN
        lines = [self.line(task, who) for task in found[:SHOWN_AT_MOST]]
        if len(found) > SHOWN_AT_MOST:
            lines.append(words.and_more(len(found) - SHOWN_AT_MOST))
        return joined("\n", lines)

    def _sees(self, who: PrincipalId, task: Task, visible: frozenset[RobotId]) -> bool:
        return task.author == who or not visible.isdisjoint(task.among)

    def line(self, task: Task, who: PrincipalId) -> str:
        """Return one task in a list, as somebody may read it."""
        shown = self._telling.shown(task.robot) if task.robot else ""
        _, what, why = self.entry(task, who)
        return words.line(task, what, shown or task.wanted, why)

    def _waits(self, task: Task, who: PrincipalId) -> str:
        visible = self._rooms.organiser.visible(who)
        return why_waits(self._rooms, self.dispatching.fleet, task, visible)

    # ---- giving ----

    async def task(self, asked: CommandContext) -> Reply:
        """Give a task, or do something with one: ``/task pause 7``.

        Raises:
            NotUnderstood: No such robot, group, skill or task.
            NotPermitted: Not theirs to ask for.
            OutOfBounds: A value, a number or a time that makes no sense.
            Expired: Robots would move because of it, and it was not sent just now.
            OrderVoid: It was cancelled meanwhile.
            TooManyRequests: There are too many.
        """
        first, *rest = asked.rest.split() or [""]
        act = self._acts.get(first.casefold())
        if act is not None and len(rest) == 1 and rest[0].isdecimal():
            return await act(asked, self._named(asked, rest[0]))
        if not first:
            return Reply(joined("\n", (words.HOW_TO, self._list(asked.caller.principal))))
        if first.isdecimal() and not rest:
            task = self._named(asked, first)
            return Reply(self.line(task, asked.caller.principal), words.choices(task))
        return await self._give(asked)

    def asked(self, rest: str, who: PrincipalId) -> list[RobotSteps]:
        """Return which robots a new task is for, and what they are to do; empty: it is no task.

        Args:
            rest: As typed after the verb.
            who: Whoever gives it.

        Raises:
            Refusal: It is not given: it is said badly, or for nobody.
        """
        first, *more = rest.split() or [""]
        if not more or (first.casefold() in self._acts and len(more) == 1 and more[0].isdecimal()):
            return []
        organiser = self._rooms.organiser
        wish = read_wish(rest, organiser.wall_ns(), organiser.calendar.zone(who))
        _, robots, used = self._target(wish, who)
        lines = wish.lines(used)
        readings(robots, lines)
        return [RobotSteps(robots, lines)]

    async def _give(self, asked: CommandContext) -> Reply:
        check_command_fresh(asked.inbound, f"/task {asked.rest}")
        self.dispatching.origins.check(asked.cid)
        check_room(self.dispatching.fleet, asked.caller.principal, 1)
        organiser, who = self._rooms.organiser, asked.caller.principal
        wish = read_wish(asked.rest, organiser.wall_ns(), organiser.calendar.zone(who))
        wanted, robots, used = self._target(wish, who)
        before = CancelGeneration(self._rooms.stops, who, robots)
        lines = wish.lines(used)
        organiser.charge_work(asked.caller, readings(robots, lines) / READINGS_OF_ONE)
        steps = PermittedSteps(self._rooms, who)
        found = await able(steps, self._rooms, self.dispatching.fleet, robots, lines)
        if not found.robots:
            raise self._nobody(wanted, found.lacking, partial(wish.typed, used))
        if asked.inbound.nonce is None:
            typed = partial(wish.typed, used)
            check_units(self._rooms, self._languages.of(who), found.robots[0], lines, typed)

        def made() -> Given:
            before.check(found.robots)
            return self._made(asked, wish, wanted, lines, found)

        [(task, said)] = await self.dispatching.give(asked.cid, made)
        names = [self._telling.shown(robot) for robot in task.among]
        until_ns = task.until_ns
        by = organiser.moment(who, until_ns) if until_ns else ""
        return Reply(words.given(task, said.shown, words.one_of(names), by))

    def _made(
        self,
        asked: CommandContext,
        wish: TaskWish,
        wanted: str,
        lines: tuple[str, ...],
        found: CapableRobots,
    ) -> Given:
        """Return the task that somebody asks for, of those who can carry it out.

        Raises:
            TooManyRequests: There are too many by now.
        """
        fleet, who = self.dispatching.fleet, asked.caller.principal
        check_room(fleet, who, 1)
        now_ns = self._rooms.organiser.wall_ns()
        task = Task(
            id=fleet.next_id(),
            author=who,
            among=found.robots,
            wanted=wanted,
            steps=len(lines),
            skills=found.skills,
            priority=wish.priority,
            given_ns=now_ns,
            until_ns=wish.until_ns,
            expected_ns=int(wish.expected_s * 1e9),
            once=wish.once,
            need=TaskNeed(wish.battery, wish.localised),
            place=found.place,
        )
        said = TaskText(lines, asked.messenger.name, asked.inbound.chat)
        decided = Decided(act="task", by=who, about=task.id, at_ns=now_ns, digest=asked.cid)
        return [(task, said)], decided

    def _nobody(
        self, wanted: str, lacking: MissingPart | None, typed: Callable[[Sequence[str]], str]
    ) -> Refusal:
        """Return why nobody can, and which tasks could be given instead."""
        if lacking is None:
            return NotUnderstood(no_robot_or_group(wanted or "?"))
        sentence = lacking.why.sentence
        if wanted not in self._rooms.profiles:
            sentence = words.nobody_can(wanted, sentence)
        return refused(lacking, sentence, typed)

    def _target(self, wish: TaskWish, who: PrincipalId) -> tuple[str, tuple[RobotId, ...], int]:
        """Return whom the first words mean, and how many words they are.

        Raises:
            NotUnderstood: No robot or group that this person sees.
        """
        visible, vocabulary = self._rooms.organiser.visible(who), self._rooms.vocabulary
        low = [word.casefold() for word in wish.words]
        if low[:1] and low[0] in ANY:
            return "", tuple(sorted(visible)), 1
        for used in range(min(len(low), 4), 0, -1):
            name = " ".join(low[:used])
            profile = vocabulary.robot(name)
            meant = vocabulary.members(name) if profile is None else (profile.id,)
            seen = tuple(robot for robot in meant if robot in visible)
            if seen:
                return (profile.id if profile else name), seen, used
        known = [name for name in vocabulary.names if name not in vocabulary.profiles]
        close = did_you_mean(low[0], (*sorted(visible), *known)) if low else ()
        rest = " ".join(wish.words[1:])
        offers = tuple(f"/task {name} {rest}".strip() for name in close)
        raise NotUnderstood(no_robot_or_group(wish.words[0] if low else "?"), offers=offers)

    # ---- what people do to one ----

    def _named(self, asked: CommandContext, number: str) -> Task:
        who = asked.caller.principal
        task = self.dispatching.fleet.tasks.get(number)
        if task is None or not self._sees(who, task, self._rooms.organiser.visible(who)):
            raise NotUnderstood(words.no_such_task(number))
        return task

    def check_theirs(self, asked: CommandContext, task: Task) -> None:
        """See that somebody may decide about a task.

        Raises:
            NotPermitted: It is somebody else's.
        """
        organiser, who = self._rooms.organiser, asked.caller.principal
        if task.author != who and not organiser.rights.holds(
            who, FLEET, ASSIGN, organiser.wall_ns()
        ):
            raise NotPermitted(words.not_yours(task, organiser.name_of(task.author)))

    async def _act(self, asked: CommandContext, task: Task, event: e.Event, act: str) -> Reply:
        self.check_theirs(asked, task)
        await self.dispatching.first_time(asked.cid)
        decided = Decided(
            act=f"task-{act}",
            by=asked.caller.principal,
            about=task.id,
            at_ns=self._rooms.organiser.wall_ns(),
            digest=asked.cid,
        )
        if not await self.dispatching.feed(event, decided):
            raise NotUnderstood(words.does_not_fit(self.dispatching.fleet.tasks[task.id]))
        now = self.dispatching.fleet.tasks[task.id]
        if now.leaving:
            return Reply(words.being_held(now, self._telling.shown(now.robot)))
        why = self._waits(now, asked.caller.principal) if now.state is TaskState.QUEUED else ""
        return Reply(words.now_is(now, why))

    async def _pause(self, asked: CommandContext, task: Task) -> Reply:
        return await self._act(asked, task, e.TaskHeld(task.id, TaskReason.PAUSED), "pause")

    async def _cancel(self, asked: CommandContext, task: Task) -> Reply:
        if task.state in OVER:
            raise NotUnderstood(words.does_not_fit(task))
        return await self._act(asked, task, e.TaskHeld(task.id, TaskReason.CANCELLED), "cancel")

    async def _go(self, asked: CommandContext, task: Task) -> Reply:
        if task.state not in RESTING:
            raise NotUnderstood(words.does_not_fit(task))
        if task.too_late(self._rooms.organiser.wall_ns()):
            raise NotUnderstood(words.begins_no_more(task))
        check_command_fresh(asked.inbound, f"/task go {task.id}")
        return await self._act(asked, task, e.TaskReleased(task.id), "go")

    async def _was_done(self, asked: CommandContext, task: Task) -> Reply:
        if task.state is not TaskState.UNKNOWN:
            raise NotUnderstood(words.does_not_fit(task))
        check_command_fresh(asked.inbound, f"/task done {task.id}")
        return await self._act(asked, task, e.TaskReleased(task.id, skip=True), "done")


def check_room(fleet: FleetState, who: PrincipalId, more: int) -> None:
    """See that so many more tasks of somebody can be taken in.

    Raises:
        TooManyRequests: There are too many, of theirs or of everybody's.
    """
    tasks = list(fleet.open())
    if sum(task.author == who for task in tasks) + more > OF_ONE_AT_MOST:
        raise TooManyRequests(words.too_many_of_one(OF_ONE_AT_MOST), retry_after_s=60.0)
    if len(tasks) + more > OPEN_AT_MOST:
        raise TooManyRequests(words.too_many(OPEN_AT_MOST), retry_after_s=60.0)
