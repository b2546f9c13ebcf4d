"""What the pages about robots on ROS 2 say is what the code does."""

from __future__ import annotations

import re
from pathlib import Path

from rosic.config.profiles import check_profile
from rosic.robots.ros2 import stopping
from rosic.robots.ros2.bindings import dialogue
from rosic.robots.ros2.client import node
from rosic_sim.robots.machines.omni import WATCHDOG_S
from rosic_sim.ros2 import faults, machine_node, reports, waiting_clock
from rosic_sim.ros2.endpoints import MODELS

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
