"""A robot without a body: it acknowledges and is done. For tests and for measuring ROSIC itself."""

from __future__ import annotations

import asyncio
from collections import deque
from types import coroutine
from typing import TYPE_CHECKING

from rosic.contracts.live_control import live_outcome, never_steered
from rosic.core.i18n import said
from rosic.core.order import Order, OrderEnding, OrderStage, Outcome, RestReport, StageReport, Stop
from rosic.core.robot.file_transfer import Receipt
from rosic.core.robot.profile import Presence, Profile
from rosic.core.robot.view import View
from rosic.core.sample_gate import LATE_S, LiveEnd
from rosic.core.time_units import SECOND_NS
from rosic.core.traffic import TrafficCount
from rosic.errors import NothingToSee, RobotOffline, RobotUnreachable
from rosic.robots.ros2.profile_rules import STAND_IN

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Generator

    from rosic.contracts.clock import Clock
    from rosic.contracts.live_control import LiveControls
    from rosic.contracts.robot import Say, Speak, Tell
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.file_transfer import FileForRobot
    from rosic.core.robot.skill import Argument
    from rosic.core.robot.view import Content, Pose, ViewKind

SENT = StageReport(OrderStage.SENT)
RECEIVED = StageReport(OrderStage.RECEIVED)
DONE = Outcome(OrderEnding.DONE)
LOOK_EVERY_S = 0.05
CANCELLED = Outcome(OrderEnding.CANCELLED)


