"""How much of their time robots have been at work, since this run began."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from rosic.core.order import Order, Outcome
    from rosic.core.robot import RobotId


class Usage:
    """Counts time at work; a `Watcher` of orders.

    A robot is at work from the moment it gets a task until it has none, and from when an order that
    needs it for itself is handed to it until its end is known, whoever gave it. Where both are so,
    the time counts once. To be asked something is no work.

    Args:
        monotonic_ns: Returns the moment, on the monotonic clock.
    """

    def __init__(self, monotonic_ns: Callable[[], int]) -> None:
        self._now_ns = monotonic_ns
        self._begun_ns = monotonic_ns()
        self._held: set[RobotId] = set()
        self._ordered: set[RobotId] = set()
        self._since_ns: dict[RobotId, int] = {}
        self._worked_ns: dict[RobotId, int] = {}
        self._idle_since_ns: dict[RobotId, int] = {}

    # ---- what is heard ----

    def note(self, held: Collection[RobotId]) -> None:
        """Hear who has a task now."""
        now_ns, before = self._now_ns(), self._held
        self._held = set(held)
        for robot in self._held - before:
            self._since_ns.setdefault(robot, now_ns)
        for robot in before - self._held:
            if robot not in self._ordered:
                self._rests(robot, now_ns)

    def began(self, order: Order) -> None:
        """Hear that an order is handed to its robot."""
        if order.skill.actuates:
            self._ordered.add(order.robot)
            if order.robot not in self._since_ns:
                self._since_ns[order.robot] = self._now_ns()

    def ended(self, order: Order, outcome: Outcome) -> None:  # noqa: ARG002 - however it ended
        """Hear that it is over."""
        robot = order.robot
        if robot in self._ordered:
            self._ordered.discard(robot)
            if robot not in self._held:
                self._rests(robot, self._now_ns())

    def _rests(self, robot: RobotId, now_ns: int) -> None:
        worked_ns = now_ns - self._since_ns.pop(robot)
        self._worked_ns[robot] = self._worked_ns.get(robot, 0) + worked_ns
        self._idle_since_ns[robot] = now_ns

    # ---- what is asked ----

    def works(self, robot: RobotId) -> bool:
        """Return whether a robot is at work now."""
        return robot in self._since_ns

    def share(self, robots: Collection[RobotId]) -> float:
        """Return which share of their time some robots were at work, 0 to 1."""
        now_ns = self._now_ns()
        whole_ns = (now_ns - self._begun_ns) * len(robots)
        worked_ns = sum(self._worked(robot, now_ns) for robot in robots)
        return worked_ns / whole_ns if whole_ns > 0 else 0.0

    def _worked(self, robot: RobotId, now_ns: int) -> int:
        began_ns = self._since_ns.get(robot, now_ns)
        return self._worked_ns.get(robot, 0) + now_ns - began_ns

    def idle_s(self, robot: RobotId) -> int:
        """Return for how long a robot has not been at work; 0 while it is."""
        if robot in self._since_ns:
            return 0
        since_ns = self._idle_since_ns.get(robot, self._begun_ns)
        return (self._now_ns() - since_ns) // 1_000_000_000
