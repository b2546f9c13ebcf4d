"""``contracts.robot.Robot`` in executable form: every adapter's tests subclass this suite.

Each rule has a faulty robot that breaks it, in ``rosic.testing.faulty.robots``; a test shows that
each is caught.
"""

from __future__ import annotations

import asyncio
from contextlib import aclosing
from math import nan
from typing import TYPE_CHECKING, ClassVar

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding, OrderStage, Outcome, StageReport, Stop
from rosic.core.robot.view import ViewKind
from rosic.errors import NothingToSee, OrderVoid, RobotOffline, RobotUnreachable, StillMoves
from rosic.testing.factories import OrderBook

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable
    from contextlib import AbstractAsyncContextManager
    from typing import TypeAlias

    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Robot
    from rosic.core.order import Order
    from rosic.core.robot.skill import Argument
    from rosic.errors import RosicError

    MakeRobot: TypeAlias = Callable[[], AbstractAsyncContextManager[Robot]]

LOOK_EVERY_S = 0.01
# What a robot's side may say of its progress that is none, between two fractions that are.
NO_PROGRESS = (0.2, 7.0, nan, -1.0)


class RobotConformance:
    """Subclass, set the class attributes, and provide the fixtures ``make_robot`` and ``clock``.

    ``make_robot()`` is an asynchronous context manager that gives an opened robot which has not
    moved yet, with a fresh gate; at its end it closes the robot, even where a rule has done so.
    Nothing here sleeps and hopes: every wait has a bound.

    The rules ask the robot's side itself what it does, and have it fail: `acted`, `moves`,
    `fall_silent`, `ignore_orders`, `say_progress` and `say_done` are to be overridden. Each of the
    last four acts before it returns, and holds until the robot of this rule is closed.

    Attributes:
        short, short_arguments: A skill that ends by itself within seconds.
        long, long_arguments: One that moves the robot for as long as a rule may take, unless it is
            stopped.
        says_progress: Whether its side says how far it is. Where it does not, no fraction is told.
        bound_s: How long each wait may take before the rule counts as broken.
    """

    short: ClassVar[str]
    short_arguments: ClassVar[dict[str, Argument]] = {}
    long: ClassVar[str]
    long_arguments: ClassVar[dict[str, Argument]] = {}
    says_progress: ClassVar[bool] = True
    bound_s: ClassVar[float] = 30.0

    # ---- what the robot's side does, and how it fails: to be overridden ----

    def acted(self, robot: Robot) -> int:
        """Return how often the robot's side began to act."""
        raise NotImplementedError

    async def moves(self, robot: Robot) -> bool:
        """Return whether it moves, as the robot's side knows it: nothing that the link says."""
        raise NotImplementedError

    async def fall_silent(self, robot: Robot) -> None:
        """From now on nothing of it is heard. It goes on moving, and still hears."""
        raise NotImplementedError

    async def ignore_orders(self, robot: Robot) -> None:
        """From now on it neither takes nor answers an order, as if that were lost on its way."""
        raise NotImplementedError

    async def say_progress(self, robot: Robot, fraction: float) -> None:
        """Say once how far it is, whatever is true; the fraction may be no such thing."""
        raise NotImplementedError

    async def say_done(self, robot: Robot) -> None:
        """Say that the order under way is done. It goes on moving."""
        raise NotImplementedError

    # ---- the rules ----

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
            assert not await self.moves(robot), "it still moves, and its rest was confirmed"

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
            assert not await self.moves(robot), "it still moves after its order was cancelled"

    async def test_nothing_is_received_or_done_without_the_robots_word(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            await self.ignore_orders(robot)
            stages: list[OrderStage] = []
            ended = await self._ended(self._execute(robot, self._short(robot, clock), stages))
            assert set(stages) <= {OrderStage.SENT}, stages
            assert _ending(ended) not in (OrderEnding.DONE, OrderEnding.CANCELLED), ended
            assert self.acted(robot) == 0

    async def test_done_is_said_only_of_a_robot_at_rest(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            running = await self._moving(robot, clock)
            await self.say_done(robot)
            ended = await self._ended(running)
            if _ending(ended) is OrderEnding.DONE and ended.code != StillMoves.code:
                assert not await self.moves(robot), f"it still moves: {ended}"

    async def test_progress_is_checked_and_ends_with_the_order(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            told: list[StageReport] = []
            running = await self._moving(robot, clock, told)
            if self.says_progress:
                await self._says(robot, 0.4, told)
                for nonsense in NO_PROGRESS:
                    await self.say_progress(robot, nonsense)
                await self._says(robot, 0.6, told)
            await asyncio.wait_for(robot.stop(Stop(robot.profile.id, 1)), self.bound_s)
            await self._ended(running)
            at_the_end = len(told)
            if self.says_progress:
                await self.say_progress(robot, 0.9)
            await robot.resume(1)
            order = OrderBook(robot.profile, clock).order(
                self.short, self.short_arguments, n=7, stop_generation=1
            )
            await self._ended(self._execute(robot, order))  # all before it was heard by then
            assert len(told) == at_the_end, "told after the end"
            fractions = _fractions(told)
            assert self.says_progress or not fractions, "nobody said how far it is"
            assert all(0.0 <= fraction <= 1.0 for fraction in fractions), fractions
            assert fractions == sorted(fractions)

    async def test_a_silent_robot_is_offline_and_is_sent_nothing(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            order = OrderBook(robot.profile, clock)
            await self._until(_seen(robot, online=True))
            await self.fall_silent(robot)
            await self._until(_seen(robot, online=False))
            assert robot.presence().at_rest is not True, "nobody measures its rest now"
            before = self.acted(robot)
            with pytest.raises(RobotOffline):
                await self._execute(robot, order.order(self.short, self.short_arguments))
            assert self.acted(robot) == before

    async def test_a_robot_lost_while_it_moves_is_stopped_and_ends_in_doubt(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            running = await self._moving(robot, clock)
            await self.fall_silent(robot)
            ended = await self._ended(running)
            assert isinstance(ended, RobotUnreachable) or _ending(ended) is OrderEnding.UNKNOWN, (
                ended
            )
            assert not await self.moves(robot), "it was given up, and still moves"

    async def test_closing_brings_the_robot_to_rest(
        self, make_robot: MakeRobot, clock: Clock
    ) -> None:
        async with make_robot() as robot:
            running = await self._moving(robot, clock)
            await asyncio.wait_for(robot.close(), self.bound_s)
            assert not await self.moves(robot), "it was left moving"
            ended = await self._ended(running)
            assert _ending(ended) is not OrderEnding.DONE, ended

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
        self, robot: Robot, clock: Clock, told: list[StageReport] | None = None
    ) -> tuple[asyncio.Task[Outcome], asyncio.Event]:
        received = asyncio.Event()
        order = OrderBook(robot.profile, clock).order(self.long, self.long_arguments)

        def tell(report: StageReport) -> None:
            if told is not None:
                told.append(report)
            if report.stage is not OrderStage.SENT:
                received.set()

        return asyncio.create_task(robot.execute(order, tell)), received

    async def _moving(
        self, robot: Robot, clock: Clock, told: list[StageReport] | None = None
    ) -> asyncio.Task[Outcome]:
        """Begin what is long; return once the robot's side has it, and moves."""
        running, received = self._begin_long(robot, clock, told)
        await asyncio.wait_for(received.wait(), self.bound_s)
        await self._until(lambda: self.moves(robot))
        return running

    async def _says(self, robot: Robot, fraction: float, told: list[StageReport]) -> None:
        """Have it say how far it is; return once that was told."""

        async def is_told() -> bool:
            return any(seen >= fraction for seen in _fractions(told) if seen <= 1.0)

        await self.say_progress(robot, fraction)
        await self._until(is_told)

    async def _ended(self, running: Awaitable[Outcome]) -> Outcome | RosicError:
        """Return how it ended, or the error that says so."""
        try:
            return await asyncio.wait_for(running, self.bound_s)
        except (RobotOffline, RobotUnreachable) as error:
            return error

    async def _until(self, holds: Callable[[], Awaitable[bool]]) -> None:
        async with asyncio.timeout(self.bound_s):
            while not await holds():  # noqa: ASYNC110 - what is measured tells nobody
                await asyncio.sleep(LOOK_EVERY_S)

    async def _is_void(self, robot: Robot, order: Order) -> None:
        before = self.acted(robot)
        with pytest.raises(OrderVoid):
            await self._execute(robot, order)
        assert self.acted(robot) == before


def _ending(ended: Outcome | RosicError) -> OrderEnding | None:
    return ended.ending if isinstance(ended, Outcome) else None


def _fractions(told: list[StageReport]) -> list[float]:
    return [report.fraction for report in told if report.fraction is not None]


def _seen(robot: Robot, *, online: bool) -> Callable[[], Awaitable[bool]]:
    async def is_seen() -> bool:
        return robot.presence().online is online

    return is_seen


def _ignore(_report: StageReport) -> None:
    """The report does not matter here."""
