"""Robots that are driven live and each break one rule of that."""

from __future__ import annotations

import asyncio
from itertools import count
from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

from rosic.contracts.live_control import LiveControls
from rosic.contracts.robot import LiveRobot
from rosic.core.order import OrderEnding
from rosic.core.sample_gate import LiveEnd, LiveSample
from rosic.testing.faulty.robots import LOOK_EVERY_S, FaultyRobot, StopsOnlyInWords

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.skill import Argument

AFTER_ALL: Final = 1_000_000


class FaultyLiveRobot(FaultyRobot):
    """An honest one inside that can be driven live; each faulty one overrides one thing."""

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Let the honest one be steered."""
        assert isinstance(self.honest, LiveRobot)
        return await self.honest.execute_live(order, tell, controls)


class ActsBeforeItIsSteered(FaultyLiveRobot):
    """Does what the order says while nobody has said anything yet."""

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Begin with the order's own values."""
        await self.honest.execute(replace(order, live=False), tell)
        return await super().execute_live(replace(order, n=order.n + 1), tell, controls)


class TakesReleaseForTrouble(FaultyLiveRobot):
    """Says that something was wrong when it was only let go."""

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Say so."""
        outcome = await super().execute_live(order, tell, controls)
        return replace(outcome, ending=OrderEnding.FAILED)


class SteersItself(FaultyLiveRobot):
    """Says the last values again when nothing comes, so that it does not stutter."""

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Go on by itself."""
        keeping = asyncio.ensure_future(self._keep(order, controls))
        try:
            return await super().execute_live(order, tell, controls)
        finally:
            keeping.cancel()

    async def _keep(self, order: Order, controls: LiveControls) -> None:
        for number in count(AFTER_ALL):
            now_ns = controls.clock.wall_ns()
            values = {one.name: 1.0 for one in controls.gate.ranges}
            if controls.gate.taken_ns:
                controls.put(LiveSample(order.cid, values, now_ns, number))
            await asyncio.sleep(LOOK_EVERY_S)


class HoldsTheFirstSample(FaultyLiveRobot):
    """Follows the first values for as long as others come."""

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Let no other count."""
        first = _FirstValues(controls.gate, controls.clock)
        running = asyncio.ensure_future(super().execute_live(order, tell, first))
        try:
            while not running.done():
                if controls.gate.end is LiveEnd.RELEASED:
                    first.release()
                await asyncio.sleep(LOOK_EVERY_S)
        finally:
            running.cancel()
        return await running


class _FirstValues(LiveControls):
    """Keeps the values that it had first."""

    first: Mapping[str, Argument] | None = None

    @property
    def values(self) -> Mapping[str, Argument]:
        """Return them."""
        if self.first is None:
            self.first = dict(super().values)
        return self.first


class IsSteeredThroughCancelling(FaultyLiveRobot):
    """Lets nobody cancel it."""

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Go on behind the caller's back."""
        return await asyncio.shield(
            asyncio.ensure_future(super().execute_live(order, tell, controls))
        )


class IsSteeredPastTheGate(FaultyLiveRobot):
    """Takes whoever steers for whoever has the robot."""

    async def execute_live(self, order: Order, tell: Tell, controls: LiveControls) -> Outcome:
        """Give it a high fence."""
        permit = replace(order.permit, fence=max(99, order.permit.fence))
        ahead = replace(order, permit=permit, n=order.n + 1_000)
        return await super().execute_live(ahead, tell, controls)


class StopsWhileSteered(StopsOnlyInWords, FaultyLiveRobot):
    """Confirms a stop, and is steered on."""


LIVE_FAULTS_BY_RULE: dict[str, type[FaultyRobot]] = {
    "test_driven_live_nothing_moves_before_the_first_sample": ActsBeforeItIsSteered,
    "test_driven_live_it_is_done_at_rest_when_let_go": TakesReleaseForTrouble,
    "test_driven_live_silence_brings_it_to_rest_for_good": SteersItself,
    "test_driven_live_the_newest_sample_counts": HoldsTheFirstSample,
    "test_driven_live_a_stop_ends_it": StopsWhileSteered,
    "test_driven_live_cancelling_brings_it_to_rest": IsSteeredThroughCancelling,
    "test_driven_live_it_passes_the_gate": IsSteeredPastTheGate,
}
