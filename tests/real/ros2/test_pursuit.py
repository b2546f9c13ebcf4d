"""A stop goes on until rest is measured on a real robot, whoever's goal it is that moves it."""

from __future__ import annotations

import asyncio
import signal
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.linker.linker import Linker
from rosic.stores.stop_latch import MemoryLatch
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph
from tests.linker.policy import Policy
from tests.pace import pace
from tests.real.ros2.simulated import opened, shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.core.order import Outcome
    from rosic.core.robot.skill import Argument
    from tests.real.ros2.simulated import Simulated, TriedRobot

FAR: dict[str, Argument] = {"direction": "forward", "distance": 4.0, "speed": 0.5}


@pytest.fixture
def omni(tmp_path: Path, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    with RosGraph(tmp_path) as graph, simulated(graph, tmp_path, "omni") as simulation:
        yield simulation


def linker_of(robot: TriedRobot, clock: SystemClock, *, latched: bool = False) -> Linker:
    stops = StopRegistry(["omni"], {"omni": (1, latched)}, not_known_yet())
    return Linker({"omni": robot}, stops, MemoryLatch(), clock, clock.wall_ns, Policy(0))


async def moving(robot: TriedRobot) -> asyncio.Task[Outcome]:
    task = asyncio.create_task(robot.do("move", FAR))
    await until(lambda: robot.presence().at_rest is False or task.done())
    assert not task.done(), task
    return task


async def confirmed(linker: Linker) -> None:
    async with asyncio.timeout(60 * pace()):
        rest = await linker.pursuit.rested("omni", 1)
    assert rest is not None
    assert rest.confirmed


@pytest.mark.parametrize("known", ["an order in doubt", "a stop of before"])
async def test_after_a_crash_a_goal_that_goes_on_is_cancelled(
    omni: Simulated,  # noqa: ARG001 - it is there
    known: str,
) -> None:
    clock, profile = SystemClock(), shipped("omni")
    # Nothing but the cancelling of goals can stop it.
    bare = replace(profile, stop=None, skills={"move": profile.skills["move"]})
    async with opened(bare, SystemClock()) as before, opened(bare, clock) as robot:
        running = await moving(before)
        await until(lambda: robot.presence().at_rest is False)
        linker = linker_of(robot, clock, latched=known == "a stop of before")
        if known == "an order in doubt":
            linker.halt("omni")
        else:
            linker.watch_stopped()
        await confirmed(linker)
        assert robot.presence().at_rest
        assert (await asyncio.wait_for(running, 60 * pace())).ending is OrderEnding.CANCELLED


async def test_a_robot_that_hung_when_it_was_stopped_is_stopped_once_it_runs(
    omni: Simulated,
) -> None:
    clock, profile = SystemClock(), shipped("omni")
    short = replace(profile, link=replace(profile.link, heartbeat_s=0.5), rest_timeout_s=0.2)
    async with opened(short, clock) as robot:
        linker = linker_of(robot, clock)
        running = await moving(robot)
        omni.process.process.send_signal(signal.SIGSTOP)
        try:
            rest = await linker.stop(["omni"], "p1").rests["omni"]
        finally:
            omni.process.process.send_signal(signal.SIGCONT)
        assert not rest.confirmed
        await confirmed(linker)
        await asyncio.gather(running, return_exceptions=True)
        assert await linker.resume("omni", 2)
