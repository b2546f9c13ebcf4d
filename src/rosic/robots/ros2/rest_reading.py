"""What the newest message of a topic says of rest, and what keeps it from saying it (I7)."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.robots.ros2.errors import BadName, BadValue
from rosic.robots.ros2.messages.decode import Plain, compile_path
from rosic.robots.ros2.pose_change import PoseChange

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import AtRest
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.topics import LatestMessage

ODOMETRY = "nav_msgs/msg/Odometry"
_NS = 1_000_000_000


class RestReading:
    """One robot's.

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
        return None if self._read_ns is None else (now_ns - self._read_ns) / _NS

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
