"""The simulated robots as ROS 2 nodes: what they offer, when they fail, and without a link."""

from __future__ import annotations

import asyncio
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order import OrderEnding
from rosic.errors import ConfigurationError
from rosic.robots.ros2.bindings.parameters import SET_PARAMETERS, request, service_of
from rosic.robots.ros2.client.graph import snapshot
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.robots.ros2.profile import Ros2Profile, ros2_profile
from rosic.system import SystemClock
from rosic.testing.ros2.graph import RosGraph
from rosic_sim.ros2.endpoints import ACTIONS, MODELS
from rosic_sim.ros2.simulation import main
from tests.pace import pace, patience
from tests.real.ros2.simulated import (
    SIMULATION,
    Simulated,
    opened,
    set_fault,
    shipped,
    simulated,
    until,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from rosic.robots.ros2.client.topics import LatestMessage

DRIVER = Path(__file__).with_name("driver.py")
ROOT = Path(__file__).parents[3]
ODOMETRY = "nav_msgs/msg/Odometry"


pytestmark = pytest.mark.usefixtures("robots")


@pytest.fixture
def clock() -> SystemClock:
    return SystemClock()


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    """All six, in one process."""
    folder = tmp_path_factory.mktemp("robots")
    with RosGraph(folder) as graph, simulated(graph, folder) as simulation:
        yield simulation


@pytest.fixture
async def onlooker(robots: Simulated) -> AsyncIterator[RosRuntime]:
    types = TypeRegistry([ODOMETRY, SET_PARAMETERS, "sensor_msgs/msg/JointState"])
    domain = robots.graph.domain_id
    async with await RosRuntime.open(types, node_name="onlooker", domain_id=domain) as runtime:
        yield runtime


# ---- what they offer ----


def simulated_profiles() -> list[Ros2Profile]:
    found = (ros2_profile(load_profile(path)) for path in shipped_profiles().values())
    return [profile for profile in found if profile.link.model]


def test_every_shipped_robot_has_its_machine() -> None:
    assert {p.id: p.link.model for p in simulated_profiles()} == dict(MODELS)
    for profile in simulated_profiles():
        bound = {
            name: skill.action.type.rpartition("/")[2]
            for name, skill in profile.skills.items()
            if skill.action is not None
        }
        assert bound == ACTIONS[profile.link.model]


async def test_everything_the_shipped_profiles_bind_is_on_the_graph(
    robots: Simulated, onlooker: RosRuntime
) -> None:
    assert "ready omni kuka1 yumi cf1 cf2 cf3" in robots.process.lines
    wanted = {name for profile in simulated_profiles() for name in bound_names(profile)}
    async with asyncio.timeout(60 * pace()):
        while wanted - await offered(onlooker):  # noqa: ASYNC110 - the graph tells nobody
            await asyncio.sleep(0.05)


def bound_names(profile: Ros2Profile) -> Iterator[tuple[str, str]]:
    for skill in profile.skills.values():
        if skill.action is not None:
            yield skill.action.name, skill.action.type
        if skill.topic is not None:
            yield skill.topic.name, skill.topic.type
    assert profile.stop is not None
    yield profile.stop.service, profile.stop.type
    assert profile.at_rest is not None
    yield profile.at_rest.topic, profile.at_rest.type
    for entry in profile.telemetry.values():
        yield entry.topic, entry.type


async def offered(onlooker: RosRuntime) -> set[tuple[str, str]]:
    seen = await snapshot(onlooker)
    offers = (*seen.services, *seen.actions)
    topics = {(topic.name, topic.types[0]) for topic in seen.topics}
    return topics | {(offer.name, offer.types[0]) for offer in offers}


async def test_telemetry_comes_at_least_five_times_a_second_at_rest(onlooker: RosRuntime) -> None:
    odometry = await onlooker.latest("/cf1/odom", ODOMETRY)
    await odometry.newer(0, timeout_s=30)
    begun, before = time.monotonic(), odometry.received
    await odometry.newer(before + 10, timeout_s=30)
    assert (odometry.received - before) / (time.monotonic() - begun) >= 5


def test_it_ends_when_it_is_told_to(graph: RosGraph, tmp_path: Path) -> None:
    for number in (signal.SIGTERM, signal.SIGINT):
        simulation = Simulated(graph, tmp_path, "omni", "kuka1")
        assert "ready omni kuka1" in simulation.process.lines
        begun = time.monotonic()
        simulation.process.process.send_signal(number)
        assert simulation.process.process.wait(60) == 0
        assert time.monotonic() - begun < 2.0 * patience()
        simulation.process.stop()


def test_a_robot_that_does_not_exist_is_named() -> None:
    with pytest.raises(
        ConfigurationError, match=r"no simulated robot called 'kuka'; did you mean kuka1"
    ):
        main(["kuka"])
    with pytest.raises(ConfigurationError, match=r"called 'tractor'; there are cf1, cf2"):
        main(["tractor"])
    done = subprocess.run(  # noqa: S603 - our own module
        [sys.executable, "-m", SIMULATION, "omny"],
        capture_output=True,
        text=True,
        timeout=120 * pace(),
        check=False,
    )
    assert done.returncode == 2
    assert "did you mean omni?" in done.stderr


# ---- what goes wrong ----


async def test_a_grasp_without_an_object_fails(onlooker: RosRuntime, clock: SystemClock) -> None:
    await set_fault(onlooker, "kuka1", "object", value=False)
    async with opened(shipped("kuka1"), clock) as kuka:
        outcome = await kuka.do("grasp", {"force": 15.0})
        assert outcome.ending is OrderEnding.FAILED
        assert "nothing between the fingers" in outcome.note
        await set_fault(onlooker, "kuka1", "object", value=True)
        outcome = await kuka.do("grasp", {"force": 15.0})
        assert outcome.ending is OrderEnding.DONE, outcome
        assert kuka.presence().values == {}, "it runs on mains"


async def test_one_arm_that_fails_stops_both(onlooker: RosRuntime, clock: SystemClock) -> None:
    joints = await heard(onlooker, "/yumi/joint_states", "sensor_msgs/msg/JointState")
    async with opened(shipped("yumi"), clock) as yumi:
        running = asyncio.create_task(yumi.do("handover"))
        await until(lambda: yumi.presence().at_rest is False)
        await set_fault(onlooker, "yumi", "left_arm", value=False)
        outcome = await asyncio.wait_for(running, 60 * pace())
        assert outcome.ending is OrderEnding.FAILED, outcome
        await until(lambda: yumi.presence().at_rest is True)
    message = joints.message()
    assert message is not None
    assert len(message.name) == 16
    assert max(map(abs, message.velocity)) < 0.005
    await set_fault(onlooker, "yumi", "left_arm", value=True)


async def test_an_empty_battery_is_a_reason(
    robots: Simulated, onlooker: RosRuntime, clock: SystemClock
) -> None:
    before = len(robots.actuations("cf3"))
    await set_fault(onlooker, "cf3", "battery", 0.18)
    async with opened(shipped("cf3"), clock) as drone:
        await until(
            lambda: drone.presence().values.get("battery", 100.0) == pytest.approx(18.0, abs=0.1)
        )
        outcome = await drone.do("takeoff", {"height": 1.0})
    await set_fault(onlooker, "cf3", "battery", 1.0)
    assert outcome.ending is OrderEnding.REFUSED
    assert outcome.note in {f"battery {p} %: too low. Nothing was done." for p in (17, 18)}
    assert len(robots.actuations("cf3")) == before


async def test_a_battery_has_no_more_than_it_can_hold(onlooker: RosRuntime) -> None:
    link = await onlooker.service(service_of("/omni/machine"), SET_PARAMETERS)
    for value in (1.5, -0.1):
        answer = await link.call(request({"battery": value}), timeout_s=30, found_within_s=30)
        assert answer.results[0].reason == "a battery is a number from 0.0 to 1.0"


# ---- without a link ----


async def test_a_robot_whose_gateway_is_killed_comes_to_rest_by_itself(
    robots: Simulated, onlooker: RosRuntime
) -> None:
    before = len(robots.actuations("omni"))
    odometry = await heard(onlooker, "/omni/odom", ODOMETRY)
    driver = robots.graph.start(
        DRIVER, "omni", "move", "direction=forward", "distance=5", "speed=0.5", python_path=[ROOT]
    )
    await until(lambda: speed_m_s(odometry) > 0.4)
    driver.kill()
    at = x_m(odometry)
    await until(lambda: speed_m_s(odometry) <= 0.005)
    # How far it came says how long it took, whatever the machine was busy with meanwhile.
    coasts_m = 0.5 * robots.link_lost_s
    assert 0.2 < x_m(odometry) - at < coasts_m + 0.5, "half a metre a second, and braking"
    await odometry.newer(odometry.received + 10, timeout_s=30)
    assert speed_m_s(odometry) <= 0.005
    assert len(robots.actuations("omni")) == before + 1


async def test_a_drone_whose_gateway_is_killed_lands(
    robots: Simulated, onlooker: RosRuntime
) -> None:
    odometry = await heard(onlooker, "/cf1/odom", ODOMETRY)
    driver = robots.graph.start(DRIVER, "cf1", "takeoff", "height=0.5", python_path=[ROOT])
    await asyncio.to_thread(driver.expect, "ended done")
    await until(lambda: z_m(odometry) == pytest.approx(0.5, abs=0.05))
    driver.kill()
    await until(lambda: z_m(odometry) < 0.02)


async def test_a_cut_link_holds_and_is_found_again(
    onlooker: RosRuntime, clock: SystemClock
) -> None:
    async with opened(shipped("omni"), clock) as omni:
        running = asyncio.create_task(
            omni.do("move", {"direction": "back", "distance": 4.0, "speed": 0.5})
        )
        await until(lambda: omni.presence().at_rest is False)
        await set_fault(onlooker, "omni", "link", value=False)
        await until(lambda: omni.presence().online is False)
        await set_fault(onlooker, "omni", "link", value=True)
        outcome = await asyncio.wait_for(running, 60 * pace())
        assert outcome.ending is OrderEnding.FAILED
        assert outcome.note.startswith("link lost, holding")
        await until(lambda: omni.presence().online is True)
        assert omni.presence().at_rest is True


async def heard(onlooker: RosRuntime, topic: str, type_name: str) -> LatestMessage:
    """Subscribe, and wait for the first: discovery can take seconds."""
    latest = await onlooker.latest(topic, type_name)
    await latest.newer(0, timeout_s=60)
    return latest


def x_m(odometry: LatestMessage) -> float:
    message = odometry.message()
    return 0.0 if message is None else float(message.pose.pose.position.x)


def z_m(odometry: LatestMessage) -> float:
    message = odometry.message()
    return -1.0 if message is None else float(message.pose.pose.position.z)


def speed_m_s(odometry: LatestMessage) -> float:
    message = odometry.message()
    return 0.0 if message is None else abs(float(message.twist.twist.linear.x))
