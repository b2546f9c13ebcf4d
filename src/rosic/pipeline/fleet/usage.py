"""How much of their time robots have spent on tasks, since this run began."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Collection

    from rosic.core.robot import RobotId


class Usage:
    """Counts time at work: from the moment a robot gets a task until it has none.

    Args:
        now_ns: Monotonic clock.
    """

    def __init__(self, now_ns: int) -> None:
        self._begun_ns = now_ns
        self._since_ns: dict[RobotId, int] = {}
        self._worked_ns: dict[RobotId, int] = {}
        self._idle_since_ns: dict[RobotId, int] = {}

    def note(self, held: Collection[RobotId], now_ns: int) -> None:
        """Hear who has a task now."""
        for robot in held:
            self._since_ns.setdefault(robot, now_ns)
        for robot in [robot for robot in self._since_ns if robot not in held]:
            began_ns = self._since_ns.pop(robot)
            self._worked_ns[robot] = self._worked_ns.get(robot, 0) + now_ns - began_ns
            self._idle_since_ns[robot] = now_ns

    def share(self, robots: Collection[RobotId], now_ns: int) -> float:
        """Return which share of their time some robots were at work, 0 to 1."""
        whole_ns = (now_ns - self._begun_ns) * len(robots)
        worked_ns = sum(self._worked(robot, now_ns) for robot in robots)
        return worked_ns / whole_ns if whole_ns > 0 else 0.0

    def _worked(self, robot: RobotId, now_ns: int) -> int:
        began_ns = self._since_ns.get(robot, now_ns)
        return self._worked_ns.get(robot, 0) + now_ns - began_ns

    def idle_s(self, robot: RobotId, now_ns: int) -> int:
        """Return for how long a robot has had no task; 0 while it has one."""
        if robot in self._since_ns:
            return 0
        return (now_ns - self._idle_since_ns.get(robot, self._begun_ns)) // 1_000_000_000
