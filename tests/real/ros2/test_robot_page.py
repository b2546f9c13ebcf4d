"""What the pages about robots on ROS 2 say is what the code does."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from rosic.config.profiles import check_profile
from rosic.robots.ros2 import stopping
from rosic.robots.ros2.bindings import dialogue
from rosic.robots.ros2.client import node
from rosic_sim.robots.machines.omni import WATCHDOG_S
from rosic_sim.ros2 import faults, machine_node, reports, waiting_clock
from rosic_sim.ros2.endpoints import MODELS
from tests.pace import pace

PAGES = Path(__file__).parents[3] / "docs" / "robots"


def page(name: str) -> str:
    return " ".join((PAGES / name).read_text("utf-8").split())


def test_the_profile_that_is_shown_is_good(tmp_path: Path) -> None:
    text = (PAGES / "ros2.md").read_text("utf-8")
    blocks = re.findall(r"^```yaml\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(blocks) == 1
    file = tmp_path / "rover.yaml"
    file.write_text(blocks[0])
    assert [str(error) for error in check_profile(file)] == []


def test_the_page_on_ros_2_gives_the_right_figures() -> None:
    text = page("ros2.md")
    assert f"every {stopping.AGAIN_EVERY_S:g} s" in text
    assert node.EVERY_S == 0.25
    assert f"Four times a second ROSIC publishes the time on `<namespace>/{node.TOPIC}`" in text
    assert f"(`{node.TYPE}`)" in text
    assert f"within {dialogue.ANSWER_WITHIN_S:g} s the chat reads" in text
    assert f'"{dialogue.NOT_REACHABLE}"' in text


def test_the_page_on_simulated_robots_gives_the_right_figures() -> None:
    text = page("simulated.md")
    assert all(f"`{robot}`" in text for robot in MODELS)
    assert f"stops {WATCHDOG_S:g} s after the last velocity" in text
    assert reports.AT_REST_EVERY_S == 0.1
    assert reports.MOVING_EVERY_S == 0.02
    assert machine_node.LINK_LOST_S == 1.0
    assert f"`{machine_node.TOPIC}`" in text
    assert f"for more than {waiting_clock.LONGEST_GAP_S:g} s" in text
    for name in (faults.LINK, faults.BATTERY, faults.OBJECT, *faults.ARMS):
        assert f"`{name}`" in text


FETCH = "float32 pace\n---\nuint8 code\nstring remark\n---\nfloat32 fraction\n"
FOREIGN = """
id: foreign
link: { kind: ros2, namespace: /foreign }
stop: { cancel_only: true }
at_rest:
  { topic: /foreign/odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x, below: 0.005 }
skills:
  fetch:
    class: motion
    action: { name: /foreign/fetch, type: foreign_msgs/action/Fetch, message: remark }
"""


@pytest.mark.limit(240)
def test_interfaces_of_ones_own_are_built_and_looked_into_command_by_command(
    tmp_path: Path,
) -> None:
    section = (PAGES / "ros2.md").read_text("utf-8").partition("## Interfaces of your own")[2]
    scripts = re.findall(
        r"^```sh\n(.*?)^```", section.partition("\n## ")[0], re.MULTILINE | re.DOTALL
    )
    assert len(scripts) == 2
    action = tmp_path / "ws" / "src" / "foreign_msgs" / "action" / "Fetch.action"
    profile = tmp_path / "robots" / "foreign.yaml"
    for file, text in ((action, FETCH), (profile, FOREIGN)):
        file.parent.mkdir(parents=True)
        file.write_text(text)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

    done = subprocess.run(  # noqa: S603 - our own page
        ["/bin/sh", "-ec", "".join(scripts)],
        cwd=tmp_path,
        env=dict(os.environ) | {"HOME": str(tmp_path), "PATH": path},
        capture_output=True,
        text=True,
        check=False,
        timeout=200 * pace(),
    )

    assert done.returncode == 0, done.stderr
    built, fields, advice, good = done.stdout.splitlines()
    assert (Path(built) / "foreign_msgs").is_dir()
    assert fields == "{'code': 'uint8', 'remark': 'string'}"
    assert "In foreign_msgs/action/Fetch, code (uint8) looks like it: write success: code" in advice
    assert good == "robots/foreign.yaml is good: foreign, 1 skill."
