"""A robot without a body: it acknowledges and is done. For tests and for measuring ROSIC itself."""

from __future__ import annotations

import asyncio
from collections import deque
from types import coroutine
from typing import TYPE_CHECKING

from rosic.core.order import Ending, Order, Outcome, Report, Rest, Stage, Stop
from rosic.core.robot import Presence, Profile
from rosic.core.saying import said
from rosic.errors import RobotOffline

if TYPE_CHECKING:
    from collections.abc import Generator

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Say, Tell
    from rosic.core.gate import Gate

SENT = Report(Stage.SENT)
RECEIVED = Report(Stage.RECEIVED)
DONE = Outcome(Ending.DONE)
CANCELLED = Outcome(Ending.CANCELLED)


class MemoryRobot:
    """Acts by remembering the order's number, one turn of the event loop after it was told.

    Attributes:
        acted: The newest order numbers that acted, in order, bounded.
        work_s: How long an order takes; 0 takes one turn of the event loop.
        online: False makes it absent.
    """

    def __init__(self, profile: Profile, gate: Gate, clock: Clock) -> None:
        self.profile = profile
        self.gate = gate
        self.acted: deque[int] = deque(maxlen=100_000)
        self.work_s = 0.0
        self.online = True
        self._clock = clock
        self._doing: Order | None = None
        self._end: asyncio.Future[None] | None = None

    async def open(self, say: Say) -> None:
        """Nothing to connect to."""

    async def close(self) -> None:
        """Nothing moves."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Act once. See the contract."""
        if not self.online:
            raise RobotOffline(
                said("{shown} is not there. Nothing was sent.", shown=self.profile.shown)
            )
        self.gate.pass_order(order, self._clock.monotonic_ns())
        tell(SENT)
        self.acted.append(order.n)
        self._doing = order
        tell(RECEIVED)
        try:
            await (self._work() if self.work_s else _one_turn())
        finally:
            self._doing = None
        return DONE if self.gate.still_allows(order) else CANCELLED

    async def _work(self) -> None:
        loop = asyncio.get_running_loop()
        self._end = end = loop.create_future()
        timer = loop.call_later(self.work_s, _finish, end)
        try:
            await end
        finally:
            timer.cancel()

    async def stop(self, stop: Stop) -> Rest:
        """Latch and end what is under way."""
        self.gate.apply_stop(stop)
        if self._end is not None:
            _finish(self._end)
        return Rest(stop.robot, confirmed=True, seconds=0.0)

    async def resume(self, generation: int) -> None:
        """Undo the latch."""
        self.gate.resume(generation)

    def presence(self) -> Presence:
        """Always at hand, unless made absent."""
        doing = self._doing.skill.id if self._doing else ""
        return Presence(online=self.online, age_s=0.0, doing=doing, at_rest=self._doing is None)


@coroutine
def _one_turn() -> Generator[None, None, None]:
    """Let everybody else have a turn, as a sleep of no seconds does, without its calls."""
    yield


def _finish(end: asyncio.Future[None]) -> None:
    if not end.done():
        end.set_result(None)