class MemoryRobot:
    """Acts by remembering the order's number, one turn of the event loop after it was told.

    Attributes:
        acted: The newest order numbers that acted, in order, bounded.
        work_s: How long an order takes; 0 takes one turn of the event loop.
        online: False makes it absent.
        shows: What it shows to whoever looks.
        looked: How many look now.
        delivered: The files that it was handed.
        receipt: What it says about the next; None makes it say the right thing.
        pose: Where it says that it is.
        values: What it reports.
        age_s: Since it reported.
        speak: Says something to other robots, as its own nodes would.
        heard: What it was told by ROSIC and other robots, newest last, bounded.
        listens: Whether its nodes hear anything.
        steered: The values that it was driven with, newest last, bounded; nothing is zero.
    """

    schema = STAND_IN
    stops_itself = True

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        self.profile = profile
        self.gate = gate
        self.acted: deque[int] = deque(maxlen=1_000)
        self.work_s = 0.0
        self.online = True
        self.shows: dict[ViewKind, Content] = {}
        self.looked = 0
        self.delivered: list[FileForRobot] = []
        self.receipt: Receipt | Exception | None = None
        self.pose: Pose | None = None
        self.values: dict[str, float | str] = {}
        self.age_s: float | None = 0.0
        self.speak: Speak = _to_nobody
        self.heard: deque[bytes] = deque(maxlen=1_000)
        self.listens = True
        self._clock = clock
        self.steered: deque[dict[str, Argument]] = deque(maxlen=1_000)
        self._controls: LiveControls | None = None
        self._doing: Order | None = None
        self._sent = self._received = 0
        self._end: asyncio.Future[Outcome | None] | None = None

    async def open(self, say: Say) -> None:
        """Nothing to connect to."""

    async def close(self) -> None:
        """End what is under way."""
        if self._controls is not None:
            self._controls.close()
        self.finish(CANCELLED)

    @property
    def traffic(self) -> TrafficCount:
        """Return how often it was told something, and has answered."""
        return TrafficCount(self._received, self._sent)

    def remember(self, most: int) -> None:
        """Forget what acted so far, and keep so many order numbers from now on."""
        self.acted = deque(maxlen=most)

    def meet(self, speak: Speak) -> None:
        """Take what it says to other robots by."""
        self.speak = speak

    def hear(self, words: bytes) -> bool:
        """Remember what it was told."""
        if self.listens:
            self.heard.append(words)
        return self.listens

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Act once. See the contract."""
        if not self.online:
            raise RobotOffline(
                said("{shown} is not there. Nothing was sent.", shown=self.profile.shown)
            )
        self.gate.pass_order(order, self._clock.monotonic_ns(), self._clock.wall_ns())
        tell(SENT)
        self._sent += 1
        self.acted.append(order.n)
        self._doing = order
        tell(RECEIVED)
        self._received += 1
        try:
            ended = await (self._work() if self.work_s else _one_turn())
        finally:
            self._doing = None
        return ended or (DONE if self.gate.still_allows(order) else CANCELLED)

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Remember the values of each sample that steers it. See the contract."""
        if not self.online:
            raise RobotOffline(
                said("{shown} is not there. Nothing was sent.", shown=self.profile.shown)
            )
        self._controls = controls
        begun_ns = self._clock.monotonic_ns()
        try:
            end = await controls.begin(self.profile.watchdog_s or LATE_S)
            if end is not None:
                return never_steered(end)
            self.gate.pass_order(order, self._clock.monotonic_ns(), self._clock.wall_ns())
            tell(SENT)
            self._sent += 1
            self.acted.append(order.n)
            self._doing, begun_ns = order, self._clock.monotonic_ns()
            tell(RECEIVED)
            self._received += 1
            end = await self._steer(order, controls)
        finally:
            if self._doing is not None:
                self.steered.append({})
            self._doing = self._controls = None
            controls.leave()
        if not self.gate.still_allows(order):
            return CANCELLED
        seconds = (self._clock.monotonic_ns() - begun_ns) / SECOND_NS
        return live_outcome(end, seconds, controls.gate.most_s)

    async def _steer(self, order: Order, controls: LiveControls) -> LiveEnd:
        """Follow the samples until there are none."""
        while self.gate.still_allows(order) and (end := controls.look()) is None:
            if not self.online:
                raise RobotUnreachable(
                    said("{shown} cannot be reached any more.", shown=self.profile.shown)
                )
            if not self.steered or self.steered[-1] != controls.values:
                self.steered.append({**controls.values})
                self._sent += 1
            await controls.changed(controls.left_s())
        return end or LiveEnd.CLOSED

    async def _work(self) -> Outcome | None:
        loop = asyncio.get_running_loop()
        self._end = end = loop.create_future()
        timer = loop.call_later(self.work_s, _finish, end)
        try:
            ended: Outcome | None = await end
        finally:
            timer.cancel()
        return ended

    def finish(self, ended: Outcome | None = None) -> None:
        """Let the order under way end as if its time were over, or as it is said."""
        if self._end is not None:
            _finish(self._end, ended)

    def lose(self) -> None:
        """Make it absent in the midst of what it does."""
        self.online = False
        if self._end is not None and not self._end.done():
            self._end.set_exception(
                RobotUnreachable(
                    said("{shown} cannot be reached any more.", shown=self.profile.shown)
                )
            )

    async def stop(self, stop: Stop) -> RestReport:
        """Latch and end what is under way."""
        self.gate.apply_stop(stop)
        self._sent += 1
        if self._controls is not None:
            self._controls.close()
        self.finish()
        return RestReport(stop.robot, confirmed=True, seconds=0.0)

    async def resume(self, generation: int) -> None:
        """Undo the latch."""
        self.gate.resume(generation)

    def presence(self) -> Presence:
        """Always at hand, unless made absent."""
        doing = self._doing.skill.id if self._doing else ""
        return Presence(
            online=self.online,
            age_s=self.age_s,
            doing=doing,
            at_rest=self._doing is None if self.online else None,
            values=self.values,
            ages_s=dict.fromkeys(self.values, self.age_s) if self.age_s is not None else {},
            pose=self.pose,
        )

    async def deliver(self, robot_file: FileForRobot) -> Receipt:
        """Keep a file, and say its checksum or what was given to be said."""
        if not self.online:
            raise RobotOffline(
                said("{shown} is not there. Nothing was sent.", shown=self.profile.shown)
            )
        self.delivered.append(robot_file)
        if isinstance(self.receipt, Exception):
            raise self.receipt
        return self.receipt or Receipt(received=True, digest=robot_file.digest.hex())

    async def look(self, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Show what it was given to show."""
        if sight not in self.shows or not self.profile.offers(sight):
            raise NothingToSee(said("{robot} shows nothing now.", robot=self.profile.shown))
        self.looked += 1
        try:
            while True:
                yield View(self.shows[sight], self._clock.monotonic_ns())
                await self._clock.sleep(LOOK_EVERY_S)
        finally:
            self.looked -= 1


def _to_nobody(_words: bytes, _dropped: int) -> None:
    """Nobody hears it before it has met anybody."""


@coroutine
def _one_turn() -> Generator[None, None, None]:
    """Let everybody else have a turn, as a sleep of no seconds does, without its calls."""
    yield


def _finish(end: asyncio.Future[Outcome | None], ended: Outcome | None = None) -> None:
    if not end.done():
        end.set_result(ended)
