"""What one line says of whether a robot moves."""

from __future__ import annotations

import pytest

from rosic.core.messages import status_line
from rosic.core.robot.profile import Presence, Profile
from rosic.robots.ros2.profile import Ros2Link

AGV = Profile(id="agv", link=Ros2Link(kind="ros2", namespace="/agv"))


@pytest.mark.parametrize(
    ("presence", "line"),
    [
        (Presence(online=True, at_rest=False), "agv: moves · free"),
        (Presence(online=True, at_rest=False, doing="go"), "agv: doing go · free"),
        (Presence(online=True, at_rest=False, holds=True), "agv: free"),
        (Presence(online=True, at_rest=True), "agv: at rest · free"),
    ],
)
def test_it_says_that_a_robot_moves_by_nobodys_order(presence: Presence, line: str) -> None:
    assert status_line(AGV, presence, holder="", stopped_by=None, waiting=0) == line
