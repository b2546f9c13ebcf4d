"""The node that is there to be copied: a robot's own nodes share, read and ask by its services."""

from __future__ import annotations

import asyncio
import json
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rosic.features.robot_to_robot import RobotToRobotFeature
from tests.gateway.place import BO
from tests.real.ros2.test_among import PATIENCE_S, Brain, OnRos, brains

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.testing.ros2.graph import RosGraph

NODE = Path(__file__).parents[3] / "examples" / "among_node.py"
GOOD = (True, "")


@contextmanager
def offered(graph: RosGraph, *robots: str) -> Iterator[None]:
    """Let the node run for robots, as its own page says."""
    running = [
        graph.start(NODE, "--ros-args", "-r", f"__ns:=/{robot}", ready=None) for robot in robots
    ]
    try:
        yield
    finally:
        for process in running:
            process.process.terminate()


async def answer(brain: Brain, verb: str, rest: str, word: str) -> Any:  # noqa: ANN401 - any JSON
    brain.process.say(f"{verb} {brain.robot} {rest}")
    line = await asyncio.to_thread(brain.process.expect, f"{word} ", timeout_s=PATIENCE_S)
    return json.loads(line)


async def share(brain: Brain, **data: object) -> list[tuple[bool, str]]:
    found = await answer(brain, "share", json.dumps(data), "shared")
    return [(ok, why) for ok, why in found]


async def get(brain: Brain, *names: str) -> list[Any]:
    found: list[Any] = await answer(brain, "get", " ".join(names), "got")
    return found


async def met(brain: Brain) -> None:
    """Wait until the robot's node and ROSIC hear each other."""
    begun_s = time.monotonic()
    while (await share(brain, met=True)) != [GOOD]:
        assert time.monotonic() - begun_s < PATIENCE_S


async def test_a_plain_node_shares_reads_and_asks_and_reads_why_not(graph: RosGraph) -> None:
    async with OnRos().open() as here:
        omni, cf1 = await brains(graph)
        with offered(graph, "omni", "cf1"):
            await asyncio.gather(met(omni), met(cf1))
            await what_one_shares_another_reads(here, omni, cf1)
            await what_is_refused_says_why(here, omni, cf1)
            await a_call_for_help_is_answered(here, omni, cf1)


async def what_one_shares_another_reads(here: OnRos, omni: Brain, cf1: Brain) -> None:
    shared = {"wet": True, "count": 3, "level": 0.5, "name": "aisle 4", "path": [0.5, 1.5]}
    assert await share(omni, **shared) == [GOOD] * len(shared)
    assert await get(cf1, *(f"omni.{name}" for name in shared)) == list(shared.values())
    assert await share(omni, road='{"wet": true, "at": [1, 2]}') == [GOOD]
    shared_state = here.messaging.circle.shared_state
    [data] = [one.data for one in shared_state.of("omni") if one.topic == "road"]
    assert json.loads(data) == {"wet": True, "at": [1, 2]}
    road, age_s, at_s, newest, nothing = await get(
        cf1, "omni.road", "omni.road.age_s", "omni.road.at_s", "omni", "omni.river"
    )
    assert json.loads(road) == json.loads(newest) == {"wet": True, "at": [1, 2]}
    assert 0 <= age_s < PATIENCE_S
    assert abs(at_s + age_s - time.time()) < PATIENCE_S
    assert nothing is None


async def what_is_refused_says_why(here: OnRos, omni: Brain, cf1: Brain) -> None:
    [(ok, why)] = await share(omni, map="x" * 100_000)
    assert (ok, "at most 64 KiB" in why) == (False, True)
    [(ok, why)] = await share(omni, level=float("inf"))
    assert (ok, "finite" in why) == (False, True)
    [(ok, why)] = await share(omni, **{"No Topic": 1})
    assert (ok, "form" in why) == (False, True)
    assert await get(cf1, "nobody.road", "NO", "omni.level") == [None, None, 0.5]
    among, now_ns = here.messaging, here.clock.wall_ns()
    await among.silence("cf1", BO, now_ns + 60 * 10**9)
    [(ok, why)] = await share(cf1, wet=True)
    assert (ok, "a person did that" in why) == (False, True)
    await among.silence("cf1", BO, now_ns)


async def a_call_for_help_is_answered(here: OnRos, omni: Brain, cf1: Brain) -> None:
    ok, ident = await answer(omni, "help", "-", "helped")
    assert ok is True
    assert (
        here.gateway.features.get(RobotToRobotFeature)
        .messaging.circle.helping.book.find(ident)
        .what
        == "It cannot go on by itself."
    )
    request = await cf1.heard("help")
    assert request["id"] == ident
