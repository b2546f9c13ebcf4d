"""From a claimed order to an outcome that was told: relay, durable outcome, tell. In that order."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Any, TypeAlias

import msgspec

from rosic.core.deadman import BROKEN_OFF
from rosic.core.i18n import capital, joined, said
from rosic.core.language import inert_text
from rosic.core.order import NEVER_BEGUN, Order, OrderEnding, Outcome, StageReport
from rosic.errors import OrderVoid, Refusal, RobotUnreachable
from rosic.gateway.order_watchers import FOLLOWS_NOT, OrderWatcherRegistry
from rosic.linker.linker import Linker, PolicyMoved

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Coroutine, Iterable

    from rosic.container.container import Containers
    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Tell
    from rosic.core.identity import CommandId, PrincipalId
    from rosic.core.order_status import OrderStatus
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.delivery.sender import ChatSender
    from rosic.gateway.message_context import Requester
    from rosic.gateway.order_status import OrderMessage
    from rosic.gateway.order_watchers import OrderWatcher
    from rosic.linker.robot_queue import QueuedOrder
    from rosic.organiser.organiser import Organiser

AT_MOST = 20_000
NOTE_AT_MOST = 400

REFUSED, UNKNOWN = OrderEnding.REFUSED, OrderEnding.UNKNOWN
AFTER_A_BREAK = said("What came before this was broken off, so this was not done.")
FULL = Outcome(OrderEnding.REFUSED, said("I have too much to do. This was not done."), code="full")
WENT_WRONG = said("Something went wrong here. Please look.")
SHUT_DOWN = said("ROSIC was shut down")
CANCELLED_BEFORE = said("You cancelled this before it could begin. Nothing was done.")

log = logging.getLogger("rosic.pipeline")


Dispatch: TypeAlias = "Callable[[Order, Tell], Coroutine[Any, Any, Outcome]]"
"""RELAYCOMMAND: relays an order whose turn it is; see `Linker.dispatch`."""


class RunningOrder:
    """One order from its claim to its end.

    Attributes:
        requester: Who is behind it: mostly a message.
        shown: How it reads in its message.
        dispatch: Relays it.
        begun: It has been relayed.
    """

    __slots__ = (
        "_executor",
        "begun",
        "dispatch",
        "order",
        "order_message",
        "requester",
        "shown",
    )

    def __init__(
        self,
        order: Order,
        requester: Requester,
        order_message: OrderMessage,
        shown: OrderStatus,
        dispatch: Dispatch,
        executor: OrderExecutor,
    ) -> None:
        self.order = order
        self.dispatch = dispatch
        self.requester = requester
        self.order_message = order_message
        self.begun = False
        self.shown = shown
        self._executor = executor

    def tell(self, report: StageReport) -> None:
        """Take a report in, but none after the end; a robot's words are made inert."""
        if self.shown.result:
            return
        if report.note:
            report = StageReport(report.stage, report.fraction, inert_words(report.note))
        executor, order_message = self._executor, self.order_message
        if executor.watching.observers:
            executor.watching.reported(self.order, report)
        if order_message.step(self.shown, report, executor.wall_ns()):
            executor.chat_sender.update(order_message)

    async def relay(
        self, worker: RobotWorker, watchers: Iterable[OrderWatcher], organiser: Organiser
    ) -> Outcome:
        """RELAYCOMMAND: return what the robot did, whatever happens.

        Args:
            worker: Of its robot, whose task this is.
            watchers: Hear that it begins.
            organiser: Admits it once more where the policy has moved.
        """
        self.begun, order = True, self.order
        for watcher in watchers:
            try:
                watcher.began(order)
            except Exception:
                log.exception(FOLLOWS_NOT)
        try:
            try:
                outcome = await self.dispatch(order, self.tell)
            except PolicyMoved:
                outcome = await self._relay_anew(organiser)
            return inert(outcome) if outcome.note else outcome
        except Refusal as refusal:
            return refused(refusal)
        except asyncio.CancelledError:
            reason, worker.cut_off = worker.cut_off, SHUT_DOWN
            return Outcome(OrderEnding.CANCELLED, reason)
        except RobotUnreachable as fault:
            log.warning("order %d of %s: %s", order.n, order.robot, fault)
            note = said("{fault} Please look.", fault=fault.sentence)
            return Outcome(OrderEnding.UNKNOWN, note, code=fault.code)
        except Exception:
            log.exception("order %d of %s", order.n, order.robot)
            return Outcome(OrderEnding.UNKNOWN, WENT_WRONG, code="fault")

    async def _relay_anew(self, organiser: Organiser) -> Outcome:
        """Admit it once more under the present policy, and relay it; its turn is kept."""
        while True:
            permit = organiser.readmit(
                self.requester.caller, self.order, self.requester.auth_context()
            )
            try:
                renewed = msgspec.structs.replace(self.order, permit=permit)
                return await self.dispatch(renewed, self.tell)
            except PolicyMoved:
                continue

    def void(self, refusal: OrderVoid) -> None:
        """It is over before it began."""
        self._executor.ended(self, refused(refusal))

    def concluded(self) -> None:
        """Its outcome is on disk, or waits to be: from here on a message may show it."""
        self.order_message.end(self.order.cid, self.shown, self.shown.result)
        self._executor.chat_sender.show(self.order_message)
        self._executor.leave(self.order.permit.principal)


