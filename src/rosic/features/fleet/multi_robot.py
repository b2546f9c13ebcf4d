"""``/together`` and ``/broadcast``: one command to many robots, all of them or as many as can.

Together: if one is not ready, none begins; all begin at one moment. Broadcast: each is asked for
itself, and one message shows of each whether it has received it, and what it does.
"""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.container.records import ReplyTo
from rosic.core.i18n import in_language, joined
from rosic.core.identity import robot_command_id
from rosic.core.language import Do
from rosic.core.language.suggestions import AND, listed
from rosic.core.messages import no_robot_or_group
from rosic.core.order import NEVER_BEGUN, OrderEnding
from rosic.core.order_status import ENGLISH, wording_in
from rosic.core.policy.roles import StepRequired
from rosic.core.synchronised_start import begin_together
from rosic.errors import Expired, FirstNeeded, NotUnderstood, Refusal, RobotBusy
from rosic.features.fleet import multi_robot_messages as words
from rosic.features.fleet.alternatives import StepReader, TaskAlternatives, refused
from rosic.features.fleet.messages import wants_a_person
from rosic.features.fleet.monitor import why_not_ready
from rosic.features.fleet.task_parser import check_units, step_for
from rosic.gateway.cancel import CancelGeneration
from rosic.gateway.commands import Reply
from rosic.gateway.message_context import MessageContext
from rosic.gateway.order_execution import SHUT_DOWN
from rosic.gateway.order_status import AwaitedOrder, OrderMessage, stop_button
from rosic.gateway.replies import reply_id
from rosic.gateway.requests import RequestFactory

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.contracts.clock import Clock
    from rosic.core.order import Order, Outcome, Permit, Request
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument
    from rosic.features.fleet.dispatcher import TaskDispatcher
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.hooks import PipelineHooks
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.gateway.order_services import OrderServices

AT_THE_END: Final = frozenset({SHUT_DOWN, NEVER_BEGUN})
ACTED: Final = frozenset({OrderEnding.DONE, OrderEnding.SENT})


