"""Whether the feedback of a goal still comes: what carries a goal out may be frozen, or gone.

Feedback is no duty in ROS: many a server tells only that it has begun. So its ceasing says
something only of a server that has told of the goal again and again.
"""

from __future__ import annotations

from typing import Final

from rosic.core.time_units import SECOND_NS

STEADY: Final = 5
"""So many messages are feedback that comes again and again; fewer may be stages."""
GAPS: Final = 3
"""So many times its longest gap so far is no gap any more."""
QUIET_S: Final = 1.0


class FeedbackPulse:
    """Counts the feedback of one goal, by the monotonic clock."""

    __slots__ = ("_count", "_last_ns", "_longest_ns")

    def __init__(self, now_ns: int) -> None:
        self._count = 0
        self._last_ns = now_ns
        self._longest_ns = 0

    def beat(self, now_ns: int) -> None:
        """Take in that feedback has come."""
        if self._count:
            self._longest_ns = max(self._longest_ns, now_ns - self._last_ns)
        self._count += 1
        self._last_ns = now_ns

    def silent_s(self, now_ns: int) -> float:
        """Return for how long none has come, from the goal's acceptance on."""
        return (now_ns - self._last_ns) / SECOND_NS

    def quiet(self, now_ns: int) -> bool:
        """Tell whether none comes now; whether it will again is not known."""
        return self._longer_than(QUIET_S, now_ns)

    def ceased(self, now_ns: int, within_s: float) -> bool:
        """Tell whether feedback that came again and again comes no more.

        Args:
            now_ns: The monotonic clock.
            within_s: The deadline of the robot's side, at least.
        """
        return self._count >= STEADY and self._longer_than(within_s, now_ns)

    def _longer_than(self, least_s: float, now_ns: int) -> bool:
        return now_ns - self._last_ns > max(least_s * SECOND_NS, GAPS * self._longest_ns)
