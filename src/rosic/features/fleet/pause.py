"""``/pause`` and ``/continue``; and what a cancel means for tasks.

A task is paused between two attempts at a step, and its robot comes to rest. A single command has
no middle to go on from: no link to a robot can hold one, so it is cancelled or stopped.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet import events as e
from rosic.core.fleet.task import HELD, TaskReason, TaskState
from rosic.core.i18n import joined
from rosic.core.language import Resume
from rosic.core.language.compiled import fold
from rosic.core.message import Button
from rosic.core.messages import no_robot_or_group
from rosic.core.records import Decided
from rosic.errors import NotUnderstood, Refusal
from rosic.features.fleet import mission_messages as words
from rosic.gateway import cancel_messages
from rosic.gateway.commands import Reply
from rosic.gateway.message_context import MessageContext
from rosic.gateway.requests import check_command_fresh, is_said_to_us

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.order import Order
    from rosic.core.robot.profile import RobotId
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.hooks import PipelineHooks
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.gateway.resume import ResumeHandler


class PauseCommands:
    """Holds what somebody has under way, where that can be held, and lets it go on."""

    def __init__(
        self,
        rooms: Components,
        dispatching: TaskDispatcher,
        executor: OrderExecutor,
        resuming: ResumeHandler,
        hooks: PipelineHooks,
    ) -> None:
        self._rooms = rooms
        self._dispatching = dispatching
        self._executor = executor
        self._resuming = resuming
        self._hooks = hooks

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("pause", self.pause)
        commands.register("continue", self.go_on)

    async def cancel(self, principal: PrincipalId, robots: Collection[RobotId]) -> str:
        """Cancel somebody's tasks, those that wait too; return what to say, "" if there is none."""
        held = await self._dispatching.hold(principal, robots, TaskReason.CANCELLED)
        return words.cancelled([task.id for task in held]) if held else ""

    async def pause(self, asked: CommandContext) -> Reply:
        """Pause one's own tasks; say of single commands that they cannot be paused.

        Raises:
            NotUnderstood: A name means nobody.
        """
        who, robots = asked.caller.principal, self._named(asked)
        held = await self._dispatching.hold(who, robots, TaskReason.PAUSED)
        of_tasks = {task.robot for task in held if task.state in HELD}
        single = [
            order
            for order in self._executor.of(who)
            if order.robot not in of_tasks and (not robots or order.robot in robots)
        ]
        lines = [words.paused([task.id for task in held])] if held else []
        lines += [words.cannot_pause(self._shown(order.robot)) for order in single]
        if not lines:
            return Reply(cancel_messages.NOTHING)
        return Reply(joined("\n", lines), self._buttons(held, single))

    def _buttons(
        self, held: Collection[Task], single: Collection[Order]
    ) -> tuple[tuple[Button, ...], ...]:
        rows: list[tuple[Button, ...]] = []
        if held:
            rows.append((Button(words.CONTINUE, "/continue"), Button(words.CANCEL, "cancel all")))
        for order in tuple(single)[: words.BUTTONS_AT_MOST]:
            robot, shown = order.robot, self._shown(order.robot)
            stop = Button(cancel_messages.stop_label(shown), f"stop {robot}")
            rows.append((Button(cancel_messages.cancel_label(shown), f"cancel {robot}"), stop))
        return tuple(rows)

    async def go_on(self, asked: CommandContext) -> Reply:
        """Let one's own paused tasks go on; where none is, resume what one has stopped oneself.

        People say it to each other: in a group nothing goes on by it unless it is addressed to us
        or names a robot. What it could mean is offered then.

        Raises:
            NotUnderstood: A name means nobody, or it is to be said which robot may go on.
            RobotStopped: Somebody else stopped it; says who can resume it. Or it was not said to
                us; offers to.
            NotPermitted: One may not resume it.
            Expired: Robots would move because of it, and it was not sent just now.
            RecordUnavailable: A task stays paused; the sentence says which went on before it.
        """
        addressed = is_said_to_us(asked.inbound)
        try:
            who, robots = asked.caller.principal, self._named(asked)
        except NotUnderstood:
            if not addressed:
                return Reply("")
            raise
        meant = addressed or bool(robots)
        fleet = self._dispatching.fleet
        paused = [
            task
            for task in fleet.open()
            if task.author == who
            and task.state is TaskState.PAUSED
            and (not robots or not set(task.among).isdisjoint(robots))
        ]
        if not paused:
            return await self._resume(asked, robots) if meant else self._offered(who)
        if not meant:
            button = Button(words.CONTINUE, "/continue")
            return Reply(words.stay_paused([task.id for task in paused]), ((button,),))
        return await self._go_on(asked, paused)

    async def _go_on(self, asked: CommandContext, paused: Sequence[Task]) -> Reply:
        """Let paused tasks go on. What it raises, `go_on` says."""
        who = asked.caller.principal
        check_command_fresh(asked.inbound, f"/continue {asked.rest}".strip())
        await self._dispatching.first_time(asked.cid)
        at_ns = self._rooms.organiser.wall_ns()
        went_on = []
        for task in paused:
            decided = Decided(act="task-go", by=who, about=task.id, at_ns=at_ns, digest=asked.cid)
            try:
                if not task.too_late(at_ns) and await self._dispatching.feed(
                    e.TaskReleased(task.id), decided
                ):
                    went_on.append(task.id)
            except Refusal as why:
                if went_on:
                    why.reworded(joined("\n", (words.went_on(went_on), why.sentence)))
                raise
        return Reply(words.went_on(went_on) if went_on else words.TOO_LATE)

    async def _resume(self, asked: CommandContext, robots: tuple[RobotId, ...]) -> Reply:
        """Resume what is stopped, by the rights of a resume, if nothing else can be meant by it.

        That is what they stopped themselves, if it was named or is alone. Of a tap it cannot be
        told which stop was known to them, and somebody else's stop is theirs to think about: that
        is offered. So is what would let a robot begin by itself. What it raises, `go_on` says.
        """
        who = asked.caller.principal
        stops = self._rooms.stops
        seen = sorted(robots or self._rooms.organiser.visible(who))
        stopped = tuple(robot for robot in seen if stops[robot].latched)
        if not stopped:
            return Reply(words.NOTHING_PAUSED)
        if len(stopped) > 1 and not robots:
            stopped = ()  # which one is asked
        elif asked.inbound.nonce is not None or not all(stops[r].alone(who) for r in stopped):
            raise self._rooms.organiser.why_stopped.refusal(who, stopped)
        elif begins := self._begin_by_themselves(who, stopped):
            return begins
        message = MessageContext(
            asked.messenger, asked.inbound, asked.caller, 0, self._hooks.stepped_up
        )
        return Reply(await self._resuming.resume(message, Resume(stopped, named=True), asked.cid))

    def _begin_by_themselves(self, who: PrincipalId, stopped: Sequence[RobotId]) -> Reply | None:
        """Return the question whether robots may be resumed that begin a task then; mostly None."""
        tasks = self._dispatching.fleet.beginning(stopped)
        if not tasks or not all(self._resuming.may(who, robot) for robot in stopped):
            return None
        why = self._rooms.organiser.why_stopped.refusal(who, stopped)
        text = joined("\n", (why.sentence, self._resuming.begins(stopped)))
        names = joined(", ", map(self._shown, stopped))
        button = Button(words.resume_label(names, tasks), " ".join(("resume", *stopped)))
        return Reply(text, ((button,),))

    def _offered(self, who: PrincipalId) -> Reply:
        """Answer what may have been said to somebody else: nothing, if one has stopped nothing.

        Raises:
            RobotStopped: Offers to resume what one has.
        """
        stops = self._rooms.stops
        seen = sorted(self._rooms.organiser.visible(who))
        theirs = [r for r in seen if stops[r].latched and who in stops[r].stoppers]
        if theirs:
            raise self._rooms.organiser.why_stopped.refusal(who, theirs)
        return Reply("")

    def _named(self, asked: CommandContext) -> tuple[RobotId, ...]:
        """Return the robots that are named; none means all."""
        visible = self._rooms.organiser.visible(asked.caller.principal)
        vocabulary = self._rooms.vocabulary
        named: dict[RobotId, None] = {}
        for word in fold(asked.rest).split():
            if word in words.ALL:
                continue
            profile = vocabulary.robot(word)
            members = vocabulary.members(word) if profile is None else (profile.id,)
            seen = [robot for robot in members if robot in visible]
            if not seen:
                raise NotUnderstood(no_robot_or_group(word))
            named.update(dict.fromkeys(seen))
        return tuple(named)

    def _shown(self, robot: RobotId) -> str:
        return self._rooms.profiles[robot].shown