class AllOrNothingStart:
    """The orders of one common start, of all or of none, until they have ended.

    That all are ready is seen before any is asked. One may still turn its order down, hear of it
    too late, or be stopped before the moment has come: then the others are ended like any order
    that is cut off. Whoever waits for the moment never moves; whoever has begun comes to rest.
    """

    def __init__(
        self, rooms: Components, executor: OrderExecutor, clock: Clock, orders: Sequence[Order]
    ) -> None:
        self._rooms = rooms
        self._executor = executor
        self._clock = clock
        self._open: dict[RobotId, Order] = {order.robot: order for order in orders}
        self._cutting: list[asyncio.Task[None]] = []

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Hear how one has ended, once that is on disk."""
        del self._open[order.robot]
        if not self._cutting and self._never_began(order, outcome):
            reason = words.did_not_begin(self._rooms.profiles[order.robot].shown)
            self._cutting = [
                asyncio.create_task(self._executor.cut_order(robot, other.cid, reason))
                for robot, other in self._open.items()
                if not self._rooms.stops[robot].latched  # a stop sees to it, and says so better
            ]

    def _never_began(self, order: Order, outcome: Outcome) -> bool:
        """Tell whether it has not moved; once it has, how it ends is its own affair."""
        if outcome.note in AT_THE_END:
            return False  # ROSIC ends them all, and each says so itself
        if outcome.ending is OrderEnding.REFUSED:
            return True
        early = self._clock.monotonic_ns() < (order.start_ns or 0)
        return early and outcome.ending not in ACTED


ROBOTS_AT_MOST: Final = 200
JOINED: Final = "+"


class ResolvedRobots(NamedTuple):
    """Whom a command means, and what.

    Attributes:
        again: All of it as it would be typed; the line alone would be for the chosen robot.
    """

    name: str
    robots: tuple[RobotId, ...]
    line: str
    again: str

    def typed(self, lines: Sequence[str]) -> str:
        """Return the whole command with another line."""
        verb, _, _ = self.again.partition(" ")
        return " ".join((verb, self.name, *lines))


class MultiRobotCommands:
    """The handler of commands to many."""

    def __init__(
        self,
        rooms: Components,
        dispatching: TaskDispatcher,
        hands: OrderServices,
        clock: Clock,
        hooks: PipelineHooks,
    ) -> None:
        self._rooms = rooms
        self._dispatching = dispatching
        self._hands = hands
        self._clock = clock
        self._hooks = hooks
        self._requesting = RequestFactory(rooms, clock)

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        commands.register("together", self.together)
        commands.register("broadcast", self.broadcast)

    # ---- all or none ----

    async def together(self, asked: CommandContext) -> Reply:
        """Let all robots of a group begin at one moment, or none.

        Raises:
            NotUnderstood: No such group, or nothing that all of them can do.
            Refusal: Why one of them may not; none has moved.
        """
        meant = self._meant(asked, "together")
        before = self._cancel_generation(asked, meant)
        steps = [await self._step(meant, robot) for robot in meant.robots]
        self._check_units(asked, meant, meant.robots[0])
        states = {robot: self.why_not_ready(asked, robot) for robot in meant.robots}
        if any(states.values()):
            return self._none(meant, states)
        message = self._said(asked)
        for robot in meant.robots:
            before.check((robot,))
        requests = self._requests(message, asked, meant, steps)
        permits = self._admitted(asked, message, requests)
        orders = await self._prepare(asked, meant, permits, requests)
        orders = begin_together(orders, self._clock.monotonic_ns())
        start = AllOrNothingStart(self._rooms, self._hands.executor, self._clock, orders)
        self._begin(asked, message, meant, orders, start)
        return Reply("")

    async def _step(self, meant: ResolvedRobots, robot: RobotId) -> Do:
        """Return what one of them is to do; whatever is offered instead is for all of them.

        Others have their turn before each: a stop is not to wait for a line to many.

        Raises:
            Refusal: It cannot do that.
        """
        await asyncio.sleep(0)
        try:
            return step_for(self._rooms, robot, meant.line)
        except Refusal as why:
            instead = TaskAlternatives(StepReader(self._rooms), robot, partial(self._check, robot))
            found = instead.lacking((meant.line,), why)
            raise refused(found, found.why.sentence, meant.typed) from why

    def _check(self, robot: RobotId, lines: Sequence[str]) -> None:
        """See that a robot understands what it is to do; rights are asked for later."""
        for line in lines:
            step_for(self._rooms, robot, line)

    def _ask_units(self, asked: CommandContext, meant: ResolvedRobots) -> None:
        """Ask once for all; what one of them cannot do is said beside what the others do.

        Raises:
            NotUnderstood: A number may be in feet or in metres; both readings are offered.
        """
        try:
            self._check(meant.robots[0], (meant.line,))
        except Refusal:
            return
        self._check_units(asked, meant, meant.robots[0])

    def _check_units(self, asked: CommandContext, meant: ResolvedRobots, robot: RobotId) -> None:
        """Refuse a number without a unit, typed by somebody who reads feet.

        Raises:
            NotUnderstood: There is one; both readings are offered.
        """
        if asked.inbound.nonce is None:
            languages = self._hands.chat_sender.languages
            words_of = languages.of(asked.caller.principal)
            check_units(self._rooms, words_of, robot, (meant.line,), meant.typed)

    def _none(self, meant: ResolvedRobots, states: Mapping[RobotId, str]) -> Reply:
        """Say who is not ready, and offer to begin with the others."""
        lines = [words.state(self._shown(robot), why) for robot, why in states.items()]
        ready = [robot for robot, why in states.items() if not why]
        text = joined("\n", [words.none_begins(meant.name), *lines])
        command = f"/together {JOINED.join(ready)} {meant.line}"
        row = words.begin_with([self._shown(robot) for robot in ready], command)
        return Reply(text, row if ready else ())

    def why_not_ready(self, asked: CommandContext, robot: RobotId) -> str:
        """Return why a robot would not begin at once; empty if it would."""
        fleet = self._dispatching.fleet
        return why_not_ready(self._rooms, fleet, robot, asked.caller.principal)

    # ---- as many as can ----

    async def broadcast(self, asked: CommandContext) -> Reply:
        """Ask every robot of a group for itself; say at once who is not asked, and why.

        Raises:
            NotUnderstood: No such group, or a number that may be in feet or in metres.
        """
        meant, message = self._meant(asked, "broadcast"), self._said(asked)
        before = self._cancel_generation(asked, meant)
        self._ask_units(asked, meant)
        orders: list[Order] = []
        left_out: dict[str, list[RobotId]] = {}
        busy: list[RobotId] = []
        one_busy, late = "", False
        for robot in meant.robots:
            await asyncio.sleep(0)  # a stop is not to wait for a line to many
            try:
                before.check((robot,))
                orders += await self._one(asked, message, meant._replace(robots=(robot,)))
            except RobotBusy as refusal:
                busy.append(robot)
                one_busy = refusal.sentence
            except Refusal as refusal:
                left_out.setdefault(refusal.sentence, []).append(robot)
                late = late or isinstance(refusal, Expired)
        if orders:
            self._begin(asked, message, meant, tuple(orders))
        if not left_out and not busy:
            return Reply("")
        lines = [words.state(self._names(robots), why) for why, robots in left_out.items()]
        if busy:
            lines.append(words.busy(self._names(busy)) if len(busy) > 1 else one_busy)
        text = joined("\n", [words.asked_of(len(orders), len(meant.robots)), *lines])
        if late and not orders:
            raise Expired(text, offers=(meant.again,))
        return Reply(text)

    async def _one(
        self, asked: CommandContext, message: MessageContext, meant: ResolvedRobots
    ) -> tuple[Order, ...]:
        [robot] = meant.robots
        self._rooms.linker.check_free(robot)
        step = step_for(self._rooms, robot, meant.line)
        self._check_units(asked, meant, robot)
        requests = self._requests(message, asked, meant, [step])
        permits = self._admitted(asked, message, requests)
        return await self._prepare(asked, meant, permits, requests)

    # ---- the way of any order ----

    def _meant(self, asked: CommandContext, verb: str) -> ResolvedRobots:
        """Return whom and what.

        Raises:
            NotUnderstood: Nobody whom this person sees, or nothing is said.
        """
        name, _, line = asked.rest.strip().partition(" ")
        visible = self._rooms.organiser.visible(asked.caller.principal)
        vocabulary, robots = self._rooms.vocabulary, dict[str, None]()
        for part in name.casefold().split(JOINED):
            profile = vocabulary.robot(part)
            members = vocabulary.members(part) if profile is None else (profile.id,)
            seen = [robot for robot in members if robot in visible]
            if part and not seen:  # all or none of those who were named: nobody is left out
                raise NotUnderstood(no_robot_or_group(part))
            robots.update(dict.fromkeys(seen))
        if not robots or not line.strip() or len(robots) > ROBOTS_AT_MOST:
            raise NotUnderstood(words.HOW_TO)
        again = f"/{verb} {asked.rest.strip()}"
        return ResolvedRobots(name, tuple(robots), " ".join(line.split()), again)

    def _cancel_generation(self, asked: CommandContext, meant: ResolvedRobots) -> CancelGeneration:
        return CancelGeneration(self._rooms.stops, asked.caller.principal, meant.robots)

    def _said(self, asked: CommandContext) -> MessageContext:
        now_ns = self._clock.monotonic_ns()
        two_factor = self._hooks.stepped_up
        return MessageContext(asked.messenger, asked.inbound, asked.caller, now_ns, two_factor)

    def _requests(
        self,
        message: MessageContext,
        asked: CommandContext,
        meant: ResolvedRobots,
        steps: Sequence[Do],
    ) -> list[Request]:
        """Return what is asked of each; fresh, and each with an identity of its own.

        Raises:
            Expired: With all of it on offer.
        """
        requests: list[Request] = []
        now_ns = self._clock.monotonic_ns()
        for robot, step in zip(meant.robots, steps, strict=True):
            line = Do(
                robots=(robot,),
                skills=step.skills,
                spoken=step.spoken,
                text=meant.line,
                group=meant.name,
            )
            cid = robot_command_id(asked.cid, robot)
            try:
                requests += self._requesting.requests(message, line, cid, now_ns)
            except Expired as late:
                raise Expired(late.sentence, offers=(meant.again,)) from None
        return requests

    def _admitted(
        self, asked: CommandContext, message: MessageContext, requests: Sequence[Request]
    ) -> tuple[Permit, ...]:
        """CHECKPERMISSIONS. Nobody can confirm many at once: that is asked robot by robot.

        Raises:
            Refusal: Why not; nobody has moved.
        """
        admit = self._rooms.organiser.admit
        try:
            return admit(asked.caller, requests, self._arguments_of, message.auth_context)
        except FirstNeeded as first:
            if first.need == StepRequired.STEP_UP.value:
                raise
            [skill] = [one.skill for one in requests if one.robot == first.robot]
            raise wants_a_person(self._shown(first.robot), skill) from None

    def _arguments_of(self, request: Request) -> Mapping[str, Argument]:
        return self._rooms.container.complete(request).arguments

    async def _prepare(
        self,
        asked: CommandContext,
        meant: ResolvedRobots,
        permits: tuple[Permit, ...],
        requests: Sequence[Request],
    ) -> tuple[Order, ...]:
        title = f"{meant.name}: {meant.line}"
        origin = ReplyTo(asked.messenger.name, asked.inbound.chat, reply_id(asked.inbound), title)
        try:
            for request in requests:
                self._rooms.linker.check_free(request.robot)
            return await self._rooms.container.prepare(permits, requests, origin)
        except BaseException:
            self._rooms.organiser.abandon(permits)
            raise

    def _begin(
        self,
        asked: CommandContext,
        message: MessageContext,
        meant: ResolvedRobots,
        orders: tuple[Order, ...],
        start: AllOrNothingStart | None = None,
    ) -> None:
        hands, chat = self._hands, asked.inbound.chat
        catalogue = hands.chat_sender.languages.of(asked.caller.principal)
        wording = ENGLISH if catalogue is None else wording_in(catalogue)
        who = asked.caller.principal
        order_message = OrderMessage(
            asked.messenger,
            chat,
            reply_id(asked.inbound),
            who,
            wording,
            about=meant.name,
            buttons=stop_button(meant.name.replace(JOINED, " ")),
            after=hands.ends[meant.name, meant.again, catalogue],
        )
        for order in orders:
            shown = self._shown(order.robot)
            what = in_language(order.words, catalogue)
            at_ns = self._clock.wall_ns()
            status = AwaitedOrder(shown, f"{shown}: {what}", hands.face, at_ns, wording)
            order_message.show(order.cid, status)
            if start is not None:
                status.over = partial(start.ended, order)
            hands.executor.begin(order, message, order_message, status, self._rooms.linker.dispatch)
        hands.chat_sender.show(order_message)

    def _names(self, robots: Sequence[RobotId]) -> str:
        return listed(tuple(map(self._shown, robots)), AND)

    def _shown(self, robot: RobotId) -> str:
        return self._rooms.profiles[robot].shown