class RobotWorker:
    """What serves one robot: a task that relays one order after another, and waits for the next.

    Attributes:
        wake: Set while it waits.
        running: Whose turn it is; begun as soon as it has been relayed. None: nobody's.
        relaying: It waits for the robot.
        cut_off: Why the order at the robot is being cut off, if it is.
        rested: Set when an order that is being cut off has come to rest.
    """

    __slots__ = ("cut_off", "relaying", "rested", "running", "task", "wake")

    def __init__(self, running: RunningOrder) -> None:
        self.running: RunningOrder | None = running
        self.relaying = False
        self.cut_off: str = SHUT_DOWN
        self.rested: asyncio.Event | None = None
        self.task: asyncio.Task[None] | None = None
        self.wake: asyncio.Future[None] | None = None


class OrderExecutor:
    """Every order under way. Each robot has its own task: a long motion blocks nobody else.

    Attributes:
        watching: Who hears what becomes of orders.
    """

    def __init__(
        self,
        organiser: Organiser,
        container: Containers,
        linker: Linker,
        chat_sender: ChatSender,
        clock: Clock,
    ) -> None:
        self.watching = OrderWatcherRegistry()
        self.chat_sender = chat_sender
        self.wall_ns = clock.wall_ns
        self._organiser = organiser
        self._container = container
        self._linker = linker
        self._under_way = 0
        self._whose: dict[PrincipalId, int] = {}
        self._workers: dict[RobotId, RobotWorker] = {}
        self._closing = False
        self._over: asyncio.Event | None = None
        self._newest: dict[RobotId, RunningOrder] | None = None

    def __len__(self) -> int:
        return self._under_way

    def begin(
        self,
        order: Order,
        requester: Requester,
        order_message: OrderMessage,
        shown: OrderStatus,
        dispatch: Dispatch,
    ) -> None:
        """Let a claimed order be relayed as soon as its robot has its turn.

        It will end, and its end will be told.

        Args:
            order: As the container has claimed it.
            requester: Who is behind it.
            order_message: Shows it.
            shown: How it reads there.
            dispatch: Relays it: the linker's.
        """
        self._under_way += 1
        whose = order.permit.principal
        self._whose[whose] = self._whose.get(whose, 0) + 1
        running = RunningOrder(order, requester, order_message, shown, dispatch, self)
        if self.watching.observers:
            self.watching.accepted(order)
        if self._under_way > AT_MOST:
            self.ended(running, FULL)
        elif self._closing:
            running.void(OrderVoid(NEVER_BEGUN))
        elif self._linker.cancels and self._linker.outdated(order):
            running.void(OrderVoid(CANCELLED_BEFORE))
        else:
            try:
                if self._linker.put(running):
                    self._serve_now(running)
            except Refusal as refusal:
                self.ended(running, refused(refusal))

    def forgo(
        self,
        order: Order,
        requester: Requester,
        order_message: OrderMessage,
        shown: OrderStatus,
        why: OrderVoid,
    ) -> None:
        """Let a claimed order end before its robot hears of it: nobody wants it any more."""
        self._under_way += 1
        whose = order.permit.principal
        self._whose[whose] = self._whose.get(whose, 0) + 1
        dispatch = self._linker.dispatch
        if self.watching.observers:
            self.watching.accepted(order)
        RunningOrder(order, requester, order_message, shown, dispatch, self).void(why)

    def _serve_now(self, running: RunningOrder) -> None:
        worker = self._workers.get(running.order.robot)
        if worker is None:
            worker = self._workers[running.order.robot] = RobotWorker(running)
            worker.task = asyncio.create_task(self._serve(worker, running.order.robot))
            return
        worker.running = running
        if worker.wake is not None:
            worker.wake.set_result(None)

    async def _serve(self, worker: RobotWorker, robot: RobotId) -> None:
        """Relay one order after another; a robot that is free costs nothing but this task."""
        loop, linker = asyncio.get_running_loop(), self._linker
        while (running := worker.running) is not None:
            if self._closing:
                running.void(OrderVoid(NEVER_BEGUN))
                return
            if self._newest is not None:
                self._newest[robot] = running
            worker.relaying = True
            outcome = await running.relay(worker, self.watching.watchers, self._organiser)
            worker.relaying = False
            if worker.rested is not None:
                worker.rested.set()
                worker.rested = None
            self.ended(running, outcome)
            if outcome.ending is REFUSED:
                await asyncio.sleep(0)  # a row of refusals, after a stop, holds nobody else up
            waiting = linker.next(robot)
            if waiting is None:
                worker.running = running = None  # what is over is not kept until the next begins
                worker.wake = loop.create_future()
                await worker.wake
                worker.wake = None
            else:
                assert isinstance(waiting, RunningOrder)  # noqa: S101 - nothing else is put there
                worker.running = waiting
                del waiting

    def ended(self, running: RunningOrder, outcome: Outcome) -> None:
        """Write down how an order ended; once that is on disk it is told."""
        self._organiser.settle(running.order.permit)
        self.watching.ended(running.order, outcome, begun=running.begun)
        if outcome.ending is OrderEnding.CANCELLED:
            who = self._organiser.why_stopped.by_another(running.order)
            note = joined("; ", filter(None, (outcome.note, who)))
            outcome = msgspec.structs.replace(outcome, note=note)
        if self.watching.observers:
            self.watching.concluded(running.order, outcome)
        at_ns = self.wall_ns()
        words = running.shown.wording(outcome, at_ns)
        self._container.conclude(running.order, outcome, words, at_ns, running.concluded)
        if outcome.ending is UNKNOWN or outcome.code in BROKEN_OFF:
            self._linker.void(running.order.robot, AFTER_A_BREAK)  # nothing goes on by itself (I6)

    def shown_in(
        self, where: tuple[str, str], message: str, principal: PrincipalId = ""
    ) -> tuple[RobotId, ...]:
        """Return the robots whose orders, under way or waiting, one message of a chat shows.

        With a principal: of the orders that are theirs.
        """
        return tuple(
            robot
            for robot in self._workers
            for entry in self._linker.entries(robot)
            if isinstance(entry, RunningOrder)
            and entry.order_message.message == message
            and entry.order_message.where == where
            and principal in {"", entry.order.permit.principal}
        )

    def of(self, principal: PrincipalId, where: tuple[str, str] | None = None) -> list[Order]:
        """Return somebody's orders that robots carry out now; of a chat, those that it shows."""
        if principal not in self._whose:
            return []
        under_way = (self._linker.queues[robot].current for robot in self._workers)
        return [
            entry.order
            for entry in under_way
            if entry is not None and entry.order.permit.principal == principal
            if where is None
            or (isinstance(entry, RunningOrder) and entry.order_message.where == where)
        ]

    def take_out(self, principal: PrincipalId, robots: Collection[RobotId]) -> list[QueuedOrder]:
        """Take somebody's orders out that wait for robots, or for any if none is named."""
        if principal not in self._whose:
            return []
        some = [robot for robot in self._workers if not robots or robot in robots]
        return [entry for robot in some for entry in self._linker.take_out(robot, principal)]

    def follow(self) -> dict[RobotId, RunningOrder]:
        """Keep the order that each robot had last, from now on; return where it is found."""
        if self._newest is None:
            self._newest = {
                robot: worker.running
                for robot, worker in self._workers.items()
                if worker.relaying and worker.running is not None
            }
        return self._newest

    def leave_off(self) -> None:
        """Keep none any more."""
        self._newest = None

    async def cut(self, robot: RobotId, reason: str) -> None:
        """End what a robot does for its holder, and what waits; on return it has come to rest.

        Unlike a stop it latches nothing: whoever has the robot next goes on from there.
        """
        self._linker.void(robot, not_done(reason))
        await self._cut_off(robot, reason)

    async def cut_order(self, robot: RobotId, cid: CommandId, reason: str) -> None:
        """End one order, whether it waits or is under way; on return the robot has come to rest.

        What else the robot does, or is to do, goes on.
        """
        self._linker.withdraw(robot, cid, not_done(reason))
        current = self._linker.current(robot)
        if current is not None and current.cid == cid:
            await self._cut_off(robot, reason, cid)

    async def _cut_off(self, robot: RobotId, reason: str, cid: CommandId = b"") -> None:
        """Cut off what a robot does now: whatever it is, or nothing but one order."""
        worker = self._workers.get(robot)
        if worker is None or worker.task is None:
            return
        while not (worker.relaying or self._idle(worker) or worker.task.done()):  # noqa: ASYNC110
            await asyncio.sleep(0)  # its turn has come: it is relayed in a moment
        if not worker.relaying:
            return
        current = self._linker.current(robot)
        if cid and (current is None or current.cid != cid):
            return  # it ended meanwhile, and what runs now is another
        if worker.rested is not None:  # somebody cuts it off already: once is enough
            await worker.rested.wait()
            return
        worker.cut_off = reason
        worker.rested = rested = asyncio.Event()
        worker.task.cancel()
        await rested.wait()

    def busy(self, principal: PrincipalId) -> bool:
        """Whether an order of theirs has not ended yet, or its end is not written down."""
        return principal in self._whose

    def leave(self, principal: PrincipalId) -> None:
        """One life of theirs is over."""
        self._under_way -= 1
        left = self._whose.pop(principal) - 1
        if left:
            self._whose[principal] = left
        if self._over is not None and not self._under_way:
            self._over.set()

    async def close(self) -> None:
        """Cancel what is under way: robots come to rest, the outcomes are written and told."""
        self._closing = True
        self._over = asyncio.Event()
        self._linker.clear(NEVER_BEGUN)
        for worker in self._workers.values():
            # Cut off before its first step it would never take one.
            begun = worker.running.begun if worker.running is not None else self._idle(worker)
            if worker.task is not None and begun:
                worker.task.cancel()
        if self._under_way:
            await self._over.wait()

    @staticmethod
    def _idle(worker: RobotWorker) -> bool:
        return worker.wake is not None and not worker.wake.done()


def not_done(reason: str) -> str:
    """Return that an order came to nothing, and why."""
    return said("{reason}. This was not done.", reason=capital(reason))


def refused(refusal: Refusal) -> Outcome:
    """Return the outcome of an order that came to nothing."""
    return Outcome(OrderEnding.REFUSED, refusal.sentence, code=refusal.code)


def inert(outcome: Outcome) -> Outcome:
    """Return the outcome with a robot's words stripped of what could act on a reader."""
    return msgspec.structs.replace(outcome, note=inert_words(outcome.note))


def inert_words(text: str) -> str:
    """Return words without what could act on a reader; harmless ones keep their languages."""
    plain = inert_text(text)[:NOTE_AT_MOST]
    return text if plain == text else plain
