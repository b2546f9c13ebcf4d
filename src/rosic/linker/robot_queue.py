"""One robot's orders, one at a time, in order, bounded."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Protocol

from rosic.contracts.robot import LiveRobot
from rosic.core.i18n import said
from rosic.core.order import Order, OrderEnding, OrderStage, Outcome, StageReport
from rosic.core.robot.profile import Busy
from rosic.errors import OrderVoid, RobotBusy

if TYPE_CHECKING:
    from collections.abc import Coroutine, Iterator
    from typing import Any

    from rosic.contracts.clock import Clock
    from rosic.contracts.live_control import LiveControls
    from rosic.contracts.robot import Robot, Tell
    from rosic.core.identity import CommandId, PrincipalId

QUEUED = StageReport(OrderStage.QUEUED)
QUEUE, REFUSE, REPLACE = Busy.QUEUE, Busy.REFUSE, Busy.REPLACE
REPLACED = said("A later command took its place. This was not done.")


class QueuedOrder(Protocol):
    """An order and whoever wants to know what becomes of it."""

    order: Order

    def tell(self, report: StageReport) -> None:
        """Take a step of its life in."""

    def void(self, refusal: OrderVoid) -> None:
        """It is over before it began; it is in no queue any more."""


class RobotQueue:
    """Whose turn it is at one robot.

    Whoever puts an order to a robot that is free serves it: takes one order after another out
    until none waits. A robot that is free costs no switch of tasks, and a queue only one.

    Attributes:
        current: Whose turn it is; None while the robot is free.
        gives_way: Whether a later order takes the place of ``current``.
        replaces: Whether what runs may be replaced by what comes.
        running: Only where it ``replaces``: what may be replaced.
    """

    __slots__ = (
        "_clock",
        "_robot",
        "_waiting",
        "_wakes_ns",
        "_watch",
        "current",
        "gives_way",
        "replaces",
        "running",
    )

    def __init__(self, robot: Robot, clock: Clock) -> None:
        self._robot = robot
        self._clock = clock
        self._waiting: deque[QueuedOrder] = deque()
        self._watch: asyncio.Task[None] | None = None
        self._wakes_ns = 0
        self.replaces = robot.profile.replaces
        self.current: QueuedOrder | None = None
        self.gives_way = False
        self.running: asyncio.Task[Outcome] | None = None

    def __len__(self) -> int:
        return len(self._waiting)

    def put(self, entry: QueuedOrder) -> bool:
        """Take an order in. Return whether it has its turn, and the caller is to serve.

        Raises:
            RobotBusy: The robot is at work and does not queue, or its queue is full; the order
                was not taken in.
        """
        if self.current is None:
            self.current = entry
            return True
        profile = self._robot.profile
        busy = QUEUE if entry.order.sequel else profile.busy
        if entry.order.skill.to_safety:
            busy = REPLACE  # whatever runs: a drone may always land
        if busy is REFUSE:
            self.check_free()
        if busy is REPLACE:  # before it is counted what waits: it takes the place of all of it
            self.void(REPLACED)
            self.replace()
        if len(self._waiting) >= profile.queue_length:
            raise RobotBusy(
                said(
                    "{shown} has {waiting} commands waiting already.",
                    shown=profile.shown,
                    waiting=len(self._waiting),
                )
            )
        self._waiting.append(entry)
        self._watch_until(entry.order.deadline_ns)
        entry.tell(QUEUED)
        return False

    def next(self) -> QueuedOrder | None:
        """End the present turn. Return whose turn it is now; None frees the robot."""
        self.gives_way = False
        self.current = self._waiting.popleft() if self._waiting else None
        return self.current

    def entries(self) -> Iterator[QueuedOrder]:
        """Go through the order under way and those that wait."""
        if self.current is not None:
            yield self.current
        yield from self._waiting

    def check_free(self) -> None:
        """See whether an order would be refused because the robot is at work.

        Raises:
            RobotBusy: It is, and its profile does not queue.
        """
        profile = self._robot.profile
        if self.current is not None and profile.busy is Busy.REFUSE:
            raise RobotBusy(
                said(
                    "{shown} is busy: {spoken}. Ask again when that has ended, or stop it.",
                    shown=profile.shown,
                    spoken=self.current.order.skill.doing,
                )
            )

    def clear(self, generation: int) -> None:
        """Void what waits and was admitted before a stop: it could only be refused at the robot."""
        sentence = said(
            "{shown} was stopped before this could begin.", shown=self._robot.profile.shown
        )
        while self._waiting and self._waiting[0].order.permit.stop_generation < generation:
            self._waiting.popleft().void(OrderVoid(sentence))

    def void(self, sentence: str) -> None:
        """Void everything that waits, with a reason."""
        while self._waiting:
            self._waiting.popleft().void(OrderVoid(sentence))

    def take_out(self, principal: PrincipalId) -> list[QueuedOrder]:
        """Take somebody's orders out that wait; whoever asked for it voids them."""
        taken = [entry for entry in self._waiting if entry.order.permit.principal == principal]
        if taken:
            self._waiting = deque(
                entry for entry in self._waiting if entry.order.permit.principal != principal
            )
        return taken

    def withdraw(self, cid: CommandId, sentence: str) -> None:
        """Void one order that waits, with a reason."""
        for entry in self._waiting:
            if entry.order.cid == cid:
                self._waiting.remove(entry)
                entry.void(OrderVoid(sentence))
                return

    async def relay(
        self, order: Order, tell: Tell, controls: LiveControls | None = None
    ) -> Outcome:
        """Relay an order that gives way to the next; with what steers it, if it is live.

        Raises:
            OrderVoid: A later one has taken its place before it began; it moved nothing.
            OrderVoid, RobotOffline, RobotUnreachable: As `Robot.execute`.
        """
        if self.gives_way:
            raise OrderVoid(REPLACED)
        carried = (
            execute_live(self._robot, order, tell, controls)
            if order.live
            else self._robot.execute(order, tell)
        )
        self.running = task = asyncio.create_task(carried)
        try:
            await asyncio.wait((task,))
        except asyncio.CancelledError:
            self.replace()  # unless it was replaced, and comes to rest already
            await asyncio.wait((task,))
            raise
        self.running = None
        if task.cancelled():
            return Outcome(OrderEnding.CANCELLED, said("a later command took its place"))
        return task.result()

    def replace(self) -> bool:
        """End what is under way, once: a second cancellation would cut its coming to rest short.

        What has its turn and was not relayed yet never is.

        Returns:
            Whether there was anything to end.
        """
        running, self.running = self.running, None
        if running is not None:
            running.cancel()
        elif self.current is None or self.gives_way:
            return False
        self.gives_way = self.current is not None
        return True

    def _watch_until(self, deadline_ns: int) -> None:
        """Have somebody awake when the next waiting order becomes too old."""
        if self._watch is not None:
            if deadline_ns >= self._wakes_ns:
                return
            self._watch.cancel()
        self._wakes_ns = deadline_ns
        self._watch = asyncio.create_task(self._expire())

    async def _expire(self) -> None:
        """Tell waiting orders that they have become too old, when it happens."""
        while self._waiting:
            now_ns, wall_ns = self._clock.monotonic_ns(), self._clock.wall_ns()
            late = [entry for entry in self._waiting if entry.order.is_late(now_ns, wall_ns)]
            for entry in late:
                self._waiting.remove(entry)
                shown = self._robot.profile.shown
                entry.void(
                    OrderVoid(
                        said("{shown} was busy for too long. This was not done.", shown=shown)
                    )
                )
            if not self._waiting:
                break
            self._wakes_ns = min(entry.order.deadline_ns for entry in self._waiting)
            await self._clock.sleep(max(0.01, (self._wakes_ns - now_ns) / 1e9))
        self._watch = None


def execute_live(
    robot: Robot, order: Order, tell: Tell, controls: LiveControls | None
) -> Coroutine[Any, Any, Outcome]:
    """Let a robot carry out a live order; see ``contracts.robot.LiveRobot``.

    Raises:
        OrderVoid: Nobody steers it, or the robot cannot be driven so. It has not moved.
    """
    if controls is None or not isinstance(robot, LiveRobot):
        raise OrderVoid(not_live(robot.profile.shown))
    return robot.execute_live(order, tell, controls)


def not_live(shown: str) -> str:
    """Return that a robot cannot be driven live."""
    return said("{shown} cannot be driven live over its link. Nothing was done.", shown=shown)
