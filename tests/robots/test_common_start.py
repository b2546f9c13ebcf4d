"""What is to begin with others and comes too late for that does not begin."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order import Order, OrderEnding, Stop
from rosic.core.order_gate import OrderGate
from rosic.core.synchronised_start import TOO_LATE_NS
from rosic.errors import OrderVoid
from rosic.system import SystemClock
from rosic.testing.clock import ManualClock
from rosic.testing.factories import OrderBook
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.simulation_loop import simulation_of

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.order import Outcome
    from rosic.core.robot.skill import Argument

TOO_LATE = "This reached omni too late to begin with the others. Nothing was done."
MOVE: dict[str, Argument] = {"direction": "forward", "distance": 0.05, "speed": 0.5}
DRIVE: dict[str, Argument] = {"linear": 0.1, "lateral": 0.0, "angular": 0.0, "duration": 0.2}


class Here:
    """A simulated robot, and a start that it agreed on with others."""

    def __init__(self, clock: Clock | None = None) -> None:
        self.manual = ManualClock()
        self.clock = clock or self.manual
        profile = load_profile(shipped_profiles()["omni"])
        self.robot = SimulatedRobot(profile, OrderGate.new("omni"), self.clock)
        self.book = OrderBook(profile, self.clock)

    def order(
        self, late_ns: int, skill: str = "move", arguments: dict[str, Argument] = MOVE
    ) -> Order:
        """Return an order whose common start is over for so long."""
        start_ns = self.clock.monotonic_ns() - late_ns
        return replace(self.book.order(skill, arguments), start_ns=start_ns)

    async def done(self, order: Order) -> Outcome:
        task = asyncio.create_task(self.robot.execute(order, lambda _report: None))
        for _ in range(500):
            await self.manual.advance(0.02)
            if task.done():
                break
        return await task


async def test_who_hears_of_a_common_start_too_late_does_not_begin() -> None:
    here = Here()
    late = here.order(TOO_LATE_NS + 1)
    with pytest.raises(OrderVoid) as void:
        await here.done(late)
    assert void.value.sentence == TOO_LATE
    assert here.robot.begun == 0
    assert here.robot.presence().at_rest
    assert here.robot.gate.n < late.n, "it has not acted"


@pytest.mark.parametrize("late_ns", [-300_000_000, 0, TOO_LATE_NS])
async def test_who_hears_of_it_in_time_or_just_after_begins(late_ns: int) -> None:
    here = Here()
    order = here.order(late_ns)
    begun_ns = max(here.clock.monotonic_ns(), order.start_ns or 0)
    outcome = await here.done(order)
    assert outcome.ending is OrderEnding.DONE, outcome
    activity = simulation_of(here.clock).world.omni.activity
    assert activity is not None
    assert activity.begun_s == begun_ns / 1e9


async def test_a_later_line_of_a_message_waits_for_the_first_and_not_for_the_others() -> None:
    here = Here()
    later = replace(here.order(3_000_000_000), sequel=True)
    assert (await here.done(later)).ending is OrderEnding.DONE


async def test_what_has_no_place_for_a_common_start_is_not_too_late_for_it() -> None:
    here = Here(SystemClock())  # a stream that is cut into steps of time ends by real time only
    order = here.order(1_000_000_000, "drive", DRIVE)
    outcome = await here.robot.execute(order, lambda _report: None)
    assert outcome.ending is OrderEnding.DONE


async def test_a_stop_is_the_better_reason() -> None:
    here = Here()
    late = here.order(1_000_000_000)
    await here.robot.stop(Stop("omni", 1))
    with pytest.raises(OrderVoid, match="was stopped before this could begin"):
        await here.done(late)
