"""One robot's orders, one at a time, in order, bounded."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

from rosic.core.order import Order, Outcome, Report, Stage
from rosic.core.robot import Busy
from rosic.errors import OrderVoid, RobotBusy

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Robot, Tell

QUEUED = Report(Stage.QUEUED)
REPLACED = "A later command took its place. This was not done."


class Mailbox:
    """Whose turn it is at one robot.

    An order's own task carries it out; the mailbox only says when. A robot that is free costs no
    switch of tasks.

    Attributes:
        current: Whose turn it is.
        running, replaced: Only with ``busy: replace``: what may be replaced, and what was.
    """

    __slots__ = (
        "_clock", "_robot", "_waiting", "_wakes_ns", "_watch", "current", "replaced", "running",
    )  # fmt: skip

    def __init__(self, robot: Robot, clock: Clock) -> None:
        self._robot = robot
        self._clock = clock
        self._waiting: deque[tuple[Order, asyncio.Future[None]]] = deque()
        self._watch: asyncio.Task[None] | None = None
        self.current: Order | None = None
        self.running: asyncio.Task[Outcome] | None = None
        self.replaced: asyncio.Task[Outcome] | None = None
        self._wakes_ns = 0

    def __len__(self) -> int:
        return len(self._waiting)

    def try_turn(self, order: Order) -> bool:
        """Take the turn if the robot is free."""
        if self.current is not None:
            return False
        self.current = order
        return True

    async def turn(self, order: Order, tell: Tell) -> None:
        """Wait for this order's turn. Whoever got it must call ``leave``.

        Raises:
            RobotBusy: The robot is at work and does not queue, or its queue is full.
            OrderVoid: The order became too old, or the robot was stopped, while waiting.
        """
        if self.current is None:
            self.current = order
            return
        profile = self._robot.profile
        busy = Busy.QUEUE if order.sequel else profile.busy
        if busy is Busy.REFUSE:
            self.check_free()
        if len(self._waiting) >= profile.queue_length:
            raise RobotBusy(f"{profile.shown} has {len(self._waiting)} commands waiting already.")
        if busy is Busy.REPLACE:
            self._void(REPLACED)
            self._replace()
        tell(QUEUED)
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.append((order, future))
        self._watch_until(order.deadline_ns)
        try:
            await future
        except asyncio.CancelledError:
            if future.done() and not future.cancelled() and future.exception() is None:
                self.leave()
            raise

    def check_free(self) -> None:
        """See whether an order would be refused because the robot is at work.

        Raises:
            RobotBusy: It is, and its profile does not queue.
        """
        profile = self._robot.profile
        if self.current is not None and profile.busy is Busy.REFUSE:
            raise RobotBusy(
                f"{profile.shown} is busy: {_spoken(self.current)}. "
                "Ask again when that has ended, or stop it."
            )

    def leave(self) -> None:
        """Give the turn to the next one waiting."""
        self.current = None
        while self._waiting:
            order, future = self._waiting.popleft()
            if not future.done():
                self.current = order
                future.set_result(None)
                return

    def clear(self) -> None:
        """Void everything that waits: the robot was stopped."""
        self._void(f"{self._robot.profile.shown} was stopped before this could begin.")

    def _void(self, sentence: str) -> None:
        while self._waiting:
            _, future = self._waiting.popleft()
            if not future.done():
                future.set_exception(OrderVoid(sentence))

    def _replace(self) -> None:
        """End what is under way, once: a second cancellation would cut its coming to rest short."""
        if self.running is not None:
            self.replaced = self.running
            self.running = None
            self.replaced.cancel()

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
            now_ns = self._clock.monotonic_ns()
            late = [entry for entry in self._waiting if entry[0].deadline_ns < now_ns]
            for entry in late:
                self._waiting.remove(entry)
                if not entry[1].done():
                    shown = self._robot.profile.shown
                    entry[1].set_exception(
                        OrderVoid(f"{shown} was busy for too long. This was not done.")
                    )
            if not self._waiting:
                break
            self._wakes_ns = min(order.deadline_ns for order, _ in self._waiting)
            await self._clock.sleep(max(0.01, (self._wakes_ns - now_ns) / 1e9))
        self._watch = None


def _spoken(order: Order) -> str:
    return (order.skill.title or order.skill.id.replace("_", " ")).lower()
