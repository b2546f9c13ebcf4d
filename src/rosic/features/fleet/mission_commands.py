"""``/mission`` and ``/missions``: what several robots do, begun, paused and cancelled as one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from msgspec.structs import replace

from rosic.core.alerts.condition import seconds
from rosic.core.fleet import events as e
from rosic.core.fleet.mission import Late, Mission, lay_out
from rosic.core.fleet.task import (
    OVER,
    RESTING,
    Task,
    TaskDeadline,
    TaskNeed,
    TaskReason,
    TaskState,
    idle_first,
)
from rosic.core.fleet.template import bounds, read_values, texts_of
from rosic.core.i18n import joined
from rosic.core.language.ast import Misunderstood
from rosic.core.language.suggestions import did_you_mean
from rosic.core.language.time_parser import read_when
from rosic.core.policy.scope import FLEET
from rosic.core.records import Decided, Fact
from rosic.core.time_units import MINUTE_NS
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, Refusal, TooManyRequests
from rosic.features.fleet import mission_messages as words
from rosic.features.fleet.dispatch_state import TaskText
from rosic.features.fleet.mission_builder import EDITS
from rosic.features.fleet.mission_schedule import KIND as TIMES
from rosic.features.fleet.mission_schedule import PLANS_AT_MOST, MissionChat, MissionPlan
from rosic.features.fleet.task_commands import ANY, ASSIGN, check_room
from rosic.features.fleet.task_parser import PermittedSteps, RobotSteps, able
from rosic.gateway.cancel import CancelGeneration
from rosic.gateway.commands import Reply
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.core.fleet.mission import MissionTask
    from rosic.core.fleet.template import TemplateValues
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatcher import Given
    from rosic.features.fleet.mission_builder import MissionBuilder
    from rosic.features.fleet.mission_schedule import MissionSchedule
    from rosic.features.fleet.task_commands import TaskCommands
    from rosic.features.fleet.task_parser import CapableRobots
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.transactions import Transactions
    from rosic.organiser.timezones import Zone

NUMBERED: Final = "-"
"""Between the name of a mission and the number of its first task: it may run more than once."""
ACTS: Final[dict[str, TaskReason | None]] = {
    "pause": TaskReason.PAUSED,
    "cancel": TaskReason.CANCELLED,
    "go": None,
    "resume": None,
}
GO_ON: Final = frozenset(verb for verb, reason in ACTS.items() if reason is None)


class ResolvedMission(NamedTuple):
    """What is to be begun.

    Attributes:
        given: What was said for what it leaves open.
        where: Where its orders are shown.
    """

    mission: Mission
    given: Mapping[str, float]
    where: MissionChat


class MissionCommands:
    """The handler of missions."""

    def __init__(
        self,
        rooms: Components,
        changes: Transactions,
        tasks: TaskCommands,
        builder: MissionBuilder,
        timetable: MissionSchedule,
        zone: Zone,
    ) -> None:
        self._rooms = rooms
        self._dispatching = tasks.dispatching
        self._changes = changes
        self._timetable = timetable
        self._zone = zone
        self._tasks = tasks
        self._builder = builder
        self._book = builder.book

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("mission", self.mission)
        commands.register("missions", self.missions)

    async def missions(self, asked: CommandContext) -> Reply:
        """List what there is, and what runs."""
        runs = [self._run_line(run) for run in self.open_runs(asked.caller.principal)]
        runs += self._times()
        missions = self._book.of(asked.caller.principal)
        known = [words.known(mission.name, mission.title) for mission in missions.values()]
        if not known and not runs:
            return Reply(words.NONE)
        return Reply(joined("\n", [*runs, *known]), words.start_buttons(missions))

    async def mission(self, asked: CommandContext) -> Reply:
        """Start a mission, or do something with one that runs.

        Raises:
            NotUnderstood: No such mission, or nothing to do.
            NotPermitted: Somebody else's.
            Expired: Robots would move because of it, and it was not sent just now.
        """
        who = asked.caller.principal
        verb, said = self._words(asked.rest, who)
        name = said.casefold()
        if not verb:
            return await self.missions(asked)
        if verb in EDITS:
            return await self._builder.edit(asked, verb, said)
        starts = self._starts(verb, said, who)
        if starts or (name and verb in GO_ON):
            check_command_fresh(asked.inbound, f"/mission {asked.rest}")
        if starts:
            return await self._start(asked, starts)
        if verb == "off" and name:
            return await self._off(asked, name)
        if verb in ACTS and name:
            return await self._act(asked, verb, self._running(asked, name))
        if not name and (verb in self._book.of(who) or self._runs_of(verb)):
            return self._show(asked, verb)
        raise NotUnderstood(words.HOW_TO)

    def _words(self, rest: str, who: PrincipalId) -> tuple[str, str]:
        """Return the verb of a command, as it is called in English, and what follows it."""
        verb, _, said = rest.strip().partition(" ")
        verb = verb.casefold()
        if verb not in self._book.of(who):
            verb = self._rooms.vocabulary.commands.verb("mission", verb)
        return verb, said.strip()

    def _starts(self, verb: str, said: str, who: PrincipalId) -> str:
        """Return what is started, and with what; empty: nothing is."""
        if not said or verb == "start":
            return said
        known = verb in self._book.of(who) and verb not in {*ACTS, "off"}
        return f"{verb} {said}" if known else ""

    def asked(self, rest: str, who: PrincipalId) -> list[RobotSteps]:
        """Return which robots each task of a mission is for that is started, and what they do.

        Raises:
            Refusal: It is not begun: it is said badly.
        """
        name, _, said = self._starts(*self._words(rest, who), who).partition(" ")
        if not name:
            return []
        mission = self._named(name.casefold(), who)
        given = read_values(said, mission.parameters, self._rooms.vocabulary.units).given
        leaves = self._laid_out(mission, given)
        robots = {on: self._robots(on, who) for on in {leaf.part.on for leaf in leaves}}
        return [RobotSteps(robots[leaf.part.on], leaf.steps) for leaf in leaves]

    async def _act(self, asked: CommandContext, verb: str, run: str) -> Reply:
        """Do something with every task of a mission; those for which it makes no sense stay."""
        tasks = self._dispatching.fleet.mission(run)
        for task in tasks:
            self._tasks.check_theirs(asked, task)
        await self._dispatching.first_time(asked.cid)
        changed = 0
        for task in idle_first(tasks):
            if ACTS[verb] is not None:
                changed += await self._feed(
                    asked, e.TaskHeld(task.id, ACTS[verb] or TaskReason.NONE)
                )
            elif task.state is not TaskState.UNKNOWN:  # whether it was done is asked task by task
                changed += await self._feed(asked, e.TaskReleased(task.id))
        return Reply(
            joined("\n", [words.changed(changed), *self._tasks_of(run, asked.caller.principal)])
        )

    async def _feed(self, asked: CommandContext, event: e.TaskHeld | e.TaskReleased) -> bool:
        return await self._dispatching.feed(event, self._decided(asked, "mission", event.task))

    def _decided(self, asked: CommandContext, act: str, about: str) -> Decided:
        who, now_ns = asked.caller.principal, self._rooms.organiser.wall_ns()
        return Decided(act=act, by=who, about=about, at_ns=now_ns, digest=asked.cid)

    # ---- which ----

    def _named(self, name: str, who: PrincipalId) -> Mission:
        missions = self._book.of(who)
        mission = missions.get(name)
        if mission is None:
            close = did_you_mean(name, sorted(missions))
            offers = tuple(f"/mission start {other}" for other in close)
            raise NotUnderstood(words.no_mission(name), offers=offers)
        return mission

    def _runs_of(self, name: str) -> list[str]:
        """Return the runs that a name means, the newest last: ``restock`` or ``restock-7``."""
        runs = self._dispatching.fleet.missions
        return [run for run in runs if run == name or run.rpartition(NUMBERED)[0] == name]

    def _running(self, asked: CommandContext, name: str) -> str:
        sees = self.open_runs(asked.caller.principal)
        found = [run for run in self._runs_of(name) if run in sees]
        if not found:
            raise NotUnderstood(words.not_running(name))
        if len(found) > 1:
            offers = tuple(f"/mission {asked.rest.split()[0]} {run}" for run in found)
            raise NotUnderstood(words.which(name), offers=offers)
        return found[0]

    def open_runs(self, who: PrincipalId) -> list[str]:
        """Return the missions that run, as far as somebody may see."""
        fleet, visible = self._dispatching.fleet, self._rooms.organiser.visible(who)
        return [
            run
            for run in fleet.missions
            if not all(task.over for task in fleet.mission(run))
            and any(t.author == who or not visible.isdisjoint(t.among) for t in fleet.mission(run))
        ]

    # ---- showing ----

    def _show(self, asked: CommandContext, name: str) -> Reply:
        who = asked.caller.principal
        runs = [run for run in self.open_runs(who) if run in self._runs_of(name)]
        lines = [line for run in runs for line in (self._run_line(run), *self._tasks_of(run, who))]
        mission = self._book.of(who).get(name)
        if mission is not None:
            lines.append(words.known(mission.name, mission.title))
            lines += [bounds(*quantity) for quantity in mission.parameters.items()]
            lines += [
                words.leaf(number, leaf.part.on, leaf.steps, leaf.after)
                for number, leaf in enumerate(self._laid_out(mission), 1)
            ]
        buttons = words.run_buttons(runs[-1]) if runs else words.start_buttons((name,))
        return Reply(joined("\n", lines or [words.not_running(name)]), buttons)

    def _run_line(self, run: str) -> str:
        tasks = self._dispatching.fleet.mission(run)
        done = sum(task.state is TaskState.DONE for task in tasks)
        return words.run(run, done, len(tasks), sum(task.state in RESTING for task in tasks))

    def _tasks_of(self, run: str, who: PrincipalId) -> list[str]:
        tasks = self._dispatching.fleet.mission(run)
        return [self._tasks.line(task, who) for task in tasks if task.state not in OVER]

    # ---- starting ----

    async def _start(self, asked: CommandContext, said: str) -> Reply:
        """Begin a mission now, or say when it is to begin: ``restock every mon 8:00``.

        What it leaves open is said before that: ``restock distance=2 m every mon 8:00``.
        """
        name, _, rest = said.partition(" ")
        mission = self._named(name.casefold(), asked.caller.principal)
        values = read_values(rest, mission.parameters, self._rooms.vocabulary.units)
        texts_of(mission.parameters, values.given)  # that nothing is missing
        where = MissionChat(asked.messenger.name, asked.inbound.chat)
        if values.rest:
            return await self._plan(asked, mission, values, where)
        meant = ResolvedMission(mission, values.given, where)
        run, count = await self._begin(asked.caller.principal, meant, asked.cid)
        return Reply(words.started(mission.shown, run, count), words.run_buttons(run))

    async def at_its_time(self, plan: MissionPlan, where: MissionChat, cid: CommandId) -> str:
        """Begin a mission because its time has come. Return what to tell.

        Raises:
            Refusal: Whoever planned it may not any more, or nobody can carry it out.
        """
        organiser = self._rooms.organiser
        organiser.check_unlocked(self._rooms.authoriser.stand_for(plan.author))
        mission = self._named(plan.mission, plan.author)
        meant = ResolvedMission(mission, plan.values, where)
        run, count = await self._begin(plan.author, meant, cid)
        return words.started(mission.shown, run, count)

    async def _begin(
        self, who: PrincipalId, meant: ResolvedMission, cid: CommandId
    ) -> tuple[str, int]:
        """Give all tasks of a mission at once; each waits for those before it."""
        self._dispatching.origins.check(cid)
        before = CancelGeneration(self._rooms.stops, who, self._rooms.profiles)
        tasks = await self._capable(who, meant)

        def made() -> Given:
            for _, found in tasks:
                before.check(found.robots)
            return self._made(who, meant, cid, tasks)

        given = await self._dispatching.give(cid, made)
        return given[0][0].mission, len(given)

    def _laid_out(
        self, mission: Mission, given: Mapping[str, float] | None = None
    ) -> list[MissionTask]:
        return lay_out(mission, self._book.of_files, self._rooms.vocabulary.units, given)

    async def _capable(
        self, who: PrincipalId, meant: ResolvedMission
    ) -> list[tuple[MissionTask, CapableRobots]]:
        """Return the tasks of a mission, each with who can carry it out.

        Raises:
            TooManyRequests, NotUnderstood: None of it is begun.
        """
        leaves = self._laid_out(meant.mission, meant.given)
        check_room(self._dispatching.fleet, who, len(leaves))
        steps = PermittedSteps(self._rooms, who)
        found = [await self._able(who, steps, leaf, n) for n, leaf in enumerate(leaves, 1)]
        return list(zip(leaves, found, strict=True))

    async def _able(
        self, who: PrincipalId, steps: PermittedSteps, leaf: MissionTask, number: int
    ) -> CapableRobots:
        """Return who can carry out one task.

        Raises:
            NotUnderstood: Nobody; none of the mission is begun.
        """
        on = leaf.part.on
        fleet, robots = self._dispatching.fleet, self._robots(on, who)
        found = await able(steps, self._rooms, fleet, robots, leaf.steps)
        if not found.robots:
            why = found.lacking.why.sentence if found.lacking is not None else ""
            raise NotUnderstood(words.nobody_can(number, on, why))
        return found

    def _made(
        self,
        who: PrincipalId,
        meant: ResolvedMission,
        cid: CommandId,
        leaves: Sequence[tuple[MissionTask, CapableRobots]],
    ) -> Given:
        """Return the tasks of a mission, each of those who can carry it out.

        Raises:
            TooManyRequests: None of it is begun.
        """
        fleet, mission, where = self._dispatching.fleet, meant.mission, meant.where
        check_room(fleet, who, len(leaves))
        first = int(fleet.next_id())
        run = f"{mission.name}{NUMBERED}{first}"
        given = [
            (
                replace(
                    self._task(who, leaf, found, run, first + number), due=self._due(mission, leaf)
                ),
                TaskText(leaf.steps, where.messenger, where.chat),
            )
            for number, (leaf, found) in enumerate(leaves)
        ]
        decided = Decided(
            act="mission", by=who, about=run, at_ns=self._rooms.organiser.wall_ns(), digest=cid
        )
        return given, decided

    def _task(
        self, who: PrincipalId, leaf: MissionTask, found: CapableRobots, run: str, number: int
    ) -> Task:
        part, first = leaf.part, int(run.rpartition(NUMBERED)[2])
        units = self._rooms.vocabulary.units
        return Task(
            id=str(number),
            author=who,
            among=found.robots,
            wanted="" if part.on in ANY else part.on,
            steps=len(leaf.steps),
            skills=found.skills,
            priority=part.priority,
            given_ns=self._rooms.organiser.wall_ns(),
            expected_ns=int(seconds(part.within, units) * 1e9) if part.within else 0,
            once=part.once,
            need=TaskNeed(part.battery, part.localised),
            place=found.place,
            mission=run,
            after=tuple(str(first + other) for other in leaf.after),
        )

    def _due(self, mission: Mission, leaf: MissionTask) -> TaskDeadline:
        """Return by when one task of a mission is to be done that begins now."""
        units, part = self._rooms.vocabulary.units, leaf.part
        at_ns = 0
        if mission.deadline:
            at_ns = self._rooms.organiser.wall_ns() + int(seconds(mission.deadline, units) * 1e9)
        return TaskDeadline(
            lasts_ns=int(seconds(part.deadline, units) * 1e9) if part.deadline else 0,
            at_ns=at_ns,
            cancels=part.late is Late.CANCEL,
            cancels_all=mission.late is Late.CANCEL,
        )

    # ---- at its time ----

    async def _plan(
        self, asked: CommandContext, mission: Mission, values: TemplateValues, where: MissionChat
    ) -> Reply:
        """Write down when a mission begins by itself.

        Raises:
            NotUnderstood, OutOfBounds: That says no time, or one that is over.
            TooManyRequests: There are too many.
        """
        timetable, now_ns = self._timetable, self._rooms.organiser.wall_ns()
        when = read_when(f"{values.rest.casefold()} 1 min", now_ns, self._zone.local)
        if isinstance(when, Misunderstood):
            raise NotUnderstood(when.sentence)
        who, first = asked.caller.principal, when.start
        if when.start_ns is not None and when.start_ns <= now_ns:  # in 20 s: with the next minute
            first = self._zone.local(when.start_ns + MINUTE_NS)
        plan = MissionPlan(mission.name, who, first, when.rrule, now_ns, values.given)
        at_ns = timetable.next_ns(plan)
        if at_ns is None:
            raise OutOfBounds(words.NEVER)
        decided = Decided(
            act="mission-time", by=who, about=mission.name, at_ns=now_ns, digest=asked.cid
        )
        async with self._changes.turn() as turn:
            if len(timetable.plans) >= PLANS_AT_MOST:
                raise TooManyRequests(words.too_many_times(PLANS_AT_MOST), retry_after_s=60.0)
            key = timetable.next_key()
            await turn.write((decided, timetable.fact(key, plan, where)))
        timetable.look()
        moment = self._rooms.organiser.moment("", at_ns)  # as it is kept
        text = words.planned(key, mission.name, moment, again=bool(when.rrule))
        meant = ResolvedMission(mission, values.given, where)
        remark = await self._conflict(who, meant)
        return Reply(joined("\n", filter(None, (text, remark))), words.off_button(key))

    async def _conflict(self, who: PrincipalId, meant: ResolvedMission) -> str:
        """Return what would keep a mission from beginning now; empty if nothing would.

        It is planned all the same: until its time comes, a robot may be back, or a right given.
        """
        try:
            await self._capable(who, meant)
        except Refusal as why:
            return words.could_not_begin_now(why.sentence)
        return ""

    async def _off(self, asked: CommandContext, key: str) -> Reply:
        """Take a time back.

        Raises:
            NotUnderstood: There is none with that number.
            NotPermitted: Somebody else's.
        """
        organiser, who = self._rooms.organiser, asked.caller.principal
        plan = self._timetable.plans.get(key)
        if plan is None:
            raise NotUnderstood(words.no_time(key))
        if plan.author != who and not organiser.rights.holds(
            who, FLEET, ASSIGN, organiser.wall_ns()
        ):
            raise NotPermitted(words.not_your_time(organiser.name_of(plan.author)))
        decided = self._decided(asked, "mission-off", plan.mission)
        async with self._changes.turn() as turn:
            await turn.write((decided, Fact(kind=TIMES, key=key, body=b"")))
        return Reply(words.taken_back(plan.mission))

    def _times(self) -> list[str]:
        organiser = self._rooms.organiser
        found: list[str] = []
        for key, plan in self._timetable.plans.items():
            at_ns = self._timetable.next_ns(plan)
            if at_ns is not None:
                moment = organiser.moment("", at_ns)
                found.append(words.planned(key, plan.mission, moment, again=bool(plan.rrule)))
        return found

    def _robots(self, name: str, who: PrincipalId) -> tuple[RobotId, ...]:
        visible, vocabulary = self._rooms.organiser.visible(who), self._rooms.vocabulary
        if name in ANY:
            return tuple(sorted(visible))
        profile = vocabulary.robot(name)
        meant = vocabulary.members(name) if profile is None else (profile.id,)
        return tuple(robot for robot in meant if robot in visible)
