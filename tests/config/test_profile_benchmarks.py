"""A benchmark speaks of what there is, or the check says which part does not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.config.profiles import check_profile, known_units, load_profile, shipped_profiles
from rosic.core.alerts.condition import DEVIATES
from rosic.core.alerts.rule import rules_of

if TYPE_CHECKING:
    from pathlib import Path

LOCATED = "geometry_msgs/msg/PoseWithCovarianceStamped"
SPOILT = [
    ("energy: 5", "energy: 5\n      battery: charge", "needs the telemetry of that"),
    (
        "duration_s: 30",
        "duration_s: 30\n      per_s: { place: 2 }",
        "'place' is not a number that this skill asks for.",
    ),
    ("late: 2", "late: 1", "must be between 1.01 and 1000"),
    (
        "wanted: $place.x, within: 0.3",
        "wanted: $place.z, within: 0.3",
        "$place.z is no number that a choice stands for.",
    ),
    (
        "wanted: $place.x, within: 0.3",
        "wanted: place, within: 0.3",
        "'place' is neither a number nor a parameter.",
    ),
    ("wanted: $place.x, within: 0.3", "wanted: $place.x, within: 0", "Within must be above 0"),
    ("measured: pose.x", "measured: pose.q", "is not something that is measured"),
    ("pose: { topic", "camera: { topic", "needs the profile's 'pose'"),
]


@pytest.mark.parametrize(("old", "new", "sentence"), SPOILT)
def test_a_mistake_is_named(old: str, new: str, sentence: str, tmp_path: Path) -> None:
    text = shipped_profiles()["rover"].read_text()
    assert old in text
    file = tmp_path / "robot.yaml"
    changed = text.replace(old, new, 1)
    if "camera" in new:
        changed = changed.replace(LOCATED, "sensor_msgs/msg/Image")
    file.write_text(changed)

    found = [str(error) for error in check_profile(file)]

    assert any(sentence in error for error in found), found


def test_whoever_is_benchmarked_has_a_rule_about_it_unless_the_profile_says_one() -> None:
    rover, omni = (load_profile(shipped_profiles()[name]) for name in ("rover", "omni"))
    names = {rule.alert.name: rule.condition.kind for rule in rules_of(rover, known_units())}
    assert names["off_benchmark"] == DEVIATES
    assert "off_benchmark" not in {r.alert.name for r in rules_of(omni, known_units())}
