"""Robots that each break one rule of the contract, to show that the suite would notice."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.order import OrderEnding, OrderStage, Outcome, RestReport, StageReport
from rosic.core.robot.view import CompressedFrame, View
from rosic.errors import OrderVoid, RobotOffline, RobotUnreachable

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.contracts.robot import Robot, Say, Tell
    from rosic.core.order import Order, Stop
    from rosic.core.order_gate import OrderGate
    from rosic.core.robot.profile import Presence, Profile
    from rosic.core.robot.view import ViewKind

FAR_NS = 2**63 - 1
LOOK_EVERY_S = 0.001


class FaultyRobot:
    """An honest robot inside; each faulty one overrides one thing."""

    def __init__(self, honest: Robot) -> None:
        self.honest = honest

    @property
    def profile(self) -> Profile:
        """Return the profile of the honest one."""
        return self.honest.profile

    @property
    def gate(self) -> OrderGate:
        """Return the gate of the honest one."""
        return self.honest.gate

    async def open(self, say: Say) -> None:
        """Open the honest one."""
        await self.honest.open(say)

    async def close(self) -> None:
        """Close the honest one."""
        await self.honest.close()

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Let the honest one do it."""
        return await self.honest.execute(order, tell)

    async def stop(self, stop: Stop) -> RestReport:
        """Let the honest one stop."""
        return await self.honest.stop(stop)

    async def resume(self, generation: int) -> None:
        """Let the honest one resume."""
        await self.honest.resume(generation)

    def presence(self) -> Presence:
        """Return what the honest one says."""
        return self.honest.presence()

    def look(self, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Show what the honest one shows."""
        return self.honest.look(sight)


class ActsTwice(FaultyRobot):
    """At most once? Twice."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Act, and act again."""
        await self.honest.execute(order, tell)
        return await self.honest.execute(replace(order, n=order.n + 1000), tell)


class SaysReceivedTooEarly(FaultyRobot):
    """Claims a receipt before anything was sent."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Report first."""
        tell(StageReport(OrderStage.RECEIVED))
        return await self.honest.execute(order, tell)


class FallsBack(FaultyRobot):
    """Its progress falls."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Report progress, then less."""
        outcome = await self.honest.execute(order, tell)
        tell(StageReport(OrderStage.RUNNING, 0.9))
        tell(StageReport(OrderStage.RUNNING, 0.1))
        return outcome


class ForgetsNumbers(FaultyRobot):
    """Takes every order for a new one."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Give it the next number."""
        return await self.honest.execute(replace(order, n=self.gate.n + 1), tell)


class ForgetsTheFence(FaultyRobot):
    """Takes every lease for the newest."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Give it a high fence."""
        permit = replace(order.permit, fence=max(99, order.permit.fence))
        return await self.honest.execute(replace(order, permit=permit), tell)


class ForgetsTheTime(FaultyRobot):
    """Acts however late it is."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Give it all the time in the world."""
        return await self.honest.execute(replace(order, deadline_ns=FAR_NS), tell)


class ForgetsTheWallClock(FaultyRobot):
    """Asks only the clock that stands still while a virtual machine is paused."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Give it all the time in the world, on the other clock."""
        return await self.honest.execute(replace(order, expires_ns=FAR_NS), tell)


class StopsOnlyInWords(FaultyRobot):
    """Confirms a stop and goes on."""

    async def stop(self, stop: Stop) -> RestReport:
        """Say so."""
        return RestReport(stop.robot, confirmed=True, seconds=0.0)


class LatchesLate(FaultyRobot):
    """Thinks before it latches."""

    async def stop(self, stop: Stop) -> RestReport:
        """Wait a while first."""
        for _ in range(5):
            await asyncio.sleep(0)
        return await self.honest.stop(stop)


class ResumesAnything(FaultyRobot):
    """Takes an old resume for a new one."""

    async def resume(self, generation: int) -> None:  # noqa: ARG002 - that is the sin
        """Unlatch whatever the generation."""
        await self.honest.resume(self.gate.generation)


class ForgetsStops(FaultyRobot):
    """Acts on what was ordered before the stop."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Give it the newest generation."""
        permit = replace(order.permit, stop_generation=self.gate.generation)
        return await self.honest.execute(replace(order, permit=permit), tell)


class GoesOnWhenCancelled(FaultyRobot):
    """Lets nobody cancel it."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Go on behind the caller's back."""
        return await asyncio.shield(asyncio.ensure_future(self._quietly(order, tell)))

    async def _quietly(self, order: Order, tell: Tell) -> Outcome:
        try:
            return await self.honest.execute(order, tell)
        except OrderVoid:
            raise
        except BaseException:  # noqa: BLE001 - so that nobody hears of it
            return Outcome(ending=None)  # type: ignore[arg-type]


class TakesSentForReceived(FaultyRobot):
    """Says that its side has it, whatever its side says."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Say so."""
        try:
            return await self.honest.execute(order, tell)
        except (RobotOffline, RobotUnreachable):
            tell(StageReport(OrderStage.RECEIVED))
            return Outcome(OrderEnding.SENT)


class DoesNotMeasureTheEnd(FaultyRobot):
    """Takes its side's word for rest."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """End when its side says so."""
        self._running = asyncio.ensure_future(self.honest.execute(order, tell))
        await asyncio.sleep(0)
        while self.honest.presence().doing:  # noqa: ASYNC110 - it tells nobody
            await asyncio.sleep(LOOK_EVERY_S)
        return Outcome(OrderEnding.DONE)


class MakesUpProgress(FaultyRobot):
    """Reckons how far its side must be, and goes on with it."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Say half."""
        try:
            return await self.honest.execute(order, tell)
        finally:
            tell(StageReport(OrderStage.RUNNING, 0.5))


class IsAlwaysThere(FaultyRobot):
    """Takes a connection for a robot."""

    def presence(self) -> Presence:
        """Say that it is there."""
        return replace(self.honest.presence(), online=True)


class TakesSilenceForTheEnd(FaultyRobot):
    """Hears no more, and takes it for done."""

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        """Say so."""
        try:
            return await self.honest.execute(order, tell)
        except RobotUnreachable:
            return Outcome(OrderEnding.CANCELLED)


class LeavesItMoving(FaultyRobot):
    """Closes its connection only."""

    async def close(self) -> None:
        """Go."""


class ShowsEverything(FaultyRobot):
    """Shows what nobody has opened to people."""

    async def look(self, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Show something, whatever it is."""
        yield View(CompressedFrame(sight.value.encode()), 0)


FAULTS_BY_RULE: dict[str, type[FaultyRobot]] = {
    "test_an_order_acts_once_and_ends_done": ActsTwice,
    "test_received_is_said_after_sent_and_before_running": SaysReceivedTooEarly,
    "test_progress_never_falls": FallsBack,
    "test_the_same_order_again_does_nothing": ForgetsNumbers,
    "test_an_order_overtaken_by_a_later_one_does_nothing": ForgetsNumbers,
    "test_an_order_under_an_old_lease_does_nothing": ForgetsTheFence,
    "test_an_order_that_is_too_late_does_nothing": ForgetsTheTime,
    "test_an_order_that_is_too_late_by_the_wall_clock_does_nothing": ForgetsTheWallClock,
    "test_a_stop_ends_what_is_under_way": StopsOnlyInWords,
    "test_a_stop_is_latched_at_once": LatchesLate,
    "test_a_stopped_robot_moves_again_only_after_its_resume": ResumesAnything,
    "test_an_order_from_before_a_stop_never_acts": ForgetsStops,
    "test_cancelling_brings_the_robot_to_rest": GoesOnWhenCancelled,
    "test_nothing_is_received_or_done_without_the_robots_word": TakesSentForReceived,
    "test_done_is_said_only_of_a_robot_at_rest": DoesNotMeasureTheEnd,
    "test_progress_is_checked_and_ends_with_the_order": MakesUpProgress,
    "test_a_silent_robot_is_offline_and_is_sent_nothing": IsAlwaysThere,
    "test_a_robot_lost_while_it_moves_is_stopped_and_ends_in_doubt": TakesSilenceForTheEnd,
    "test_closing_brings_the_robot_to_rest": LeavesItMoving,
    "test_what_its_profile_does_not_offer_cannot_be_seen": ShowsEverything,
}
