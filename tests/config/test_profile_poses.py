"""Choices that stand for numbers, and arms that follow trajectories: each mistake is named."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.config.profiles import check_profile, shipped_profiles

if TYPE_CHECKING:
    from pathlib import Path

SPOILT = [
    ("rover", "$place.x", "$place.z", "$place.z: the choices of place do not stand for 'z'."),
    ("rover", "$place.x", "$place", "$place is a word; what it stands for has names."),
    ("rover", "          dock: { x: 0, y: 0, yaw: 0 }\n", "", "Means and choices must have the"),
    (
        "rover",
        "dock: { x: 0, y: 0, yaw: 0 }",
        "dock: { x: 0, y: 0 }",
        "Means must give the same numbers for every choice",
    ),
    ("rover", "dock: { x: 0,", "dock: { x: .nan,", "finite"),
    (
        "picker",
        "home: { joints: [0, -1.57,",
        "home: { joints: [4, -1.57,",
        "shoulder_pan_joint goes from -3.14 to 3.14, and is at 4 here.",
    ),
    (
        "picker",
        "home: { joints: [0, -1.57,",
        "home: { joints: [-1.57,",
        "A pose of this robot has 6 joints.",
    ),
    ("picker", "elbow_joint: [elbow]", "elbow: []", "'elbow' is none of this robot's joints."),
    ("picker", "to: $pose.joints, speed: $speed", "to: pose, speed: $speed", "is not a parameter"),
    ("picker", "speed: 0.3", "speed: 3", "Speed is a share of the joints' own"),
    ("picker", "stop: { cancel_only: true }", "stop: {}", "names neither a service nor"),
    (
        "picker",
        "{ cancel_only: true }",
        "{ cancel_only: true, service: /picker/stop }",
        "Cancel_only means that there is neither",
    ),
]


@pytest.mark.parametrize(("name", "old", "new", "sentence"), SPOILT)
def test_a_mistake_is_named(name: str, old: str, new: str, sentence: str, tmp_path: Path) -> None:
    text = shipped_profiles()[name].read_text()
    assert old in text
    file = tmp_path / "robot.yaml"
    file.write_text(text.replace(old, new, 1))

    found = [str(error) for error in check_profile(file)]

    assert any(sentence in error for error in found), found


def test_a_trajectory_needs_the_joints(tmp_path: Path) -> None:
    text = shipped_profiles()["picker"].read_text()
    head, _, rest = text.partition("joints:\n  topic")
    file = tmp_path / "robot.yaml"
    file.write_text(head + rest.partition("\nskills:")[1] + rest.partition("\nskills:")[2])

    assert any("needs to know the joints" in str(error) for error in check_profile(file))
