"""Three drones: a common start, their separation, and one lost: all land."""

from __future__ import annotations

import asyncio
from functools import partial
from itertools import combinations
from math import hypot
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding, Outcome
from rosic.robots.ros2.bindings.parameters import SET_PARAMETERS
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.system import SystemClock
from rosic_sim.robots.machines.swarm import APART_M
from tests.pace import patience
from tests.real.ros2.simulated import TriedRobot, opened, set_fault, shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.core.robot.skill import Argument
    from rosic.robots.ros2.client.topics import LatestMessage
    from rosic.testing.ros2.graph import RosGraph

NAMES = ("cf1", "cf2", "cf3")
ODOMETRY = "nav_msgs/msg/Odometry"
TOGETHER_S = 1.0
APART_S = 0.2


class Room:
    """What somebody sees who stands beside them: where each is, and how near they came."""

    def __init__(self) -> None:
        self.places: dict[str, tuple[float, float, float]] = {}
        self.nearest_m = float("inf")
        self.took_off_s: dict[str, float] = {}
        self.watched: tuple[str, str, float] | None = None
        self.gaps: list[float] = []

    def gap(self, one: str, other: str) -> float:
        here, there = self.places[one], self.places[other]
        return hypot(here[0] - there[0], here[1] - there[1])

    def see(self, name: str, odometry: LatestMessage) -> None:
        message = odometry.message()
        assert message is not None
        place = message.pose.pose.position
        self.places[name] = (place.x, place.y, place.z)
        if place.z > 0.003 and name not in self.took_off_s:
            stamp = message.header.stamp
            self.took_off_s[name] = stamp.sec + stamp.nanosec / 1e9
        if self.watched is not None and name == self.watched[1]:
            leader, follower, from_x_m = self.watched
            if self.places[leader][0] > from_x_m:
                self.gaps.append(self.gap(leader, follower))
        for one, other in combinations(self.places.values(), 2):
            self.nearest_m = min(self.nearest_m, hypot(one[0] - other[0], one[1] - other[1]))

    def on_the_ground(self, *names: str) -> bool:
        return all(self.places[name][2] < 0.02 for name in names)


pytestmark = pytest.mark.usefixtures("interfaces")


async def test_a_drone_that_hovers_holds_its_place_and_is_not_at_rest(
    graph: RosGraph, tmp_path: Path
) -> None:
    with simulated(graph, tmp_path, "cf1"):
        async with opened(shipped("cf1"), SystemClock()) as cf1:
            await until(lambda: cf1.presence().at_rest is True)
            assert (await cf1.do("takeoff", {"height": 0.5})).ending is OrderEnding.DONE
            await until(lambda: cf1.presence().holds is True)
            assert cf1.presence().at_rest is False
            assert not cf1.presence().moves
            flying = asyncio.create_task(cf1.do("goto", {"x": 1.0, "y": 0.0, "z": 0.5}))
            await until(lambda: cf1.presence().moves)
            assert (await flying).ending is OrderEnding.DONE
            await until(lambda: not cf1.presence().moves)


@pytest.fixture
async def room(graph: RosGraph) -> AsyncIterator[Room]:
    room = Room()
    types = TypeRegistry([ODOMETRY])
    domain = graph.domain_id
    async with await RosRuntime.open(types, node_name="onlooker", domain_id=domain) as runtime:
        for name in NAMES:
            await runtime.latest(f"/{name}/odom", ODOMETRY, on_new=partial(room.see, name))
        yield room


@pytest.fixture
async def saboteur(graph: RosGraph) -> AsyncIterator[RosRuntime]:
    types, domain = TypeRegistry([SET_PARAMETERS]), graph.domain_id
    async with await RosRuntime.open(types, node_name="saboteur", domain_id=domain) as runtime:
        yield runtime


async def together(
    drones: list[TriedRobot], skill: str, arguments: dict[str, Argument]
) -> list[Outcome]:
    """Order the same of all, with a common start; the orders reach them one after another."""
    start_ns = SystemClock().monotonic_ns() + int(TOGETHER_S * patience() * 1e9)
    tasks = []
    for drone in drones:
        order = replace(drone.order(skill, arguments), start_ns=start_ns)
        tasks.append(asyncio.create_task(drone.execute(order, lambda _report: None)))
        await asyncio.sleep(APART_S)
    return await asyncio.gather(*tasks)


