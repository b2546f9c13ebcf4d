"""Drafts of a robot whose reports are not what their types promise."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
import yaml

from rosic.app.setup.discovery import LOOK_S, discover
from rosic.cli.robots import discover_robots
from rosic.system import SystemClock

if TYPE_CHECKING:
    from typing import Any

    from rosic.testing.ros2.graph import RosGraph, RosProcess

NODE = Path(__file__).with_name("doubtful_node.py")
ODOM = "# Left out of at_rest: /base/odom: its velocity is zero while its position changes."
JOINTS = "# Left out of at_rest: /base/joints: its velocity is missing or no number."

pytestmark = pytest.mark.limit(120)


@pytest.fixture
def base(graph: RosGraph) -> RosProcess:
    return graph.start(NODE)


async def drafted(base: RosProcess, line: str) -> tuple[str, dict[str, Any]]:
    """Tell the base something; return the draft of it, as text and as it is read."""
    base.say(line)
    await asyncio.to_thread(base.expect, "ok")
    text = (await discover(SystemClock(), seconds=LOOK_S))["base"]
    return text, yaml.safe_load(text)


async def test_what_it_reports_as_it_should_is_drafted(base: RosProcess) -> None:
    text, profile = await drafted(base, "hz=20")
    assert "Left out of at_rest" not in text
    assert profile["at_rest"]["topic"] == "/base/odom"
    assert "within_s" not in profile["at_rest"]
    assert "full" not in profile["telemetry"]["battery"]


async def test_odometry_that_contradicts_itself_is_left_out_and_joints_show_rest(
    base: RosProcess,
) -> None:
    text, profile = await drafted(base, "twist=zero by_hand=0.3")
    assert ODOM in text.splitlines()
    assert profile["at_rest"]["topic"] == "/base/joints"


async def test_where_nothing_shows_rest_it_is_said_and_not_drafted(
    base: RosProcess, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    base.say("twist=zero by_hand=0.3 joints=empty")
    await asyncio.to_thread(base.expect, "ok")
    assert await asyncio.to_thread(discover_robots, ["-o", str(tmp_path)]) == 0
    lines = (tmp_path / "base.yaml").read_text().splitlines()
    assert {ODOM, JOINTS} <= set(lines)
    assert "at_rest:" not in lines
    said = capfd.readouterr().out
    assert f"look at: {JOINTS.removeprefix('# ')}" in said
    assert "at_rest" in said.rpartition("look at: ")[2], "the check misses it"


async def test_a_slow_robot_and_a_battery_in_per_cent_are_drafted_as_they_are(
    base: RosProcess,
) -> None:
    _, profile = await drafted(base, "hz=0.7 battery=15")
    assert profile["at_rest"]["within_s"] in {3.0, 3.5}
    assert profile["telemetry"]["battery"]["full"] == 100
