"""What robots of one clock share ends with them: no world is kept for good."""

from __future__ import annotations

import asyncio
import gc
from typing import TYPE_CHECKING
from weakref import ref

from msgspec.structs import replace

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order import OrderEnding, Stop
from rosic.core.order_gate import OrderGate
from rosic.robots.ros2.client.node import station_of
from rosic.robots.ros2.profile import Ros2Link
from rosic.system import SystemClock
from rosic.testing.factories import OrderBook
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.simulation_loop import simulation_of
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.core.robot.skill import Argument


async def moved_once(clock: SystemClock) -> None:
    """Let a robot live, move and go."""
    shipped = load_profile(shipped_profiles()["omni"])
    profile = replace(shipped, link=Ros2Link(kind="simulated", model="omni"))
    robot = SimulatedRobot(profile, OrderGate.new("omni"), clock)
    await robot.open(lambda _text: None)
    order = OrderBook(profile, clock).order(
        "drive", {"linear": 0.1, "lateral": 0.0, "angular": 0.0, "duration": 0.1}
    )
    outcome = await robot.execute(order, lambda _report: None)
    assert outcome.ending is OrderEnding.DONE
    await robot.close()


async def test_a_world_lives_as_long_as_its_clock() -> None:
    clock = SystemClock()
    world = ref(simulation_of(clock))
    await moved_once(clock)
    assert world() is simulation_of(clock)

    del clock
    async with asyncio.timeout(60 * pace()):
        while world() is not None:  # what stepped it is being cancelled
            await asyncio.sleep(0)
            gc.collect()


async def test_a_stop_in_full_motion_ends_when_rest_is_measured() -> None:
    clock = SystemClock()
    profile = load_profile(shipped_profiles()["omni"])
    robot = SimulatedRobot(
        replace(profile, link=Ros2Link(kind="simulated", model="omni")),
        OrderGate.new("omni"),
        clock,
    )
    await robot.open(lambda _text: None)
    forward: dict[str, Argument] = {"direction": "forward", "distance": 2.0, "speed": 0.25}
    order = OrderBook(profile, clock).order("move", forward)
    running = asyncio.create_task(robot.execute(order, lambda _report: None))
    async with asyncio.timeout(60 * pace()):
        while robot.presence().at_rest is not False:
            assert not running.done(), running.result()
            await clock.sleep(0.01)
        await clock.sleep(0.3)  # it takes its time to gain speed, and as long to lose it

        rest = await robot.stop(Stop("omni", 1))

        assert robot.presence().at_rest is True
        assert rest.confirmed
        assert rest.seconds > 0
        assert (await running).ending is OrderEnding.CANCELLED
    await robot.close()


async def test_two_clocks_are_two_worlds() -> None:
    ours, theirs = SystemClock(), SystemClock()

    assert simulation_of(ours) is simulation_of(ours)
    assert simulation_of(ours) is not simulation_of(theirs)


def test_a_ros_2_station_lives_as_long_as_its_clock() -> None:
    clock = SystemClock()
    station = ref(station_of(clock))
    assert station() is station_of(clock)

    del clock
    gc.collect()

    assert station() is None
