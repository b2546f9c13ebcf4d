"""What features know of robots beyond this moment, for whoever shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from rosic.core.history import HistoryEntry, HistoryQuery
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.view import ViewKind


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
        said: What it says, as people read it.
        at_ns: When it was raised, wall clock.
        measured: What is measured now, as people read it.
        by: Who has seen it; empty: nobody yet.
    """

    robot: RobotId
    name: str
    said: str
    at_ns: int
    measured: str
    by: PrincipalId


class HistoryLine(NamedTuple):
    """Something that was asked before, in words.

    Attributes:
        asked: ``omni: move, 0.50 m left``; empty where its words were erased.
        came: What came of it, as it was told.
    """

    entry: HistoryEntry
    asked: str
    came: str


class HistoryReader(Protocol):
    """What was asked before, in words; whether somebody may read it is asked before."""

    async def read(self, query: HistoryQuery) -> Sequence[HistoryLine]:
        """Return it, the newest first.

        Raises:
            RecordUnavailable: It cannot be read now.
        """
        ...


class ShownView(NamedTuple):
    """What a robot shows, as a picture.

    Attributes:
        taken_ns: Wall clock.
    """

    media_type: str
    content: bytes
    taken_ns: int


class RobotViews(Protocol):
    """Makes pictures of what robots show."""

    async def picture(
        self, who: PrincipalId, robot: RobotId, kind: ViewKind, *, low: bool
    ) -> ShownView:
        """Look, and draw; it takes some seconds.

        Raises:
            NothingToSee: Nothing is shown, or nobody here can draw.
            TooManyRequests: Not now.
            NotPermitted: They may not see it any more.
        """
        ...


class HealthFinding(NamedTuple):
    """Something that was looked at.

    Attributes:
        about: ``data``, ``disk``, a messenger's name, a robot's id.
        verdict: ``good``, ``look`` or ``not-measured``.
        text: Figures, and what to do about them where something should be done.
    """

    about: str
    verdict: str
    text: str


class HealthFindings(Protocol):
    """Looks at the gateway and the machine that it runs on."""

    async def findings(self) -> Sequence[HealthFinding]:
        """Return what is found now."""
        ...


class RightsDecision(NamedTuple):
    """What would be decided of one robot if somebody said a line.

    Attributes:
        allowed: It would not be refused; something may have to come first.
        text: The verdict, and every rule that was asked.
    """

    allowed: bool
    text: str


class RightsChecker(Protocol):
    """Says what somebody may, and why; whether somebody may ask that is looked at before."""

    def explained(self, name: str, line: str) -> Sequence[RightsDecision]:
        """Decide, once for each robot, as if somebody had said a line; nothing is done.

        Raises:
            NotUnderstood: Nobody of that name, or the line asks nothing of a robot.
        """
        ...


class OpenAlerts(Protocol):
    """Which alarms are open."""

    def open_now(self, robots: Collection[RobotId]) -> Sequence[OpenAlert]:
        """Return the open alarms of some robots, the newest first."""
        ...
