"""The contract of robots, kept by a robot that is a ROS 2 node in another process."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, ClassVar

import pytest

from rosic.system import SystemClock
from rosic.testing.robots import RobotConformance
from rosic.testing.ros2.graph import RosGraph
from tests.real.ros2.simulated import Simulated, TriedRobot, opened, shipped, simulated

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from rosic.contracts.robot import Robot
    from rosic.core.robot.skill import Argument


@pytest.fixture(scope="module")
def omni(tmp_path_factory: pytest.TempPathFactory, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    folder = tmp_path_factory.mktemp("omni")
    with RosGraph(folder) as graph, simulated(graph, folder, "omni") as simulation:
        yield simulation


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


class TestRos2(RobotConformance):
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

    simulation: Simulated

    def acted(self, robot: Robot) -> int:
        assert isinstance(robot, TriedRobot)
        return len(self.simulation.actuations("omni")) - robot.begun_before

    @pytest.fixture
    def make_robot(
        self, omni: Simulated, clock: SystemClock
    ) -> Callable[[], AbstractAsyncContextManager[Robot]]:
        self.simulation = omni

        @asynccontextmanager
        async def make() -> AsyncIterator[Robot]:
            async with opened(shipped("omni"), clock) as robot:
                robot.begun_before = len(omni.actuations("omni"))
                yield robot

        return make
