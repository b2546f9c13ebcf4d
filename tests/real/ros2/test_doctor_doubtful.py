"""What `rosic doctor --try` says of robots that report too seldom, or whose own stop is no good."""

from __future__ import annotations

import asyncio
import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.app.config import load_config
from rosic.app.setup.diagnostics_checks import DiagnosticFinding, FindingVerdict, examine_graph
from rosic.app.setup.stop_test import try_robot
from rosic.system import SystemClock, SystemEntropy

if TYPE_CHECKING:
    from rosic.testing.ros2.graph import RosGraph, RosProcess

NODE = Path(__file__).with_name("doubtful_node.py")
PLACE = """
[[messenger]]
kind = "terminal"

[[principal]]
name = "Ada"
address = "terminal:1"
role = "admin"

[[robot]]
profile = "./base.yaml"
"""
BASE = """
id: base
title: Base
link: {{ kind: ros2, namespace: /base }}
stop: {{ service: /base/stop, zero: /base/cmd_vel }}
watchdog_s: 0.5
at_rest:
  {{ topic: /base/odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x, below: 0.005,
    within_s: {within_s} }}
rest_timeout_s: 4
skills:
  drive:
    class: motion
    parameters:
      linear: {{ unit: m/s, min: -0.5, max: 0.5 }}
      duration: {{ unit: s, min: 0.1, max: 60 }}
    topic:
      name: /base/cmd_vel
      type: geometry_msgs/msg/Twist
      message: {{ linear.x: $linear }}
      stream_hz: 20
telemetry:
  battery:
    {{ topic: /base/battery, type: sensor_msgs/msg/BatteryState, field: percentage, unit: "%" }}
"""


@pytest.fixture
def base(graph: RosGraph) -> RosProcess:
    return graph.start(NODE)


async def told(base: RosProcess, line: str) -> int:
    """Tell the base something; return how many velocities it has had so far."""
    base.say(line)
    return int(await asyncio.to_thread(base.expect, "ok"))


async def tried(folder: Path, within_s: float = 1.0) -> list[DiagnosticFinding]:
    """Try the base; return everything that was found."""
    (folder / "base.yaml").write_text(BASE.format(within_s=within_s))
    (folder / "rosic.toml").write_text(PLACE)
    config = load_config(folder / "rosic.toml")
    return [f async for f in try_robot(config, "base", SystemClock(), SystemEntropy())]


async def seen(folder: Path, profile: str) -> list[str]:
    """Return what is said of what a profile names on the graph."""
    (folder / "base.yaml").write_text(profile)
    (folder / "rosic.toml").write_text(PLACE)
    config = load_config(folder / "rosic.toml")
    return [str(finding) async for finding in examine_graph(config.robots)]


@pytest.mark.usefixtures("base")
async def test_what_is_not_on_the_graph_is_named_with_what_to_do(tmp_path: Path) -> None:
    good = BASE.format(within_s=1.0)
    assert await seen(tmp_path, good) == [
        "base       all 4 topics, services and actions of its profile are there"
    ]
    spoilt = good.replace("/base/battery", "/base/power").replace("/base/stop", "/base/halt")
    spoilt = spoilt.replace("geometry_msgs/msg/Twist\n", "geometry_msgs/msg/TwistStamped\n")
    spoilt = spoilt.replace(
        "zero: /base/cmd_vel }", "zero: /base/cmd_vel, zero_type: geometry_msgs/msg/TwistStamped }"
    )
    found = await seen(tmp_path, spoilt)
    assert found == [
        (
            "base       look at this: nobody offers the service /base/halt now. Start what does, "
            "or correct the name in the profile."
        ),
        (
            "base       look at this: the topic /base/cmd_vel has the type geometry_msgs/msg/Twist "
            "there, and geometry_msgs/msg/TwistStamped in the profile. Correct the profile."
        ),
        (
            "base       look at this: nobody sends the topic /base/power now. Start what does, or "
            "correct the name in the profile."
        ),
    ]


@pytest.mark.usefixtures("base")
async def test_a_type_that_is_not_installed_is_named_with_what_to_do(tmp_path: Path) -> None:
    strange = "type: nowhere_msgs/msg/BatteryState"
    profile = BASE.format(within_s=1.0).replace("type: sensor_msgs/msg/BatteryState", strange)
    assert (await seen(tmp_path, profile))[0] == (
        "base       look at this: the ROS package nowhere_msgs is not installed here, and its "
        "profile names types of it. Install it for your distribution, or source the workspace it "
        "is in."
    )


@pytest.mark.usefixtures("graph")
async def test_where_nothing_of_a_robot_is_seen_the_domain_is_named(tmp_path: Path) -> None:
    [found] = await seen(tmp_path, BASE.format(within_s=1.0))
    assert found.startswith(
        "base       look at this: nothing of it is seen. Start it; if it runs, compare ROS_DOMAIN"
    )
    assert found.endswith("here) with what it was started with.")


async def test_a_robot_that_reports_too_seldom_is_not_moved_and_what_to_write_is_said(
    base: RosProcess, tmp_path: Path
) -> None:
    await told(base, "hz=0.7")

    [seldom] = await tried(tmp_path, within_s=0.5)

    assert seldom.verdict is FindingVerdict.LOOK
    said = re.fullmatch(
        r"at_rest: heard every (\d\.\d) s; within_s 0\.5 is too short: write within_s: (\d\.\d); "
        r"it was not moved",
        seldom.text,
    )
    assert said, seldom.text
    assert 1.3 <= float(said[1]) <= 1.6
    assert float(said[2]) in {3.0, 3.5}
    assert await told(base, "velocities") == 0


async def test_what_is_written_then_is_enough(base: RosProcess, tmp_path: Path) -> None:
    await told(base, "hz=0.7")

    stop, _watchdog, _ = await tried(tmp_path, within_s=3.0)

    assert stop.verdict is FindingVerdict.GOOD, stop.text
    assert await told(base, "velocities") > 0


async def test_a_battery_in_per_cent_is_pointed_out(base: RosProcess, tmp_path: Path) -> None:
    await told(base, "battery=15")

    battery, stop, *_ = await tried(tmp_path)

    assert battery.verdict is FindingVerdict.LOOK
    assert battery.text.startswith("battery: it reports more than 1, and ROS defines a fraction")
    assert battery.text.endswith("write full: 100 in its telemetry")
    assert stop.verdict is FindingVerdict.GOOD


async def test_a_stop_that_never_answers_is_looked_at(base: RosProcess, tmp_path: Path) -> None:
    """Zeros bring it to rest; what stops it where somebody else sends velocities is not known."""
    await told(base, "stop=hangs")

    stop, watchdog, stays = await tried(tmp_path)

    assert stop.verdict is FindingVerdict.LOOK
    assert re.fullmatch(
        r"stop: at rest after \d\.\d\d s; its own stop did not answer \(from a slow drive\)",
        stop.text,
    ), stop.text
    assert watchdog.verdict is FindingVerdict.GOOD
    assert stays.text.startswith("it stays stopped")


async def test_a_stop_that_says_that_it_failed_is_looked_at(
    base: RosProcess, tmp_path: Path
) -> None:
    await told(base, "stop=false")

    stop, _, stays = await tried(tmp_path)

    assert stop.verdict is FindingVerdict.LOOK
    assert "; its own stop answered that it failed: brake circuit open (from" in stop.text
    assert stays.text.startswith("it stays stopped")
