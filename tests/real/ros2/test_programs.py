"""The official MCP client drives robots over ROS 2: the simulated ones, as nodes of their own."""

from __future__ import annotations

import os
import re
from typing import TYPE_CHECKING

import anyio
import pytest

from tests.cli.programs import Progress, at_rest, client, free, key_of, number_of, resumed, said
from tests.cli.running import gateway, write_config
from tests.pace import pace
from tests.real.ros2.simulated import simulated

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from mcp import ClientSession
    from mcp_types import CallToolResult

    from rosic.testing.ros2.graph import RosGraph
    from tests.cli.running import Gateway
    from tests.real.ros2.simulated import Simulated

CONFIG = """
[gateway]
lease_idle_s = 1

[limits]
burst = 12
per_s = 0.01

[[messenger]]
kind = "terminal"

[[messenger]]
kind = "mcp"

[[robot]]
profile = "omni"
link = "ros2"

[[robot]]
profile = "kuka1"
link = "ros2"

[[principal]]
name = "Ada"
address = "terminal:{uid}"
role = "admin"

[[care]]
scopes = ["kuka1:*"]
confirm = true
"""


@pytest.fixture
def robots(graph: RosGraph, tmp_path: Path, interfaces: Path) -> Iterator[Simulated]:  # noqa: ARG001 - built before
    with simulated(graph, tmp_path, "omni", "kuka1") as simulation:
        yield simulation


@pytest.mark.limit(300)
@pytest.mark.usefixtures("robots")
async def test_a_robot_over_ros_2_is_driven_by_the_official_client(tmp_path: Path) -> None:
    config = write_config(tmp_path, CONFIG)
    with gateway(config, dict(os.environ)) as running:
        await there("omni", config)
        await moves_is_refused_and_is_cancelled(config)
        free("omni", config)
        await is_confirmed(running, config)
        await is_stopped(running, config)
        await asks_too_much(config)


async def there(robot: str, config: Path) -> None:
    """Wait until a robot is heard."""
    with anyio.fail_after(60 * pace()):
        await anyio.to_thread.run_sync(at_rest, robot, config)


async def moves_is_refused_and_is_cancelled(config: Path) -> None:
    async with client(key_of("Mover", config), config) as session:
        tools = {tool.name: tool for tool in (await session.list_tools()).tools}
        assert tools["omni-move"].input_schema["properties"]["distance"]["maximum"] == 5.0
        told = Progress()
        done = await session.call_tool(
            "omni-move", {"distance": 0.2, "direction": "left"}, progress_callback=told
        )
        assert re.search(r"done [\d:]+: moved 0\.\d+ m left", said(done)), said(done)
        assert not done.is_error
        assert "\nsent " in "".join(told.texts)
        far = await session.call_tool("omni-move", {"distance": 50})
        assert far.is_error
        assert said(far) == "omni: one move may be at most 5 m. Nothing was done."
        told = Progress()
        async with anyio.create_task_group() as group:
            group.start_soon(cancelled, session, told)
            await told.hears("received by the robot")
            group.cancel_scope.cancel()
        await there("omni", config)
        assert not at_rest("omni", config)["stopped"], "a cancel latches nothing"


async def cancelled(session: ClientSession, told: Progress) -> None:
    long = {"distance": 5, "speed": 0.05}
    await session.call_tool("omni-move", long, progress_callback=told)


async def is_confirmed(running: Gateway, config: Path) -> None:
    async with client(key_of("Asker", config), config) as session:
        told, done = Progress(), list["CallToolResult"]()

        async def grasp() -> None:
            done.append(await session.call_tool("kuka1-move_joint", JOINT, progress_callback=told))

        async with anyio.create_task_group() as group:
            group.start_soon(grasp)
            await told.hears("I have asked Ada")
            await anyio.to_thread.run_sync(running.wait_for, "I agree")
            assert not done
            running.say(number_of("I agree", running.out()))
        assert not done[0].is_error, said(done[0])
        assert re.search(r"\ndone [\d:]+", said(done[0]))


JOINT = {"joint": 2, "angle": 10}


async def is_stopped(running: Gateway, config: Path) -> None:
    async with client(key_of("Stopper", config), config) as session:
        told = Progress()
        async with anyio.create_task_group() as group:
            group.start_soon(cancelled, session, told)
            await told.hears("received by the robot")
            stopped = await session.call_tool("stop", {"robots": ["omni"]})
        assert not stopped.is_error
        assert re.search(r"STOP: omni at rest \(\d\.\d\d s\)", said(stopped))
        assert (await session.call_tool("omni-move", {"distance": 0.1})).is_error
    resumed(running, "omni", config)


async def asks_too_much(config: Path) -> None:
    async with client(key_of("Hasty", config), config) as session:
        results = [await session.call_tool("status", {"robot": "omni"}) for _ in range(16)]
        assert [one.is_error for one in results] == [False] * 12 + [True] * 4
        assert "Again in" in said(results[-1])
        assert not (await session.call_tool("stop", {})).is_error
