"""How much of their time robots have been at work, since this run began."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import RobotId


class _Robot:
    """What is known of one robot.

    Attributes:
        held: It has a task.
        ordered: An order that needs it for itself is with it.
        since_ns: Since when it has been at work, or has not, or since what was added up.
        worked_ns: For how long it had been at work before.
    """

    __slots__ = ("held", "ordered", "since_ns", "worked_ns")

    def __init__(self, since_ns: int) -> None:
        self.held = self.ordered = False
        self.since_ns = since_ns
        self.worked_ns = 0

    @property
    def works(self) -> bool:
        """Whether it is at work now."""
        return self.held or self.ordered

    def count(self, now_ns: int) -> None:
        """Add up what it has worked so far; it may go on."""
        self.worked_ns += now_ns - self.since_ns
        self.since_ns = now_ns


class FleetUsage:
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
        self._robots: dict[RobotId, _Robot] = {}

    # ---- what is heard ----

    def note(self, held: Collection[RobotId]) -> None:
        """Hear who has a task now."""
        now_ns, before = self._now_ns(), self._held
        self._held = set(held)
        for name in self._held - before:
            robot = self._known(name)
            if not robot.works:
                robot.since_ns = now_ns
            robot.held = True
        for name in before - self._held:
            robot = self._robots[name]
            robot.held = False
            robot.count(now_ns)

    def began(self, order: Order) -> None:
        """Hear that an order is handed to its robot."""
        if order.skill.actuates:
            robot = self._robots.get(order.robot) or self._known(order.robot)
            if not (robot.held or robot.ordered):
                robot.since_ns = self._now_ns()
            robot.ordered = True

    def ended(self, order: Order, outcome: Outcome) -> None:  # noqa: ARG002 - however it ended
        """Hear that it is over."""
        robot = self._robots.get(order.robot)
        if robot is not None and robot.ordered:
            robot.ordered = False
            robot.count(self._now_ns())

    def _known(self, name: RobotId) -> _Robot:
        robot = self._robots.get(name)
        if robot is None:
            robot = self._robots[name] = _Robot(self._begun_ns)
        return robot

    # ---- what is asked ----

    def works(self, name: RobotId) -> bool:
        """Return whether a robot is at work now."""
        robot = self._robots.get(name)
        return robot is not None and robot.works

    def share(self, names: Collection[RobotId]) -> float:
        """Return which share of their time some robots were at work, 0 to 1."""
        now_ns = self._now_ns()
        whole_ns = (now_ns - self._begun_ns) * len(names)
        worked_ns = sum(self._worked_ns(name, now_ns) for name in names)
        return worked_ns / whole_ns if whole_ns > 0 else 0.0

    def _worked_ns(self, name: RobotId, now_ns: int) -> int:
        robot = self._robots.get(name)
        if robot is None:
            return 0
        return robot.worked_ns + (now_ns - robot.since_ns if robot.works else 0)

    def idle_s(self, name: RobotId) -> int:
        """Return for how long a robot has not been at work; 0 while it is."""
        robot = self._robots.get(name) or _Robot(self._begun_ns)
        return 0 if robot.works else (self._now_ns() - robot.since_ns) // 1_000_000_000
