"""Robots as principals and their strategies, as the files say them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.config import load_config, read_config
from rosic.config.profiles import check_profile
from rosic.core.identity import Address
from tests.config.profile_text import write

if TYPE_CHECKING:
    from pathlib import Path

CONFIG = """\
[[messenger]]
kind = "terminal"

[[robot]]
profile = "omni"
link = "simulated"

[[principal]]
name = "omni"
address = "robot:omni"
role = "fellow"

[role.fellow]
scopes = ["*:share", "*:ask", "*:help", "*:read", "*:strategy"]
"""
PROFILE = """\
id: rover
link: { kind: ros2, namespace: /rover, among: true }
at_rest:
  { topic: /rover/odom, type: nav_msgs/msg/Odometry, field: twist.twist.linear.x, below: 0.1 }
strategies:
  careful:
    title: Careful
    parameters:
      speed: { unit: m/s, min: 0.05, max: 0.5, default: 0.2 }
"""


def test_a_robot_is_a_principal_at_its_own_address(tmp_path: Path) -> None:
    path = write(tmp_path, CONFIG, "rosic.toml")
    assert [str(error) for error in read_config(path).errors] == []
    [seed] = load_config(path).people
    assert (seed.addresses, seed.roles) == ((Address("robot", "omni"),), ("fellow",))


def test_a_robot_that_is_not_there_cannot_be_one(tmp_path: Path) -> None:
    path = write(tmp_path, CONFIG.replace("robot:omni", "robot:rover"), "rosic.toml")
    [error] = read_config(path).errors
    assert "omni is to be the robot rover, and there is no such [[robot]]." in str(error)
    assert error.where.endswith("rosic.toml:8")


def test_good_strategies_are_good(tmp_path: Path) -> None:
    assert [str(error) for error in check_profile(write(tmp_path, PROFILE))] == []


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("careful:", "back:", "'back' cannot be a strategy"),
        ("unit: m/s, min: 0.05, max: 0.5, default: 0.2", "text: true", "Free text goes"),
        (", among: true", "", "A strategy reaches the robot over its link to other robots."),
        ("default: 0.2", "default: 2", "default is not a number between"),
        ("unit: m/s", "unit: parsec/h", "is not a unit ROSIC knows"),
    ],
)
def test_what_is_wrong_with_a_strategy_is_said(
    old: str, new: str, sentence: str, tmp_path: Path
) -> None:
    errors = check_profile(write(tmp_path, PROFILE.replace(old, new)))
    assert any(sentence in str(error) for error in errors), [str(error) for error in errors]
