"""How far a robot drove by its odometry, and when that cannot be told."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import pytest

from rosic.robots.ros2.motion_endings import OdometryDistance, told_m_s
from rosic.robots.ros2.telemetry import MeasuredPose

if TYPE_CHECKING:
    from rosic.robots.ros2.telemetry import Measurements

TICK_NS = 50 * 10**6


class Odometry:
    """Says what it is told to say."""

    def __init__(self) -> None:
        self.at: MeasuredPose | None = MeasuredPose(0.0, 0.0, 0.0, 0, 0)

    def place(self) -> MeasuredPose | None:
        return self.at

    def goes(
        self, x_m: float, *, restarts: int = 0, ticks: int = 1, speed_m_s: float = 0.2
    ) -> None:
        before = self.at or MeasuredPose(0.0, 0.0, 0.0, 0, 0)
        self.at = MeasuredPose(x_m, 0.0, speed_m_s, before.at_ns + ticks * TICK_NS, restarts)


def way_of(odometry: Odometry, told: float = 0.2) -> OdometryDistance:
    return OdometryDistance(cast("Measurements", odometry), told)


def test_what_it_drives_is_added_up_also_back_and_over_a_gap() -> None:
    odometry = Odometry()
    way = way_of(odometry)
    for x_m in (0.01, 0.02, 0.01):
        odometry.goes(x_m)
        way.look()
    odometry.goes(0.61, ticks=60)
    way.look()
    assert way.metres == pytest.approx(0.63)
    assert not way.jumped


@pytest.mark.parametrize("restarts", [0, 1])
def test_a_jump_is_never_a_way_and_what_follows_tells_no_way_either(restarts: int) -> None:
    odometry = Odometry()
    way = way_of(odometry)
    odometry.goes(0.01 if restarts else 0.5, restarts=restarts)
    way.look()
    assert (way.metres, way.jumped) == (None, True)
    odometry.goes(0.02, restarts=restarts)
    way.look()
    assert way.metres is None


def test_a_robot_that_is_faster_than_it_was_told_to_be_has_not_jumped() -> None:
    odometry = Odometry()
    way = way_of(odometry, told=0.0)
    odometry.goes(0.4, speed_m_s=4.0)
    way.look()
    assert way.metres == pytest.approx(0.4)


def test_who_has_not_said_where_it_is_has_no_way() -> None:
    odometry = Odometry()
    odometry.at = None
    way = way_of(odometry)
    way.look()
    assert (way.metres, way.jumped) == (None, False)


def test_how_fast_it_is_told_to_be() -> None:
    assert told_m_s({"twist.linear.x": -0.3, "twist.angular.z": 2.0}) == pytest.approx(0.3)
    assert told_m_s({"speed": 0.3, "frame": "base", "steering_angle": 0.1}) == pytest.approx(0.4)
    assert told_m_s({}) == 0.0


def test_a_place_that_never_changes_while_it_moves_is_no_way_of_nothing() -> None:
    odometry = Odometry()
    way = way_of(odometry)
    for _ in range(10):
        odometry.goes(0.0)
        way.look()
    assert way.metres is None
    assert not way.jumped


def test_what_says_that_it_stands_has_gone_nowhere() -> None:
    odometry = Odometry()
    way = way_of(odometry)
    for _ in range(10):
        odometry.goes(0.0, speed_m_s=0.0)
        way.look()
    assert way.metres == 0.0
