"""Robots on a real graph that come to a gateway which runs: they move, stop, and speak."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.messages.types import TypeRegistry
from tests.cli.running import Gateway, gateway, rosic, write_config
from tests.cli.test_robot_add import QUICK
from tests.pace import pace
from tests.real.ros2.simulated import simulated, until
from tests.real.ros2.test_among import PEER, Brain

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.topics import LatestMessage
    from rosic.testing.ros2.graph import RosGraph
    from tests.cli.running import Ran
    from tests.real.ros2.simulated import Simulated

ODOMETRY = "nav_msgs/msg/Odometry"
MOVING_M_S = 0.005
WITHIN_M = 0.02
NOBODY_HAS_THE_TYPE = """
id: odd
link: { kind: ros2, namespace: /odd }
stop: { service: /odd/stop, type: odd_interfaces/srv/Halt }
skills:
  sing: { class: task, service: { name: /odd/sing, type: odd_interfaces/srv/Sing } }
"""

pytestmark = pytest.mark.limit(300)


class Watched:
    """What a robot's odometry says to anybody on the graph."""

    def __init__(self, latest: LatestMessage) -> None:
        self._latest = latest

    def at_m(self) -> tuple[float, float]:
        """Return how far forward and how high it is."""
        place = self._newest().pose.pose.position
        return float(place.x), float(place.z)

    def moves(self) -> bool:
        linear = self._newest().twist.twist.linear
        return bool(max(abs(linear.x), abs(linear.y), abs(linear.z)) > MOVING_M_S)

    def _newest(self) -> RosObject:
        message = self._latest.message()
        assert message is not None
        return message


async def watched(onlooker: RosRuntime, robot: str) -> Watched:
    latest = await onlooker.latest(f"/{robot}/odom", ODOMETRY)
    await latest.newer(0, timeout_s=60)
    return Watched(latest)


async def add(config: Path, robot: str | Path, *more: str) -> Ran:
    """Ask for it from a process of its own."""
    asked = ("robot", "add", "-c", config, robot, *more)
    return await asyncio.to_thread(rosic, *asked, env=os.environ)


async def hears(running: Gateway, text: str, *, line: str = "") -> None:
    """Say a line, and wait for what is said after it."""
    seen = len(running.out())
    if line:
        running.say(line)
    begun_s = time.monotonic()
    while text not in running.out()[seen:]:
        assert running.process.poll() is None, running.err()
        assert time.monotonic() - begun_s < 60 * pace(), (
            f"no {text!r} in {running.out()}{running.err()}"
        )
        await asyncio.sleep(0.02)


class Scene(NamedTuple):
    """Two robots on a graph, and a configuration that names neither."""

    robots: Simulated
    omni: Watched
    cf1: Watched
    config: Path


@asynccontextmanager
async def scene(graph: RosGraph, folder: Path) -> AsyncIterator[Scene]:
    config = write_config(folder, QUICK.replace('profile = "omni"', 'profile = "yumi"'))
    types, domain = TypeRegistry([ODOMETRY]), graph.domain_id
    with simulated(graph, folder, "omni", "cf1") as robots:
        async with await RosRuntime.open(types, node_name="onlooker", domain_id=domain) as looking:
            omni, cf1 = await watched(looking, "omni"), await watched(looking, "cf1")
            yield Scene(robots, omni, cf1, config)


async def test_they_move_and_stop_as_if_they_had_been_there_from_the_start(
    graph: RosGraph, interfaces: Path, tmp_path: Path
) -> None:
    assert interfaces.name
    async with scene(graph, tmp_path) as here:
        with gateway(here.config, os.environ) as running:
            await one_comes_and_moves(here, running)
            await another_comes_while_it_drives(here, running)
            await what_cannot_come_changes_nothing(here, tmp_path)
            await its_own_nodes_are_heard(graph, running)
            await a_stop_reaches_both(here, running)
            running.process.send_signal(signal.SIGKILL)
            running.process.wait(60)
        with gateway(here.config, os.environ) as running:
            await it_is_there_after_a_kill(here, running)


async def one_comes_and_moves(here: Scene, running: Gateway) -> None:
    """It is the first on the graph: the gateway's node opens now."""
    added = await add(here.config, "omni", "--role", "operator")
    assert (added.status, added.err) == (0, "")
    assert added.out.startswith("omni is here now.\n")
    await hears(running, "moved 0.50 m forward", line="omni move forward 0.5 m speed 0.5 m/s")
    assert here.omni.at_m()[0] == pytest.approx(0.5, abs=WITHIN_M)
    assert len(here.robots.actuations("omni")) == 1


async def another_comes_while_it_drives(here: Scene, running: Gateway) -> None:
    """It shares that node, and brings types that were not known there."""
    running.say("omni move back 4 m speed 0.1 m/s")
    await until(here.omni.moves)
    added = await add(here.config, "cf1")
    assert (added.status, added.err) == (0, "")
    assert here.omni.moves(), "the newcomer disturbed it"
    await hears(running, "Crazyflie 1: done", line="cf1 takeoff 0.5 m")
    assert here.cf1.at_m()[1] == pytest.approx(0.5, abs=WITHIN_M)


async def what_cannot_come_changes_nothing(here: Scene, folder: Path) -> None:
    odd = folder / "odd.yaml"
    odd.write_text(NOBODY_HAS_THE_TYPE)
    refused = await add(here.config, odd)
    assert (refused.status, refused.out) == (1, "")
    assert "odd_interfaces" in refused.err
    assert "Nothing was changed." in refused.err


async def its_own_nodes_are_heard(graph: RosGraph, running: Gateway) -> None:
    """It was added with a role, so it is somebody among the robots."""
    brain = Brain(await asyncio.to_thread(graph.start, PEER, "omni"), "omni")
    await brain.do("meet")
    await brain.say("share", topic="road", data={"wet": True}, ref="s")
    assert (await brain.heard("result"))["ok"] is True
    await hears(running, '"wet": true', line="/shared omni road")


async def a_stop_reaches_both(here: Scene, running: Gateway) -> None:
    running.say("cf1 goto x=3 y=0 z=0.5")
    await until(here.cf1.moves)
    assert here.omni.moves()
    await hears(running, "STOP: ", line="stop")
    assert "not confirmed" not in running.out().rpartition("STOP: ")[2]
    await until(lambda: not here.omni.moves() and here.cf1.at_m()[1] < WITHIN_M)
    assert here.omni.at_m()[0] > -3.0, "it drove to the end"
    await hears(running, "omni is stopped", line="omni move 1 m")


async def it_is_there_after_a_kill(here: Scene, running: Gateway) -> None:
    rests_m, before = here.omni.at_m()[0], here.robots.actuations("omni")
    assert "4 robots" in running.err()
    await hears(running, "omni is stopped", line="omni move 1 m")
    assert here.robots.actuations("omni") == before
    await hears(running, "omni is ready again", line="resume omni")
    await hears(running, "moved 0.30 m forward", line="omni move forward 0.3 m speed 0.5 m/s")
    assert here.omni.at_m()[0] - rests_m == pytest.approx(0.3, abs=WITHIN_M)
