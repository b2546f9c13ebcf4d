"""Whether odometry goes from place to place while it says that it rests: one of both is wrong."""

from __future__ import annotations

from math import atan2, dist, isfinite, tau
from typing import TYPE_CHECKING, Final, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.topics import Heard, LatestMessage

WITHIN_NS: Final = 500_000_000
"""So far back it is compared; and always with the message before, however seldom they come."""
SLACK_M: Final = 0.01
SLACK_RAD: Final = 0.02
"""A pose that is corrected a little is no motion."""
FASTER: Final = 2.0
"""So many times faster than what counts as rest the pose has to change."""


class _Pose(NamedTuple):
    place_m: tuple[float, float, float]
    yaw_rad: float


class PoseChange:
    """Of one topic of odometry.

    Args:
        source: The topic.
        below: At most so many m/s, and rad/s, are rest.
    """

    def __init__(self, source: LatestMessage, below: float) -> None:
        self._source = source
        self._below = below
        self._known: dict[int, RosObject] = {}

    def contradicts(self, rests: Callable[[RosObject], bool]) -> bool:
        """Tell whether the pose changed between messages all of which say rest.

        Args:
            rests: Whether one says so; asked from the newest back to the first that does not.

        Raises:
            BadValue: What came cannot be read.
        """
        newest, sent_ns = self._source.message(), self._source.sent_ns
        if newest is None or sent_ns is None or not rests(newest):
            return False
        now = _pose(newest)
        for number, heard in enumerate(reversed(self._read())):
            past_ns = sent_ns - heard.sent_ns
            if (number and past_ns > WITHIN_NS) or not rests(self._known[heard.received_ns]):
                return False
            if self._apart(now, _pose(self._known[heard.received_ns]), past_ns / 1e9):
                return True
        return False

    def _read(self) -> tuple[Heard, ...]:
        """Return what came before, each decoded once."""
        earlier = self._source.earlier()
        known = self._known
        self._known = {
            heard.received_ns: known[heard.received_ns]
            if heard.received_ns in known
            else self._source.decoded(heard)
            for heard in earlier
        }
        return earlier

    def _apart(self, now: _Pose, before: _Pose, past_s: float) -> bool:
        allowed = FASTER * self._below * past_s
        turned_rad = abs(now.yaw_rad - before.yaw_rad) % tau
        return (
            dist(now.place_m, before.place_m) > SLACK_M + allowed
            or min(turned_rad, tau - turned_rad) > SLACK_RAD + allowed
        )


def _pose(message: RosObject) -> _Pose:
    """Return it; one that is no number stays where it is: it contradicts nothing."""
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    yaw_rad = atan2(
        2 * (turn.w * turn.z + turn.x * turn.y), 1 - 2 * (turn.y * turn.y + turn.z * turn.z)
    )
    x_m, y_m, z_m = (float(m) if isfinite(m) else 0.0 for m in (place.x, place.y, place.z))
    return _Pose((x_m, y_m, z_m), yaw_rad if isfinite(yaw_rad) else 0.0)
