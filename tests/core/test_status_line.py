"""What one line says of whether a robot moves."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.core.messages import status_line
from rosic.core.robot.profile import Presence, Profile, Telemetry
from rosic.features.dashboard.messages import battery
from rosic.robots.ros2.profile import Ros2Link

HEARD_S_AGO = [(9.9, ""), (10.0, ", 10 s ago"), (240.0, ", 4 min ago"), (7300.0, ", 2 h ago")]
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


@pytest.mark.parametrize(("age_s", "age"), HEARD_S_AGO)
def test_what_was_reported_long_ago_is_told_with_its_age(age_s: float, age: str) -> None:
    described = {"battery": Telemetry(unit="%"), "mode": Telemetry(), "x": Telemetry(unit="m")}
    presence = Presence(
        online=True,
        at_rest=True,
        values={"battery": 80.0, "mode": "auto", "x": 1.5},
        ages_s={"battery": age_s, "mode": age_s, "x": 0.1},
    )
    told = status_line(
        replace(AGV, telemetry=described), presence, holder="", stopped_by=None, waiting=0
    )
    assert told == f"agv: at rest · free · battery 80 %{age} · mode auto{age} · x 1.50 m"
    card = battery(replace(AGV, telemetry=described), presence)
    step = {"": 0, ", 10 s ago": 10, ", 4 min ago": 120, ", 2 h ago": 3600}[age]
    assert card == "battery 80 %" + (f", not heard for over {step} s" if step else "")


def test_of_what_is_no_number_is_said_so() -> None:
    described = {"battery": Telemetry(unit="%", alert_below=20), "x": Telemetry(unit="m")}
    profile = replace(AGV, telemetry=described)
    presence = Presence(
        online=True, values={"x": 1.5}, ages_s={"battery": 240.0}, no_number=("battery",)
    )
    assert status_line(profile, presence, holder="", stopped_by=None, waiting=0) == (
        "agv: free · battery not known, as the robot gives no number, 4 min ago · x 1.50 m"
    )
    assert battery(profile, presence) == "battery not known, as the robot gives no number"
    assert battery(profile, Presence(online=True)) == "", "nothing was heard of it"
