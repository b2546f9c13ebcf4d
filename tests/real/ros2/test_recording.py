"""A robot over ROS 2 is recorded while it drives: what the file says is what the graph saw."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from bisect import bisect
from typing import TYPE_CHECKING

import pytest

from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.messages.types import TypeRegistry
from tests.cli.running import gateway, write_config
from tests.cli.test_record import recording
from tests.features.recording.studio import read
from tests.pace import pace
from tests.real.ros2.simulated import simulated
from tests.real.ros2.test_programs import there

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.robots.ros2.client.topics import LatestMessage
    from rosic.testing.ros2.graph import RosGraph
    from tests.real.ros2.simulated import Simulated

ODOMETRY = "nav_msgs/msg/Odometry"
SPEED_M_S = 0.2
LATE_S = 0.5
"""So late may a place be recorded that the graph carried before: a sample, a busy machine."""

CONFIG = """
[[messenger]]
kind = "terminal"

[[robot]]
profile = "omni"
link = "ros2"

[[principal]]
name = "Ada"
address = "terminal:{uid}"
role = "admin"
"""


@pytest.fixture
def robots(graph: RosGraph, tmp_path: Path, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    with simulated(graph, tmp_path, "omni") as simulation:
        yield simulation


class Onlooker:
    """Somebody else on the graph, who writes down where the robot says that it is."""

    def __init__(self, latest: LatestMessage) -> None:
        self._latest = latest
        self.places: list[tuple[int, float]] = []

    async def look(self) -> None:
        while True:
            message = self._latest.message()
            if message is not None:
                self.places.append((time.time_ns(), float(message.pose.pose.position.x)))
            await asyncio.sleep(0.02)

    def between(self, since_ns: int, until_ns: int) -> tuple[float, float]:
        """Return the least and the greatest that was heard around a time."""
        first = max(0, bisect(self.places, (since_ns, 0.0)) - 1)
        last = bisect(self.places, (until_ns, 0.0)) + 1
        heard = [x_m for _, x_m in self.places[first:last]]
        return min(heard), max(heard)


@pytest.mark.limit(300)
@pytest.mark.usefixtures("robots")
async def test_what_is_recorded_is_what_the_robot_did(graph: RosGraph, tmp_path: Path) -> None:
    config, file = write_config(tmp_path, CONFIG), tmp_path / "omni.mcap"
    types = TypeRegistry([ODOMETRY])
    async with await RosRuntime.open(types, node_name="onlooker", domain_id=graph.domain_id) as ros:
        latest = await ros.latest("/omni/odom", ODOMETRY)
        await latest.newer(0, timeout_s=60 * pace())
        onlooker = Onlooker(latest)
        looking = asyncio.create_task(onlooker.look())
        with gateway(config, dict(os.environ)) as running:
            await there("omni", config)
            process = await asyncio.to_thread(recording, tmp_path, file, "--robot", "omni")
            running.say(f"omni move 1 m speed {SPEED_M_S} m/s")
            await asyncio.to_thread(running.wait_for, "done")
            process.send_signal(signal.SIGINT)
            _, err = await asyncio.to_thread(process.communicate, timeout=60 * pace())
            assert (process.returncode, err) == (0, "")
        looking.cancel()
    found = read(file.read_bytes())
    way = [(_ns(one), one["pose"]["position"]["x"]) for one in found["/omni/pose"]]
    moved_m = way[-1][1] - way[0][1]
    assert moved_m == pytest.approx(1.0, abs=0.05)
    for at_ns, x_m in way:  # each place is one that the graph carried then, or a moment before
        least, most = onlooker.between(at_ns - int(LATE_S * 1e9), at_ns + int(0.1 * 1e9))
        assert least - 0.01 <= x_m <= most + 0.01
    underway = [(at_ns, x_m) for at_ns, x_m in way if 0.2 < x_m - way[0][1] < 0.8]
    speed_m_s = (underway[-1][1] - underway[0][1]) / (underway[-1][0] - underway[0][0]) * 1e9
    assert speed_m_s == pytest.approx(SPEED_M_S, rel=0.15)
    steps = {one["stage"]: one for one in found["/omni/orders"]}
    assert _ns(steps["sent"]) < underway[0][0] < underway[-1][0] < _ns(steps["done"])
    assert steps["sent"]["arguments"]["distance"] == 1.0
    assert any(not one.get("at_rest", True) for one in found["/omni/state"])
    assert found["/omni/state"][-1]["at_rest"]


def _ns(message: dict[str, dict[str, int]]) -> int:
    stamp = message["timestamp"]
    return stamp["sec"] * 10**9 + stamp["nsec"]
