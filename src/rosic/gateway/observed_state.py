"""What features know of robots beyond this moment, for whoever shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId


class TelemetryHistory(Protocol):
    """What robots have reported in the last minutes, as far as it is a number."""

    def names(self, robot: RobotId) -> Sequence[str]:
        """Return the values of a robot that were ever a number."""
        ...

    def values(self, robot: RobotId, name: str) -> Sequence[tuple[float, float]]:
        """Return how many seconds ago which value was reported, the oldest first."""
        ...


class OpenAlert(NamedTuple):
    """One alarm that is open.

    Attributes:
        at_ns: When it was raised, wall clock.
        measured: What is measured now, as people read it.
        by: Who has seen it; empty: nobody yet.
    """

    robot: RobotId
    name: str
    at_ns: int
    measured: str
    by: PrincipalId


class OpenAlerts(Protocol):
    """Which alarms are open."""

    def open_now(self, robots: Collection[RobotId]) -> Sequence[OpenAlert]:
        """Return the open alarms of some robots, the newest first."""
        ...
