"""Exclusive control of one robot, and its number, which only grows (I4, I12)."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId


class Lease:
    """Who has a robot. Held while orders are under way and ``idle_ns`` after the last.

    Attributes:
        fence: Grows by one whenever the holder changes.
        active: Orders under way.
        idle_since_ns: Monotonic clock of the last end; meaningful when ``active`` is 0.
    """

    __slots__ = ("active", "fence", "holder", "idle_since_ns")

    def __init__(self, fence: int) -> None:
        self.fence = fence
        self.holder: PrincipalId | None = None
        self.active = 0
        self.idle_since_ns = 0

    def holder_at(self, now_ns: int, idle_ns: int) -> PrincipalId | None:
        """Return who holds the robot at a time; an idle lease lapses by itself."""
        if self.holder is None or self.active:
            return self.holder
        return self.holder if now_ns - self.idle_since_ns < idle_ns else None

    def take(self, principal: PrincipalId, now_ns: int, idle_ns: int) -> bool:
        """Take or keep the robot for one more order. Return whether the fence grew.

        The caller has checked that nobody else holds it.
        """
        lapsed = not self.active and now_ns - self.idle_since_ns >= idle_ns
        grew = lapsed or self.holder != principal
        if grew:
            self.fence += 1
            self.holder = principal
        self.active += 1
        return grew

    def keep(self, principal: PrincipalId, until_ns: int, now_ns: int, idle_ns: int) -> None:
        """Let nobody else have the robot until then, though nobody uses it yet; lapses by itself.

        The caller has checked that nobody else holds it.
        """
        self.take(principal, now_ns, idle_ns)
        self.active -= 1
        self.idle_since_ns = until_ns - idle_ns

    def is_kept(self, until_ns: int, idle_ns: int) -> bool:
        """Whether it was kept until then, and has not been used since."""
        return not self.active and self.idle_since_ns == until_ns - idle_ns

    def settle(self, fence: int, now_ns: int) -> None:
        """One order under ``fence`` has ended."""
        if fence == self.fence and self.active:
            self.active -= 1
            self.idle_since_ns = now_ns

    def runs(self, fence: int) -> bool:
        """Whether the robot is still with whoever took it under this number."""
        return fence == self.fence and self.holder is not None

    def release(self) -> None:
        """Give the robot back. Orders still under way keep their fence and become void."""
        self.holder = None
        self.active = 0

    def age(self, ns: int) -> None:
        """Make it older: it idled for so long while the monotonic clock stood still."""
        self.idle_since_ns -= ns


class Leases(dict["RobotId", Lease]):
    """Every robot's lease; read for every order, so that it is a plain table."""

    def age(self, ns: int) -> None:
        """Make what idles older: so much time has passed that the monotonic clock missed."""
        for lease in self.values():
            lease.age(ns)
