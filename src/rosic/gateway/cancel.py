"""Cancel: somebody ends what they have under way themselves, and the robots are free at once.

It overtakes like a stop and needs no disk. It latches nothing, and ends nobody else's orders; a
robot that does not come to rest by it is stopped, and that is latched.
"""

from __future__ import annotations

import asyncio
import logging
from collections import Counter
from collections.abc import Awaitable, Callable, Collection, Iterable
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

from msgspec.structs import replace

from rosic.core.i18n import joined, said
from rosic.core.identity import PrincipalId
from rosic.core.language import CommandLine, hears_cancel, leaves_out
from rosic.core.message import Button, ChatKind
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import MINUTE_NS
from rosic.errors import OrderVoid, Refusal
from rosic.gateway import cancel_messages as words
from rosic.gateway.commands import Reply
from rosic.gateway.order_execution import CANCELLED_BEFORE
from rosic.gateway.replies import CONFIRMED
from rosic.gateway.rest_wait import comes_to_rest

if TYPE_CHECKING:
    from collections.abc import Coroutine

    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Caller
    from rosic.core.message import Chat, Inbound
    from rosic.core.order import Order
    from rosic.core.stop_registry import StopRegistry
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.gateway.replies import Replies
    from rosic.gateway.stop import StopLane
    from rosic.linker.robot_queue import QueuedOrder

# A message that was received before a cancel and is read after it comes soon or never.
OUTDATED_NS = MINUTE_NS
ANSWERS_AT_MOST = 8
VOIDED_AT_ONCE = 50
# What an adapter may take beyond its profile's own time-out before the robot is stopped instead.
CUT_OFF_WITHIN_S = 1.0
ALSO_WITHIN_S = 3.0
OTHERS_SHOWN = 3

BOOKING: Final = "booking"
"""The verb of what ``/cancel booking`` asks for; nobody types it alone."""

Also: TypeAlias = Callable[[PrincipalId, Collection[RobotId]], Awaitable[str]]
"""Ends what else somebody has under way, with some robots or with all if none is named. Returns
what to say of it, "" if there was nothing. Begins at once: whatever it does before it waits for
anything is done before any robot is cut off."""

log = logging.getLogger("rosic.stop")


class CancelledRobot(NamedTuple):
    """What became of one robot whose order was cut off.

    Attributes:
        at_rest: None: its side does not say. False: it was stopped.
    """

    robot: RobotId
    at_rest: bool | None
    seconds: float


class CancelGeneration:
    """How often somebody had cancelled when they asked for something: a later cancel is for it too.

    To be made before anything is waited for, and asked once nothing more is. What is admitted
    carries this in its permit (`Permit.cancels`); this is for the time before that.
    """

    def __init__(
        self, stops: StopRegistry, principal: PrincipalId, robots: Iterable[RobotId]
    ) -> None:
        self._stops = stops
        self._principal = principal
        self._cancels = {robot: stops.cancelled(principal, robot) for robot in robots}

    def check(self, robots: Collection[RobotId]) -> None:
        """See that one of some robots at least is not among those of a cancel since then.

        Raises:
            OrderVoid: All of them are: nothing of it is done.
        """
        cancelled, who = self._stops.cancelled, self._principal
        if all(self._cancels.get(robot, 0) < cancelled(who, robot) for robot in robots):
            raise OrderVoid(CANCELLED_BEFORE)


