"""How far a robot has gone by its own odometry, as far as that can be told."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING, Final

from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.robots.ros2.telemetry import MeasuredPose, Measurements

AT_MOST: Final = 2.0
"""So many times faster than it is told to be, and than it says that it is, nothing drives."""
SLACK_S: Final = 0.1
SLACK_M: Final = 0.05


class OdometryDistance:
    """Added up from look to look.

    Attributes:
        jumped: Its odometry began anew, or went from one place to another faster than it drives: no
            way that was driven.
    """

    def __init__(self, measured: Measurements, told_m_s: float) -> None:
        """Begin where it is now.

        Args:
            measured: Of the robot.
            told_m_s: How fast it is told to be.
        """
        self.jumped = False
        self._measured = measured
        self._told_m_s = told_m_s
        self._at = measured.place()
        self._metres = None if self._at is None else 0.0
        self._meant_m = 0.0

    @property
    def metres(self) -> float | None:
        """How far, if that can be told.

        None while the robot has not said where it is, once its odometry has jumped, and as long as
        it says that it moves and its place never changes: nobody fills that in.
        """
        fixed = self._metres == 0.0 and self._meant_m > SLACK_M
        return None if fixed else self._metres

    def look(self) -> None:
        """Take in where it is now."""
        now, before = self._measured.place(), self._at
        if now is None or self.jumped:
            return
        past_m = 0.0 if before is None else hypot(now.x_m - before.x_m, now.y_m - before.y_m)
        self.jumped = before is not None and self._jumps(past_m, before, now)
        self._metres = None if self.jumped else (self._metres or 0.0) + past_m
        if before is not None:
            self._meant_m += now.speed_m_s * (now.at_ns - before.at_ns) / SECOND_NS
        self._at = now

    def _jumps(self, past_m: float, before: MeasuredPose, now: MeasuredPose) -> bool:
        speed_m_s = max(self._told_m_s, before.speed_m_s, now.speed_m_s)
        past_s = (now.at_ns - before.at_ns) / SECOND_NS + SLACK_S
        return now.restarts != before.restarts or past_m > AT_MOST * speed_m_s * past_s + SLACK_M


def told_m_s(values: Mapping[str, object]) -> float:
    """Return how fast a message tells a robot to be, at most; of what kind it may ever be."""
    numbers = {
        field: abs(value) for field, value in values.items() if isinstance(value, (int, float))
    }
    linear = [number for field, number in numbers.items() if "linear" in field.split(".")]
    return float(sum(linear or numbers.values()))
