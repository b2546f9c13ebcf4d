"""The simulated robots as ROS 2 nodes in a process of their own, and somebody who looks on."""

from __future__ import annotations

import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple

from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.testing.ros2.graph import RosGraph
from tests.real.ros2.simulated import Simulated

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.robots.ros2.client.rclpy_import import RosObject

ODOMETRY = "nav_msgs/msg/Odometry"
STATUS = "action_msgs/msg/GoalStatusArray"
MOVING_M_S = 0.005
KEPT = 1000
VARIABLES = ("ROS_DOMAIN_ID", "ROS_LOCALHOST_ONLY", "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOG_DIR")


class Place(NamedTuple):
    """Where a robot said it was.

    Attributes:
        at_s: Unix time at which it said so.
    """

    at_s: float
    x_m: float
    speed_m_s: float


class Onlooker:
    """Hears what the robot ``omni`` says to everybody, by the ROS topics alone.

    Attributes:
        places: Its odometry.
        accepted_s: Unix time, on the robot's clock, at which it accepted each move.
    """

    def __init__(self, robots: Simulated) -> None:
        self.robots = robots
        self.places: list[Place] = []
        self.accepted_s: list[float] = []

    async def listen(self, runtime: RosRuntime) -> None:
        """Subscribe."""
        await runtime.stream("/omni/odom", ODOMETRY, self._place, TopicQos(depth=KEPT))
        latched = TopicQos(latched=True, depth=KEPT)
        await runtime.stream("/omni/move/_action/status", STATUS, self._status, latched)

    def _place(self, message: RosObject) -> None:
        linear = message.twist.twist.linear
        speed_m_s = (linear.x**2 + linear.y**2) ** 0.5
        self.places.append(Place(time.time(), float(message.pose.pose.position.x), speed_m_s))

    def _status(self, message: RosObject) -> None:
        for status in message.status_list:
            stamp = status.goal_info.stamp
            at_s = stamp.sec + stamp.nanosec / 1e9
            if at_s not in self.accepted_s:
                self.accepted_s.append(at_s)

    @property
    def moves(self) -> bool:
        """Whether it is in motion, as far as is known."""
        return bool(self.places) and self.places[-1].speed_m_s > MOVING_M_S

    def began_to_move_s(self, after_s: float) -> float:
        """Return when it was first seen to move after a time."""
        return next(p.at_s for p in self.places if p.at_s > after_s and p.speed_m_s > MOVING_M_S)


@asynccontextmanager
async def onlooker(folder: Path, *robots: str) -> AsyncIterator[tuple[Onlooker, dict[str, str]]]:
    """Let robots run while inside; also return the environment for a gateway beside them."""
    with RosGraph(folder) as graph:
        simulation = Simulated(graph, folder, *robots)
        try:
            types = TypeRegistry([ODOMETRY, STATUS])
            opening = RosRuntime.open(types, node_name="onlooker", domain_id=graph.domain_id)
            async with await opening as runtime:
                looking = Onlooker(simulation)
                await looking.listen(runtime)
                yield looking, {name: graph.environment[name] for name in VARIABLES}
        finally:
            simulation.end()
