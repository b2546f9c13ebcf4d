"""What a robot said once, before the gateway came, and keeps for whoever comes later."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.app.setup.discovery import listened
from rosic.app.setup.profile_draft import BATTERY, SeenRobot
from rosic.core.messages import status_line
from rosic.robots.ros2.client.graph import GraphSnapshot, GraphTopic, wait_for
from rosic.robots.ros2.profile import AtRest, Ros2Telemetry
from rosic.robots.ros2.telemetry import Measurements
from rosic.system import SystemClock
from tests.pace import pace
from tests.real.ros2.simulated import opened, profile_of, until

if TYPE_CHECKING:
    from rosic.core.robot.profile import Presence
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.profile import Ros2Profile
    from rosic.testing.ros2.graph import RosGraph

NODE = Path(__file__).with_name("latched_node.py")
OLD_S = 2.0


def profile(namespace: str = "/foreign") -> Ros2Profile:
    return profile_of(
        id="foreign",
        title="Foreign",
        link={"kind": "ros2", "namespace": namespace, "heartbeat_s": 1.0},
        telemetry={
            "battery": {
                "topic": "/foreign/power",
                "type": BATTERY,
                "field": "percentage",
                "unit": "%",
            }
        },
    )


def resting() -> Ros2Profile:
    rest = AtRest(
        topic="/foreign/joints", type="sensor_msgs/msg/JointState", field="velocity", below=0.005
    )
    return replace(profile(), at_rest=rest)


def said(told: Ros2Profile, presence: Presence) -> str:
    return status_line(told, presence, holder="", stopped_by=None, waiting=0)


def charge(presence: Presence) -> int | None:
    value = presence.values.get("battery")
    return round(value) if isinstance(value, float) else None


async def test_what_was_said_before_the_gateway_came_is_shown_with_its_age(
    graph: RosGraph,
) -> None:
    graph.start(NODE, "0.05", "often")
    await asyncio.sleep(OLD_S)
    async with opened(resting(), SystemClock()) as robot:
        await until(lambda: charge(robot.presence()) == 5)
        presence = robot.presence()
        assert presence.ages_s["battery"] > OLD_S, "nobody heard it just now"
        assert (presence.online, presence.at_rest) == (True, True)
        assert (presence.age_s or 9.0) < 1.0
        assert robot._measured.restarts == 0, "what was kept says nothing of who sends"


async def test_a_robot_that_comes_later_or_anew_is_heard_likewise(graph: RosGraph) -> None:
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().online is False)
        first = await asyncio.to_thread(graph.start, NODE, "0.05")
        await until(lambda: charge(robot.presence()) == 5)
        await until(lambda: robot.presence().online is True)
        await asyncio.sleep(OLD_S)
        assert robot.presence().ages_s["battery"] > OLD_S, "it came when it was said, and not since"
        await asyncio.to_thread(first.kill)
        await asyncio.to_thread(graph.start, NODE, "0.9")
        await until(lambda: charge(robot.presence()) == 90)


async def test_who_says_everything_once_is_there_for_as_long_as_the_graph_shows_it(
    graph: RosGraph,
) -> None:
    """Else it would be missed a second after whatever it says, though it promised no more."""
    node = graph.start(NODE, "0.05")
    for told in (profile(), profile("/")):
        async with opened(told, SystemClock()) as robot:
            await until(lambda: charge(robot.presence()) == 5)
            await until(lambda: robot.presence().online is True)
            assert robot.presence().age_s is None, "it was not heard since"
            node.say("0.04")
            await until(lambda: charge(robot.presence()) == 4)
            await asyncio.sleep(1.5)
            assert robot.presence().online is True
            assert said(told, robot.presence()) == "Foreign: free · battery 4 %"
            node.say("0.05")
            await until(lambda: charge(robot.presence()) == 5)


async def test_who_keeps_what_it_says_again_and_again_is_missed_when_it_falls_silent(
    graph: RosGraph,
) -> None:
    node = graph.start(NODE, "0.05")
    async with opened(profile(), SystemClock()) as robot:
        await until(lambda: robot.presence().online is True)

        async def speaks() -> None:
            while robot.presence().age_s is None:
                node.say("0.05")
                await asyncio.sleep(0.2)

        await asyncio.wait_for(speaks(), 60 * pace())
        await until(lambda: robot.presence().online is False)


async def test_one_that_keeps_nothing_is_missed_though_another_that_does_is_left(
    runtime: RosRuntime,
) -> None:
    counts = Ros2Telemetry(topic="/foreign/count", type="std_msgs/msg/Int32", field="data")
    told = profile()
    told = replace(told, telemetry={**told.telemetry, "count": counts})
    keeps = GraphTopic("/foreign/power", (BATTERY,), 1, 0, latched=1)
    forgets = GraphTopic("/foreign/count", ("std_msgs/msg/Int32",), 1, 0)
    measured = Measurements(told, SystemClock())
    await measured.open(runtime)

    def look(*topics: GraphTopic) -> bool:
        measured.look(GraphSnapshot((), topics, (), (), complete=True))
        return measured.tells_presence

    assert look(), "nobody is there"
    assert not look(keeps), "it may be silent for as long as nothing changes"
    assert look(keeps, forgets)
    assert look(keeps), "whoever spoke is gone"
    await measured.close()


async def test_a_draft_knows_a_battery_in_per_cent_that_was_said_once(
    runtime: RosRuntime, graph: RosGraph
) -> None:
    await asyncio.to_thread(graph.start, NODE, "87")
    seen = SeenRobot("/foreign", {}, {"/foreign/power": BATTERY}, {}, {})
    heard = await listened(runtime, SystemClock(), seen)
    assert heard.reported.per_cent == {"/foreign/power"}


async def test_the_graph_tells_who_keeps_what_it_says(runtime: RosRuntime, graph: RosGraph) -> None:
    await asyncio.to_thread(graph.start, NODE, "0.05", "often")
    seen = await wait_for(
        runtime, lambda found: len(found.topics) == 2, namespace="/foreign", timeout_s=60
    )
    assert {topic.name: topic.latched for topic in seen.topics} == {
        "/foreign/joints": 0,
        "/foreign/power": 1,
    }
