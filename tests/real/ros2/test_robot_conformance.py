"""The contract of robots, kept by a robot that is a ROS 2 node in another process."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import pytest

from rosic.contracts.traffic import traffic_of
from rosic.system import SystemClock
from rosic.testing.factories import OrderBook
from rosic.testing.live_robots import LiveRobotConformance
from rosic.testing.ros2.graph import RosGraph
from tests.pace import pace
from tests.real.ros2.simulated import TriedRobot, opened, shipped

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from contextlib import AbstractAsyncContextManager

    from rosic.contracts.robot import Robot
    from rosic.core.robot.skill import Argument

NODE = Path(__file__).with_name("untrue_omni.py")


class Omni:
    """Its node, and what it has begun."""

    def __init__(self, graph: RosGraph, folder: Path) -> None:
        self._file = folder / "actuations"
        self._process = graph.start(NODE, self._file, timeout_s=120 * pace())

    def acted(self) -> int:
        return len(self._file.read_text().splitlines()) if self._file.exists() else 0

    async def told(self, line: str) -> str:
        """Tell it something; return what it answers."""
        self._process.say(line)
        return await asyncio.to_thread(self._process.expect, "ok")


@pytest.fixture(scope="module")
def omni(tmp_path_factory: pytest.TempPathFactory, interfaces: Path) -> Iterator[Omni]:  # noqa: ARG001 - built before
    folder = tmp_path_factory.mktemp("omni")
    with RosGraph(folder) as graph:
        yield Omni(graph, folder)


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


class TestRos2(LiveRobotConformance):
    short = "move"
    short_arguments: ClassVar[dict[str, Argument]] = {
        "direction": "forward",
        "distance": 0.02,
        "speed": 0.25,
    }
    long = "move"
    long_arguments: ClassVar[dict[str, Argument]] = {
        "direction": "back",
        "distance": 2.0,
        "speed": 0.25,
    }
    live = "drive"
    live_values: ClassVar[dict[str, float]] = {"linear": 0.2, "angular": 0.1}

    omni: Omni

    def acted(self, robot: Robot) -> int:
        assert isinstance(robot, TriedRobot)
        return self.omni.acted() - robot.begun_before

    async def moves(self, robot: Robot) -> bool:  # noqa: ARG002 - there is one
        return await self.omni.told("moves") == "True"

    async def fall_silent(self, robot: Robot) -> None:  # noqa: ARG002 - there is one
        await self.omni.told("silent")

    async def ignore_orders(self, robot: Robot) -> None:  # noqa: ARG002 - there is one
        await self.omni.told("ignore")

    async def say_progress(self, robot: Robot, fraction: float) -> None:  # noqa: ARG002
        await self.omni.told(f"at {fraction}")

    async def say_done(self, robot: Robot) -> None:  # noqa: ARG002 - there is one
        await self.omni.told("done")

    @pytest.fixture
    def make_robot(
        self, omni: Omni, clock: SystemClock
    ) -> Callable[[], AbstractAsyncContextManager[Robot]]:
        self.omni = omni

        @asynccontextmanager
        async def make() -> AsyncIterator[Robot]:
            await omni.told("reset")
            async with opened(shipped("omni"), clock) as robot:
                robot.begun_before = omni.acted()
                yield robot

        return make

    async def test_what_passes_its_topics_and_goals_is_counted(
        self, make_robot: Callable[[], AbstractAsyncContextManager[Robot]], clock: SystemClock
    ) -> None:
        async with make_robot() as robot:
            before = traffic_of(robot)
            assert before is not None
            order = OrderBook(robot.profile, clock).order(self.short, self.short_arguments)
            await asyncio.wait_for(robot.execute(order, lambda _report: None), self.bound_s)
            after = traffic_of(robot)
            assert after is not None
            assert after.sent > before.sent
            assert after.received > before.received + 2  # accepted, feedback, result, telemetry
            assert after.received_bytes > before.received_bytes
