"""What the newest message of a topic says of rest, and what keeps it from saying it (I7)."""

from __future__ import annotations

from math import atan2, dist, isfinite, tau
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import said
from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.errors import BadName, BadValue
from rosic.robots.ros2.messages.decode import Plain, compile_path

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.topics import LatestMessage, ReceivedMessage
    from rosic.robots.ros2.profile import AtRest

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

    def _read(self) -> tuple[ReceivedMessage, ...]:
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


# ---- rest by one topic (I7) ----

ODOMETRY = "nav_msgs/msg/Odometry"


class RestReading:
    """Reads from the newest messages of one robot whether it rests.

    Attributes:
        source: The topic.
    """

    def __init__(
        self, at_rest: AtRest, source: LatestMessage, cls: RosObject, clock: Clock
    ) -> None:
        """Check the fields.

        Raises:
            BadName: One of them does not exist, or holds no number.
        """
        self.source = source
        self._clock = clock
        self._below = at_rest.below
        self._apart = at_rest.counting_for_stops
        self._speeds = {path: compile_path(cls, path) for path in at_rest.fields}
        self._read_ns: int | None = None
        odometry = at_rest.type == ODOMETRY
        self._pose = PoseChange(source, at_rest.below) if odometry else None
        for path, read in self._speeds.items():
            if read.shape not in {"number", "list"}:
                raise BadName(f"{path} of {at_rest.type} holds no number.")

    def still(self, since_ns: int = 0, left_out: Iterable[str] = ()) -> bool | None:
        """Tell whether the newest message says rest.

        Args:
            since_ns: What was not sent after it says nothing.
            left_out: Fields that do not count.

        Returns:
            None where that is not measured: a number that is missing, or is not finite, is neither
            rest nor motion; where several send, none of them speaks for the others; and odometry
            that goes from place to place does not rest, whatever its velocities say.
        """
        sent_ns, born_ns = self.source.sent_ns or 0, self.source.senders.born_ns
        speeds = self._read() if sent_ns > max(since_ns, born_ns) else None
        return None if speeds is None else self._rests(speeds, left_out)

    def age_s(self) -> float | None:
        """Return for how long rest, or the lack of it, was not measured; None: it never was."""
        self._read()
        now_ns = self._clock.monotonic_ns()
        return None if self._read_ns is None else (now_ns - self._read_ns) / SECOND_NS

    def _rests(self, speeds: Mapping[str, list[float]], left_out: Iterable[str]) -> bool:
        counted = [entries for path, entries in speeds.items() if path not in left_out]
        return all(abs(speed) <= self._below for entries in counted for speed in entries)

    def doubt(self, stale_ns: int) -> str:
        """Return why what is heard measures neither rest nor motion; empty if it does.

        Args:
            stale_ns: What was sent before it says nothing of now.
        """
        if self.several():
            return said("more than one program reports it")
        message = self._message()
        if message is not None and self._numbers(message) is None:
            return said("its velocity is missing or no number")
        if (self.source.sent_ns or 0) <= stale_ns:
            return said("what is reported is old, or is repeated")
        if self._contradicted():
            return said("its velocity is zero while its position changes")
        return ""

    def several(self) -> bool:
        """Tell whether more than one end sends: whichever rests first would speak for all."""
        senders = self.source.senders
        if senders.told_apart:
            return senders.several(self._clock.monotonic_ns())
        return self.source.publishers > 1

    def _read(self) -> dict[str, list[float]] | None:
        """Return every number of the newest message, by field; None where it measures nothing."""
        sent_ns, message = self.source.sent_ns, self._message()
        found = None if message is None or self.several() else self._numbers(message)
        if found is None or self._contradicted():
            return None
        self._read_ns = sent_ns
        return found

    def _contradicted(self) -> bool:
        """Tell whether the pose changes while the velocities say rest."""
        try:
            return self._pose is not None and self._pose.contradicts(self._says_rest)
        except BadValue:
            return True

    def _says_rest(self, message: RosObject) -> bool:
        speeds = self._numbers(message)
        return speeds is not None and self._rests(speeds, self._apart)

    def _message(self) -> RosObject | None:
        try:
            return self.source.message()
        except BadValue:
            return None

    def _numbers(self, message: RosObject) -> dict[str, list[float]] | None:
        """Return every number that counts; None unless all of them are there, and are numbers."""
        try:
            found = {path: numbers(read(message)) for path, read in self._speeds.items()}
        except BadValue:
            return None
        whole = all(entries and all(map(isfinite, entries)) for entries in found.values())
        return found if whole else None


def numbers(value: Plain) -> list[float]:
    """Return a number, or a list of numbers, as numbers; what is none is NaN."""
    entries = value if isinstance(value, list) else [value]
    return [float(entry) if isinstance(entry, (int, float)) else float("nan") for entry in entries]
