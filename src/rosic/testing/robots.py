"""``contracts.robot.Robot`` in executable form: every adapter's tests subclass this suite.

Each rule has a faulty robot that breaks it, in ``rosic.testing.faulty.robots``; a test shows that
each is caught.
"""

from __future__ import annotations

import asyncio
from contextlib import aclosing
from typing import TYPE_CHECKING, ClassVar

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding, OrderStage, Outcome, StageReport, Stop
from rosic.core.robot.view import ViewKind
from rosic.errors import NothingToSee, OrderVoid
from rosic.testing.factories import OrderBook

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractAsyncContextManager
    from typing import TypeAlias

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Robot
    from rosic.core.order import Order
    from rosic.core.robot.skill import Argument

    MakeRobot: TypeAlias = Callable[[], AbstractAsyncContextManager[Robot]]


class RobotConformance:
    """Subclass, set the class attributes, and provide the fixtures ``make_robot`` and ``clock``.

    ``make_robot()`` is an asynchronous context manager that gives an opened robot which has not
    moved yet, with a fresh gate. Nothing here sleeps and hopes: every wait has a bound.

    Attributes:
        short, short_arguments: A skill that ends by itself within seconds.
        long, long_arguments: One that lasts at least a second unless it is stopped.
        bound_s: How long each wait may take before the rule counts as broken.
    """

    short: ClassVar[str]
    short_arguments: ClassVar[dict[str, Argument]] = {}
    long: ClassVar[str]
    long_arguments: ClassVar[dict[str, Argument]] = {}
    bound_s: ClassVar[float] = 30.0

    def acted(self, robot: Robot) -> int:
        """Return how often the robot's side began to act. To be overridden."""
        raise NotImplementedError

    async def test_an_order_acts_once_and_ends_done(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            outcome = await self._execute(robot, self._short(robot, clock))
            assert outcome.ending in (OrderEnding.DONE, OrderEnding.SENT), outcome
            assert self.acted(robot) == 1

    async def test_received_is_said_after_sent_and_before_running(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            stages: list[OrderStage] = []
            await self._execute(robot, self._short(robot, clock), stages)
            ranks = [list(OrderStage).index(stage) for stage in stages]
            assert stages[0] is OrderStage.SENT
            assert ranks == sorted(ranks)

    async def test_progress_never_falls(self, make_robot: MakeRobot, clock: Clock) -> None:
        async with make_robot() as robot:
            seen: list[float] = []
            book = OrderBook(robot.profile, clock)

            def tell(report: StageReport) -> None:
                if report.fraction is not None:
                    seen.append(report.fraction)

            order = book.order(self.short, self.short_arguments)
            await asyncio.wait_for(robot.execute(order, tell), self.bound_s)
            assert seen == sorted(seen)
            assert all(0.0 <= fraction <= 1.0 for fraction in seen)

    async def test_the_same_order_again_does_nothing(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            order = OrderBook(robot.profile, clock).order(self.short, self.short_arguments)
            await asyncio.wait_for(robot.execute(order, _ignore), self.bound_s)
            await self._is_void(robot, order)

    async def test_an_order_overtaken_by_a_later_one_does_nothing(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            book = OrderBook(robot.profile, clock)
            later = book.order(self.short, self.short_arguments, n=7)
            await asyncio.wait_for(robot.execute(later, _ignore), self.bound_s)
            await self._is_void(robot, book.order(self.short, self.short_arguments, n=6))

    async def test_an_order_under_an_old_lease_does_nothing(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            book = OrderBook(robot.profile, clock)
            newer = book.order(self.short, self.short_arguments, fence=7)
            await asyncio.wait_for(robot.execute(newer, _ignore), self.bound_s)
            await self._is_void(robot, book.order(self.short, self.short_arguments, fence=6))

    async def test_an_order_that_is_too_late_does_nothing(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            order = OrderBook(robot.profile, clock).order(self.short, self.short_arguments)
            await self._is_void(robot, replace(order, deadline_ns=clock.monotonic_ns() - 1_000_000))

    async def test_an_order_that_is_too_late_by_the_wall_clock_does_nothing(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            order = OrderBook(robot.profile, clock).order(self.short, self.short_arguments)
            await self._is_void(robot, replace(order, expires_ns=clock.wall_ns() - 1_000_000))

    async def test_a_stop_ends_what_is_under_way(self, make_robot: MakeRobot, clock: Clock) -> None:
        async with make_robot() as robot:
            running, received = self._begin_long(robot, clock)
            await asyncio.wait_for(received.wait(), self.bound_s)
            rest = await asyncio.wait_for(robot.stop(Stop(robot.profile.id, 1)), self.bound_s)
            outcome = await asyncio.wait_for(running, self.bound_s)
            assert outcome.ending is OrderEnding.CANCELLED, outcome
            assert rest.robot == robot.profile.id
            assert rest.confirmed
            assert robot.presence().at_rest is not False

    async def test_a_stop_is_latched_at_once(self, make_robot: MakeRobot, clock: Clock) -> None:
        async with make_robot() as robot:
            stopping = robot.stop(Stop(robot.profile.id, 1))
            task = asyncio.ensure_future(stopping)
            await asyncio.sleep(0)
            latched = robot.gate.latched
            await asyncio.wait_for(task, self.bound_s)
            assert latched
            order = OrderBook(robot.profile, clock).order(
                self.short, self.short_arguments, stop_generation=1
            )
            await self._is_void(robot, order)

    async def test_a_stopped_robot_moves_again_only_after_its_resume(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            await asyncio.wait_for(robot.stop(Stop(robot.profile.id, 2)), self.bound_s)
            await robot.resume(1)
            book = OrderBook(robot.profile, clock)
            early = book.order(self.short, self.short_arguments, stop_generation=2)
            await self._is_void(robot, early)
            await robot.resume(2)
            order = book.order(self.short, self.short_arguments, stop_generation=2)
            outcome = await self._execute(robot, order)
            assert outcome.ending in (OrderEnding.DONE, OrderEnding.SENT), outcome

    async def test_an_order_from_before_a_stop_never_acts(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            order = OrderBook(robot.profile, clock).order(self.short, self.short_arguments)
            await asyncio.wait_for(robot.stop(Stop(robot.profile.id, 1)), self.bound_s)
            await robot.resume(1)
            await self._is_void(robot, order)

    async def test_cancelling_brings_the_robot_to_rest(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            running, received = self._begin_long(robot, clock)
            await asyncio.wait_for(received.wait(), self.bound_s)
            running.cancel()
            with pytest.raises(asyncio.CancelledError):
                await asyncio.wait_for(running, self.bound_s)
            assert robot.presence().at_rest is not False
            assert not robot.presence().doing

    async def test_what_its_profile_does_not_offer_cannot_be_seen(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            for sight in ViewKind:
                async with aclosing(robot.look(sight)) as views:
                    try:
                        view = await asyncio.wait_for(anext(views), self.bound_s)
                    except NothingToSee:
                        continue
                    assert robot.profile.offers(sight)
                    assert view.taken_ns <= clock.monotonic_ns()

    # ------------------------------------------------------------------------------------------

    def _short(self, robot: Robot, clock: Clock) -> Order:
        return OrderBook(robot.profile, clock).order(self.short, self.short_arguments)

    async def _execute(
        self, robot: Robot, order: Order, stages: list[OrderStage] | None = None
    ) -> Outcome:
        def tell(report: StageReport) -> None:
            if stages is not None:
                stages.append(report.stage)

        return await asyncio.wait_for(robot.execute(order, tell), self.bound_s)

    def _begin_long(
        self, robot: Robot, clock: Clock
    ) -> tuple[asyncio.Task[Outcome], asyncio.Event]:
        received = asyncio.Event()
        order = OrderBook(robot.profile, clock).order(self.long, self.long_arguments)

        def tell(report: StageReport) -> None:
            if report.stage is not OrderStage.SENT:
                received.set()

        return asyncio.create_task(robot.execute(order, tell)), received

    async def _is_void(self, robot: Robot, order: Order) -> None:
        before = self.acted(robot)
        with pytest.raises(OrderVoid):
            await self._execute(robot, order)
        assert self.acted(robot) == before


def _ignore(_report: StageReport) -> None:
    """The report does not matter here."""
