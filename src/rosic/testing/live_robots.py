"""``contracts.robot.LiveRobot`` in executable form, for adapters of robots that are driven live.

Each rule has a faulty robot that breaks it, in ``rosic.testing.faulty.live_robots``.
"""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, ClassVar

import pytest
from msgspec.structs import replace

from rosic.contracts.live_control import LiveControls
from rosic.contracts.robot import LiveRobot
from rosic.core.order import OrderEnding, OrderStage, Outcome, StageReport, Stop
from rosic.core.robot.skill import DURATION
from rosic.core.sample_gate import CONTROLS_SILENT, LiveRange, LiveSample, SampleGate
from rosic.errors import OrderVoid
from rosic.testing.factories import OrderBook
from rosic.testing.robots import RobotConformance

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Robot
    from rosic.core.order import Order
    from rosic.errors import RosicError
    from rosic.testing.robots import MakeRobot

SAMPLE_EVERY_S = 0.05
# Whatever would move by itself has begun by then.
NOT_YET_S = 0.5


class LiveRobotConformance(RobotConformance):
    """Every rule of robots, and those of being driven live; subclass it instead.

    Attributes:
        live: A skill that streams.
        live_values: A sample of it that moves the robot, SI.
    """

    live: ClassVar[str]
    live_values: ClassVar[dict[str, float]]

    async def test_driven_live_nothing_moves_before_the_first_sample(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with self._steered(make_robot, clock) as (robot, hand):
            await asyncio.sleep(NOT_YET_S)
            assert self.acted(robot) == 0
            hand.controls.release()
            outcome = await self._ended(hand.running)
            assert _ended_as(outcome) is OrderEnding.CANCELLED, outcome
            assert self.acted(robot) == 0
            assert not await self.moves(robot)

    async def test_driven_live_it_is_done_at_rest_when_let_go(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with self._steered(make_robot, clock) as (robot, hand):
            hand.hold(self.live_values)
            await self._until(lambda: self.moves(robot))
            await asyncio.wait_for(hand.received.wait(), self.bound_s)
            hand.let_go()
            outcome = await self._ended(hand.running)
            assert _ended_as(outcome) is OrderEnding.DONE, outcome
            assert not await self.moves(robot), "it was let go, and moves"

    async def test_driven_live_silence_brings_it_to_rest_for_good(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with self._steered(make_robot, clock) as (robot, hand):
            hand.hold(self.live_values)
            await self._until(lambda: self.moves(robot))
            hand.fall_silent()
            outcome = await self._ended(hand.running)
            assert _ended_as(outcome) is OrderEnding.CANCELLED, outcome
            assert isinstance(outcome, Outcome)
            assert outcome.code == CONTROLS_SILENT
            assert not await self.moves(robot), "nothing comes of its controls, and it moves"
            hand.hold(self.live_values)
            await asyncio.sleep(NOT_YET_S)
            assert not await self.moves(robot), "it went on by itself"

    async def test_driven_live_the_newest_sample_counts(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with self._steered(make_robot, clock) as (robot, hand):
            for _ in range(2):
                hand.hold(self.live_values)
                await self._until(lambda: self.moves(robot))
                hand.hold({})
                await self._until(lambda: self._rests(robot))
            assert not hand.running.done(), "it is under way, at rest"
            hand.let_go()
            outcome = await self._ended(hand.running)
            assert _ended_as(outcome) is OrderEnding.DONE, outcome

    async def test_driven_live_a_stop_ends_it(self, make_robot: MakeRobot, clock: Clock) -> None:
        async with self._steered(make_robot, clock) as (robot, hand):
            hand.hold(self.live_values)
            await self._until(lambda: self.moves(robot))
            rest = await asyncio.wait_for(robot.stop(Stop(robot.profile.id, 1)), self.bound_s)
            outcome = await self._ended(hand.running)
            assert _ended_as(outcome) is OrderEnding.CANCELLED, outcome
            assert rest.confirmed
            assert not await self.moves(robot), "it is steered on through a stop"

    async def test_driven_live_cancelling_brings_it_to_rest(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with self._steered(make_robot, clock) as (robot, hand):
            hand.hold(self.live_values)
            await self._until(lambda: self.moves(robot))
            hand.running.cancel()
            with pytest.raises(asyncio.CancelledError):
                await asyncio.wait_for(hand.running, self.bound_s)
            assert not robot.presence().doing
            assert not await self.moves(robot), "it still moves after its order was cancelled"

    async def test_driven_live_it_passes_the_gate(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with self._steered(make_robot, clock, fence=6) as (robot, hand):
            newer = OrderBook(robot.profile, clock).order(self.short, self.short_arguments, fence=7)
            robot.gate.pass_order(newer, clock.monotonic_ns(), clock.wall_ns())
            hand.hold(self.live_values)
            with pytest.raises(OrderVoid):
                await asyncio.wait_for(hand.running, self.bound_s)
            assert self.acted(robot) == 0
            assert not await self.moves(robot)

    # ------------------------------------------------------------------------------------------

    @asynccontextmanager
    async def _steered(
        self, make_robot: MakeRobot, clock: Clock, fence: int = 1
    ) -> AsyncIterator[tuple[Robot, _Hand]]:
        """Begin a live order; nobody has steered yet."""
        async with make_robot() as robot:
            assert isinstance(robot, LiveRobot), "it cannot be driven live"
            order = OrderBook(robot.profile, clock).order(self.live, {"duration": 0.1}, fence=fence)
            order = replace(order, live=True, n=order.n + (fence - 1))
            bounds = tuple(
                LiveRange(name, -abs(value), abs(value)) for name, value in self._bounds(robot)
            )
            gate = SampleGate(order.cid, bounds, order.arguments)
            hand = _Hand(robot, order, LiveControls(gate, clock))
            try:
                yield robot, hand
            finally:
                hand.fall_silent()
                hand.running.cancel()
                await asyncio.gather(hand.running, return_exceptions=True)

    def _bounds(self, robot: Robot) -> Iterator[tuple[str, float]]:
        """Yield every number that is steered, and one that no sample here goes beyond."""
        for name, parameter in robot.profile.skills[self.live].parameters.items():
            if parameter.max is not None and name != DURATION:
                yield name, self.live_values.get(name, 0.0)

    async def _rests(self, robot: Robot) -> bool:
        return not await self.moves(robot)


class _Hand:
    """Steers one live order."""

    def __init__(self, robot: LiveRobot, order: Order, controls: LiveControls) -> None:
        self.controls = controls
        self.received = asyncio.Event()
        self._order = order
        self._number = 0
        self._held: asyncio.Task[None] | None = None
        self.running = asyncio.create_task(robot.execute_live(order, self._tell, controls))

    def _tell(self, report: StageReport) -> None:
        if report.stage is not OrderStage.SENT:
            self.received.set()

    def hold(self, values: dict[str, float]) -> None:
        """Send this again and again, from now on."""
        self.fall_silent()
        self._held = asyncio.create_task(self._hold(values))

    async def _hold(self, values: dict[str, float]) -> None:
        while True:
            self._number += 1
            sample = LiveSample(
                self._order.cid, values, self.controls.clock.wall_ns(), self._number
            )
            self.controls.put(sample)
            await asyncio.sleep(SAMPLE_EVERY_S)

    def fall_silent(self) -> None:
        """Send nothing any more."""
        if self._held is not None:
            self._held.cancel()
        self._held = None

    def let_go(self) -> None:
        """Release the controls."""
        self.fall_silent()
        self.controls.release()


def _ended_as(ended: Outcome | RosicError) -> OrderEnding | None:
    return ended.ending if isinstance(ended, Outcome) else None