@pytest.mark.limit(240)
async def test_three_drones_fly_together_and_one_lost_all_land(
    graph: RosGraph, tmp_path: Path, room: Room
) -> None:
    """Each in a process of its own: what they know of each other comes over the topic."""
    clock = SystemClock()
    with (
        simulated(graph, tmp_path, "cf1") as lost,
        simulated(graph, tmp_path, "cf2"),
        simulated(graph, tmp_path, "cf3"),
    ):
        async with (
            opened(shipped("cf1"), clock) as cf1,
            opened(shipped("cf2"), clock) as cf2,
            opened(shipped("cf3"), clock) as cf3,
        ):
            drones = [cf1, cf2, cf3]
            await until(lambda: len(room.places) == 3)
            outcomes = await together(drones, "takeoff", {"height": 1.0})
            assert [o.ending for o in outcomes] == [OrderEnding.DONE] * 3, outcomes
            await until(lambda: all(abs(z - 1.0) < 0.05 for _, _, z in room.places.values()))
            starts = room.took_off_s.values()
            assert max(starts) - min(starts) < 0.1

            outcomes = await together(drones, "formation", {"shape": "triangle", "spacing": 0.8})
            assert [o.ending for o in outcomes] == [OrderEnding.DONE] * 3, outcomes
            assert room.nearest_m >= APART_M

            lost.process.kill()
            await until(lambda: room.on_the_ground("cf2", "cf3"))
            assert room.places["cf1"][2] > 0.5, "the last that was seen of it"
            assert room.nearest_m >= APART_M
            await until(lambda: cf2.presence().at_rest is True)


@pytest.mark.limit(240)
async def test_a_drone_that_goes_silent_makes_the_others_land_too(
    graph: RosGraph, tmp_path: Path, room: Room, saboteur: RosRuntime
) -> None:
    """All in one process: the same rule, and a group stop that ends on the ground."""
    clock = SystemClock()
    with simulated(graph, tmp_path, *NAMES):
        async with (
            opened(shipped("cf1"), clock) as cf1,
            opened(shipped("cf2"), clock) as cf2,
            opened(shipped("cf3"), clock) as cf3,
        ):
            await until(lambda: len(room.places) == 3)
            outcomes = await together([cf1, cf2, cf3], "takeoff", {"height": 0.6})
            assert [o.ending for o in outcomes] == [OrderEnding.DONE] * 3, outcomes
            await set_fault(saboteur, "cf3", "link", value=False)
            await until(lambda: room.on_the_ground("cf1", "cf2"))
            assert room.nearest_m >= APART_M


@pytest.mark.limit(240)
async def test_one_drone_keeps_behind_another_and_ends_with_it(
    graph: RosGraph, tmp_path: Path, room: Room
) -> None:
    """Each in a process of its own: it follows what the other says over the topic."""
    clock = SystemClock()
    with simulated(graph, tmp_path, "cf1"), simulated(graph, tmp_path, "cf2"):
        async with opened(shipped("cf1"), clock) as cf1, opened(shipped("cf2"), clock) as cf2:
            await until(lambda: {"cf1", "cf2"} <= set(room.places))
            outcomes = await together([cf1, cf2], "takeoff", {"height": 1.0})
            assert [o.ending for o in outcomes] == [OrderEnding.DONE] * 2, outcomes
            start = await cf1.do("goto", {"x": -1.5, "y": 1.5, "z": 1.0})
            assert start.ending is OrderEnding.DONE
            follow: dict[str, Argument] = {"leader": "cf1", "distance": 1.2, "bearing": 0.0}
            following = asyncio.create_task(cf2.do("follow", follow))
            await until(lambda: abs(room.gap("cf1", "cf2") - 1.2) < 0.05)
            room.watched = ("cf1", "cf2", 1.0)
            there = await cf1.do("goto", {"x": 2.8, "y": 1.5, "z": 1.0})
            assert there.ending is OrderEnding.DONE
            outcome = await following
            assert outcome.ending is OrderEnding.DONE, outcome
            # The last centimetres depend on how late this machine lets them hear each other.
            assert outcome.note.startswith("followed cf1, "), outcome
            assert float(outcome.note.split()[2]) == pytest.approx(1.2, abs=0.05), outcome
            assert len(room.gaps) > 5, "seen while both flew"
            assert max(abs(gap - 1.2) for gap in room.gaps) < 0.4, room.gaps
            assert room.gap("cf1", "cf2") == pytest.approx(1.2, abs=0.05)
            assert room.nearest_m >= APART_M