class CancelLane:
    """Ends what somebody has under way.

    Attributes:
        last: When somebody did so last: by the wall clock of the message, and by the monotonic one.
    """

    def __init__(
        self,
        rooms: Components,
        executor: OrderExecutor,
        stop_lane: StopLane,
        replies: Replies,
        commands: CommandRegistry,
        clock: Clock,
    ) -> None:
        self._rooms = rooms
        self._executor = executor
        self._stop_lane = stop_lane
        self._replies = replies
        self._clock = clock
        self._commands = commands
        commands.register("cancel", self.handler)
        commands.register("abort", self.handler)
        self._also: list[Also] = []
        self.last: dict[PrincipalId, tuple[int, int]] = {}
        self._tasks: set[asyncio.Task[Any]] = set()
        self._answering: Counter[tuple[str, str]] = Counter()

    def also(self, end: Also) -> None:
        """End this too, whenever somebody ends what they have under way."""
        self._also.append(end)

    @property
    def quiet(self) -> bool:
        """Whether everything that was cancelled has come to rest, and was answered."""
        return not self._tasks

    async def cancel(self, messenger: Messenger, inbound: Inbound, names: tuple[str, ...]) -> bool:
        """End now what the author has under way; tell once the robots are at rest.

        On return nothing of theirs begins any more that was received before, what waited is taken
        out, and every adapter is being told to end what it does for them.

        Returns:
            False for somebody unknown, of whom nothing is under way.
        """
        authoriser = self._rooms.authoriser
        found = authoriser.directory.at(inbound.sender)
        if found is None or not authoriser.has_access(found[0].id):
            return False  # whoever has no access is answered as always, and counted once
        caller = authoriser.identify(inbound)
        if inbound.tap:
            self._spawn(messenger.answer_tap(inbound, ""))
        who = caller.principal
        robots = self._named(names, who)
        self.last[who] = (inbound.received_ns, self._clock.monotonic_ns())
        self._rooms.stops.cancel(who, robots)
        waited = self._executor.take_out(who, robots)
        ending = self._end(caller, inbound, robots, waited)
        where = (messenger.name, inbound.chat.id)
        answers = self._answering[where] < ANSWERS_AT_MOST and self._charged(caller)
        self._answering[where] += answers
        self._spawn(self._answer(messenger, inbound, caller, ending, answers=answers))
        await asyncio.sleep(0)
        return True

    def check(self, caller: Caller, inbound: Inbound) -> None:
        """See that a message was not received before its author ended what they had under way.

        Raises:
            OrderVoid: It was: nothing of it is done.
        """
        received_ns, at_ns = self.last.get(caller.principal, (-1, 0))
        recent = self._clock.monotonic_ns() - at_ns < OUTDATED_NS
        if recent and inbound.received_ns <= received_ns:
            raise OrderVoid(CANCELLED_BEFORE)

    def _named(self, names: tuple[str, ...], who: PrincipalId) -> tuple[RobotId, ...]:
        """Return the robots that were named; none, which means all, if a word means nobody."""
        if not names:
            return ()
        robots, unknown = self._rooms.vocabulary.to_stop(names, self._rooms.organiser.visible(who))
        return () if unknown else robots

    def _charged(self, caller: Caller) -> bool:
        try:
            self._rooms.organiser.charge(caller)
        except Refusal:
            return False  # it is done all the same; only the answer is saved
        return True

    def _end(
        self,
        caller: Caller,
        inbound: Inbound,
        robots: tuple[RobotId, ...],
        waited: list[QueuedOrder],
    ) -> Coroutine[Any, Any, Reply]:
        """Begin to end everything; the answer is awaited."""
        who = caller.principal
        # What asks whether something is meant; it is asked anew when it is said anew.
        self._rooms.authoriser.buttons.void(who, CONFIRMED)
        also = [self._begin(end(who, robots)) for end in self._also]
        orders = [o for o in self._executor.of(who) if not robots or o.robot in robots]
        reason = said("as {name} asked", name=caller.name)
        resting = [self._begin(self._cut_off(order, reason)) for order in orders]
        return self._ended(caller, inbound, robots, (waited, resting, also))

    async def _ended(
        self,
        caller: Caller,
        inbound: Inbound,
        robots: tuple[RobotId, ...],
        found: tuple[
            list[QueuedOrder], list[asyncio.Task[CancelledRobot]], list[asyncio.Task[str]]
        ],
    ) -> Reply:
        waited, resting, also = found
        for number, entry in enumerate(waited):
            entry.void(OrderVoid(CANCELLED_BEFORE))
            if number % VOIDED_AT_ONCE == VOIDED_AT_ONCE - 1:
                await asyncio.sleep(0)
        rested = [await one for one in resting]
        rests = [words.rested(self._shown(one.robot), one.at_rest, one.seconds) for one in rested]
        others = await self._in_time(also)
        if not (rests or waited or others):
            return self._nothing(caller, robots)
        parts = [words.CANCELLED, *rests, words.waited(len(waited)), *others]
        if not robots and leaves_out(inbound.text):
            parts.append(words.NOBODY_LEFT_OUT)
        if "\n" in inbound.text.strip():
            parts.append(words.NOTHING_ELSE)
        return Reply(joined(" ", filter(None, parts)), anew=True)

    async def _in_time(self, also: list[asyncio.Task[str]]) -> list[str]:
        """Return what else was ended; a disk that hangs does not keep the answer back."""
        if not also:
            return []
        too_long = self._begin(self._clock.sleep(ALSO_WITHIN_S))
        ending = asyncio.ensure_future(asyncio.wait(also))
        await asyncio.wait((ending, too_long), return_when=asyncio.FIRST_COMPLETED)
        too_long.cancel()
        ending.cancel()
        return [text for one in also if one.done() and (text := _ended_by(one))]

    async def _cut_off(self, order: Order, reason: str) -> CancelledRobot:
        """End one order, and see its robot at rest; or stop it, if that is not seen in time."""
        robot, linker, clock = order.robot, self._rooms.linker, self._clock
        begun_ns = clock.monotonic_ns()
        at_most_s = linker.profile(robot).rest_timeout_s + CUT_OFF_WITHIN_S
        cutting = self._begin(self._executor.cut_order(robot, order.cid, reason))
        too_long = self._begin(clock.sleep(at_most_s))
        await asyncio.wait((cutting, too_long), return_when=asyncio.FIRST_COMPLETED)
        too_long.cancel()
        there = linker.presence(robot).online is not False
        rests = cutting.done() and there and await comes_to_rest(linker, clock, robot)
        seconds = (clock.monotonic_ns() - begun_ns) / 1e9
        if not rests:
            self._stop_lane.stop_robots((robot,), order.permit.principal, (robot,))
            return CancelledRobot(robot, at_rest=False, seconds=seconds)
        return CancelledRobot(robot, at_rest=linker.presence(robot).at_rest, seconds=seconds)

    def _nothing(self, caller: Caller, robots: tuple[RobotId, ...]) -> Reply:
        """Say that nothing of theirs is under way, and what else they may have meant."""
        rooms, who = self._rooms, caller.principal
        seen = rooms.organiser.visible(who)
        others = {
            robot: order
            for robot in sorted(seen if not robots else seen.intersection(robots))
            if (order := rooms.linker.current(robot)) is not None
        }
        lines: list[str] = [words.NOTHING]
        buttons: list[Button] = []
        for robot, order in tuple(others.items())[:OTHERS_SHOWN]:
            name = rooms.organiser.name_of(order.permit.principal)
            lines.append(words.at_work_for(self._shown(robot), name))
            buttons.append(Button(words.stop_label(self._shown(robot)), f"stop {robot}"))
        now_ns = rooms.organiser.wall_ns()
        if any(slot.end_ns > now_ns for slot in rooms.organiser.calendar.of(who)):
            buttons.append(Button(words.CANCEL_A_BOOKING, "/cancel booking"))
        rows = tuple((button,) for button in buttons)
        return Reply(joined("\n", lines), rows, anew=True)

    def goes_on(self, messenger: Messenger, chat: Chat, principal: PrincipalId) -> Reply | None:
        """Return what robots do for somebody just now, with what ends it; None: nothing.

        Where others read it, only what that chat shows anyway.
        """
        private = chat.kind is ChatKind.PRIVATE
        where = None if private else (messenger.name, chat.id)
        orders = self._executor.of(principal, where)[:OTHERS_SHOWN]
        if not orders:
            return None
        shown = {order.robot: self._shown(order.robot) for order in orders}
        what = (joined(": ", (shown[order.robot], order.words)) for order in orders)
        rows = tuple(
            (
                Button(words.stop_label(name), f"stop {robot}"),
                Button(words.cancel_label(name), f"cancel {robot}"),
            )
            for robot, name in shown.items()
        )
        presence = self._rooms.linker.presence
        absent = [words.not_there(shown[r]) for r in shown if presence(r).online is False]
        return Reply(joined(" ", (words.goes_on(what), *absent)), rows, anew=True)

    def _shown(self, robot: RobotId) -> str:
        return self._rooms.profiles[robot].shown

    async def handler(self, asked: CommandContext) -> Reply:
        """Do what is left of ``/cancel``: of a booking, a task or a mission by its name.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        first, _, rest = asked.rest.strip().partition(" ")
        names = hears_cancel(f"cancel {asked.rest}", self._rooms.vocabulary.known)
        if names is not None:  # behind much else, where it was not looked for
            await self.cancel(asked.messenger, asked.inbound, names)
            return Reply("")
        named = self._rooms.vocabulary.commands.find(first.casefold())
        if named is None or not named.cancelled_by:
            return await self._commands.do(CommandLine(BOOKING, asked.rest), asked)
        rest = f"cancel {rest.strip()}"
        line = CommandLine(named.cancelled_by, rest)
        return await self._commands.do(line, replace(asked, rest=rest))

    async def _answer(
        self,
        messenger: Messenger,
        inbound: Inbound,
        caller: Caller,
        ending: Coroutine[Any, Any, Reply],
        *,
        answers: bool,
    ) -> None:
        where = (messenger.name, inbound.chat.id)
        try:
            reply = await ending
            if answers:
                self._replies.hand_over(messenger, inbound, caller, reply)
        except Exception:
            log.exception("a cancel could not be answered")
        finally:
            self._answering[where] -= answers
            if not self._answering[where]:
                del self._answering[where]

    def _begin(self, work: Awaitable[Any]) -> asyncio.Task[Any]:
        task: asyncio.Task[Any] = asyncio.ensure_future(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def _spawn(self, work: Coroutine[Any, Any, None]) -> None:
        self._begin(work)

    async def close(self) -> None:
        """Wait for answers under way, briefly; robots come to rest with their orders."""
        if self._tasks:
            await asyncio.wait(tuple(self._tasks), timeout=2.0)


def _ended_by(also: asyncio.Task[str]) -> str:
    """Return what one of them says, or that it did not succeed: the others' words stay."""
    try:
        return also.result()
    except Refusal as why:
        return why.sentence
    except (Exception, asyncio.CancelledError):
        log.exception("something could not be cancelled")
        return words.NOT_ALL
