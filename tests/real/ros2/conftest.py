"""A graph for each test, a robot's side on it, and the gateway's side on it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.interfaces.cache import ensure_built, make_importable
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.testing.ros2.graph import RosGraph, RosProcess, why_missing

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

PEER = Path(__file__).with_name("peer.py")
TYPES = (
    "geometry_msgs/msg/Twist",
    "geometry_msgs/msg/PoseStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "nav_msgs/msg/Odometry",
    "rcl_interfaces/srv/SetParameters",
    "rosic_interfaces/action/Move",
    "rosic_interfaces/action/Perform",
    "rosic_interfaces/msg/SwarmState",
    "sensor_msgs/msg/BatteryState",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/JointState",
    "std_msgs/msg/Byte",
    "std_msgs/msg/Float32",
    "std_msgs/msg/Int32",
    "std_msgs/msg/String",
    "std_msgs/msg/UInt8",
    "std_srvs/srv/SetBool",
    "std_srvs/srv/Trigger",
    "unique_identifier_msgs/msg/UUID",
)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave time to build interfaces: whichever test is first to need them waits for it."""
    for item in items:
        if "interfaces" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.limit(240))


@pytest.fixture(autouse=True, scope="session")
def _ros_is_here() -> None:
    sentence = why_missing()
    if sentence:
        pytest.skip(sentence)


@pytest.fixture(scope="session")
def interfaces() -> Path:
    """Where `rosic_interfaces` can be imported from, here and in other processes."""
    make_importable()
    return ensure_built()


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[RosGraph]:
    with RosGraph(tmp_path) as graph:
        yield graph


@pytest.fixture
def peer(graph: RosGraph) -> RosProcess:
    """The robot's side, without actions."""
    return graph.start(PEER)


@pytest.fixture
def mover(graph: RosGraph, interfaces: Path) -> RosProcess:
    """The robot's side, with the action ``/omni/move``."""
    return graph.start(PEER, interfaces)


@pytest.fixture
def types() -> TypeRegistry:
    return TypeRegistry(TYPES)


@pytest.fixture
async def runtime(graph: RosGraph, types: TypeRegistry) -> AsyncIterator[RosRuntime]:
    async with await RosRuntime.open(types, domain_id=graph.domain_id) as runtime:
        yield runtime
