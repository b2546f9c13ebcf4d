"""Simulated robots while this process, or the whole machine, stands still: nothing goes on (I6)."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.deadman import STOOD_STILL
from rosic.core.order import OrderEnding, Outcome
from rosic.core.order_gate import OrderGate
from rosic.robots.ros2.profile import Ros2Link
from rosic.testing.clock import ManualClock
from rosic.testing.factories import OrderBook
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.simulation_loop import simulation_of

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.order import Order
    from rosic.core.robot.skill import Argument

AHEAD: dict[str, Argument] = {"linear": 0.2, "lateral": 0.0, "angular": 0.0, "duration": 5.0}


@asynccontextmanager
async def robot_of(name: str, clock: ManualClock) -> AsyncIterator[SimulatedRobot]:
    model = "crazyflie" if name.startswith("cf") else name
    profile = replace(
        load_profile(shipped_profiles()[name]), link=Ros2Link(kind="simulated", model=model)
    )
    robot = SimulatedRobot(profile, OrderGate.new(name), clock)
    await robot.open(lambda _text: None)
    try:
        yield robot
    finally:
        await clock.advance(60.0)  # whatever went on has come to its end
        closing = asyncio.create_task(robot.close())
        await clock.advance(10.0)
        await closing


def begun(robot: SimulatedRobot, order: Order) -> asyncio.Task[Outcome]:
    return asyncio.create_task(robot.execute(order, lambda _report: None))


def x_m(robot: SimulatedRobot, clock: ManualClock) -> float:
    return float(simulation_of(clock).world.machines[robot.profile.id].telemetry()["x_m"])


async def test_a_drive_ends_for_good_and_says_for_how_long_it_drove() -> None:
    clock = ManualClock()
    async with robot_of("omni", clock) as robot:
        running = begun(robot, OrderBook(robot.profile, clock).order("drive", AHEAD))
        await clock.advance(2.0)
        at_m = x_m(robot, clock)
        clock.suspend(8.0)
        await clock.advance(5.0)
        outcome = running.result()
        assert x_m(robot, clock) - at_m < 0.2, "its watchdog stops it, and nothing moves it again"
    assert (outcome.ending, outcome.code) == (OrderEnding.FAILED, STOOD_STILL)
    assert outcome.note.startswith(
        "drove for 2.0 s; broken off because ROSIC itself stood still for 8."
    )


async def test_what_a_machine_does_by_itself_ends_as_without_a_link() -> None:
    clock = ManualClock()
    async with robot_of("omni", clock) as robot:
        order = OrderBook(robot.profile, clock).order(
            "move", {"direction": "forward", "distance": 4.0, "speed": 0.25}
        )
        running = begun(robot, order)
        await clock.advance(2.0)
        at_m = x_m(robot, clock)
        clock.suspend(8.0)
        await clock.advance(5.0)
        outcome = running.result()
        assert x_m(robot, clock) - at_m < 0.5, "a second until the link is lost, and braking"
    assert (outcome.ending, outcome.code) == (OrderEnding.CANCELLED, STOOD_STILL)
    assert outcome.note == "link lost, holding"


async def test_a_drone_that_follows_does_not_follow_on() -> None:
    clock = ManualClock()
    async with robot_of("cf1", clock) as leader, robot_of("cf2", clock) as follower:
        books = {r.profile.id: OrderBook(r.profile, clock) for r in (leader, follower)}
        rising = [
            begun(r, books[r.profile.id].order("takeoff", {"height": 1.0}))
            for r in (leader, follower)
        ]
        await clock.advance(6.0)
        assert {(await up).ending for up in rising} == {OrderEnding.DONE}
        following = begun(follower, books["cf2"].order("follow", FOLLOW))
        await clock.advance(2.0)
        clock.suspend(8.0)
        await clock.advance(10.0)
        assert following.result().code == STOOD_STILL
        assert simulation_of(clock).world.machines["cf2"].at_rest(), "it has landed"


FOLLOW: dict[str, Argument] = {"leader": "cf1", "distance": 1.5, "bearing": 0.0}
