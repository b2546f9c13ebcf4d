"""One robot's orders, one at a time, in order, bounded."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

from rosic.core.order import Order, Report, Stage
from rosic.core.robot import Busy
from rosic.errors import OrderVoid, RobotBusy

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Robot, Tell

QUEUED = Report(Stage.QUEUED)


class Mailbox:
    """Whose turn it is at one robot.

    An order's own task carries it out; the mailbox only says when. A robot that is free costs no
    switch of tasks.
    """

    __slots__ = ("_clock", "_robot", "_waiting", "_watch", "current", "running")

    def __init__(self, robot: Robot, clock: Clock) -> None:
        self._robot = robot
        self._clock = clock
        self._waiting: deque[tuple[Order, asyncio.Future[None]]] = deque()
        self._watch: asyncio.Task[None] | None = None
        self.current: Order | None = None
        self.running: asyncio.Task[object] | None = None

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
            raise RobotBusy(
                f"{profile.shown} is busy: {_spoken(self.current)}. "
                "Ask again when that has ended, or stop it."
            )
        if len(self._waiting) >= profile.queue_length:
            raise RobotBusy(f"{profile.shown} has {len(self._waiting)} commands waiting already.")
        if busy is Busy.REPLACE and self.running is not None:
            self.running.cancel()
        tell(QUEUED)
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.append((order, future))
        if self._watch is None:
            self._watch = asyncio.create_task(self._expire())
        try:
            await future
        except asyncio.CancelledError:
            if future.done() and not future.cancelled() and future.exception() is None:
                self.leave()
            raise

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
        shown = self._robot.profile.shown
        while self._waiting:
            _, future = self._waiting.popleft()
            if not future.done():
                future.set_exception(OrderVoid(f"{shown} was stopped before this could begin."))

    async def _expire(self) -> None:
        """Tell waiting orders that they have become too old, when it happens."""
        shown = self._robot.profile.shown
        while self._waiting:
            now_ns = self._clock.monotonic_ns()
            for order, future in self._waiting:
                if order.deadline_ns < now_ns and not future.done():
                    future.set_exception(
                        OrderVoid(f"{shown} was busy for too long. This was not done.")
                    )
            pending = [order.deadline_ns for order, future in self._waiting if not future.done()]
            if not pending:
                break
            await self._clock.sleep(max(0.01, (min(pending) - now_ns) / 1e9))
        self._watch = None


def _spoken(order: Order) -> str:
    return (order.skill.title or order.skill.id.replace("_", " ")).lower()
