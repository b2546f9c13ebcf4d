"""What features know that waits for people, and what robots are given to do, for who shows it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.fleet.task import Task
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId


class PendingRequest(NamedTuple):
    """Somebody waits for an answer.

    Attributes:
        id: By which ``/approve`` and ``/decline`` know it.
        kind: ``newcomer``, who wants to be let in, or ``right``.
        who: Their name.
        what: They would be given, as people read it.
        words: The two words that a newcomer sees, too; empty for a right.
        until_ns: It lapses then; wall clock.
    """

    id: str
    kind: str
    who: str
    what: str
    words: str
    until_ns: int


class PendingAnswers(Protocol):
    """Who waits for an answer."""

    def waiting_for(self, by: PrincipalId) -> Sequence[PendingRequest]:
        """Return what somebody may answer."""
        ...

    def asked_by(self, principal: PrincipalId) -> Sequence[PendingRequest]:
        """Return what somebody waits for themselves."""
        ...


class TaskEntry(NamedTuple):
    """A task, as somebody may read it.

    Attributes:
        what: In its author's words for them alone; else by its skills.
        waits: Why it has not begun, as people read it; empty: it does not wait.
    """

    task: Task
    what: str
    waits: str


class OfferedMission(NamedTuple):
    """A mission that somebody may start.

    Attributes:
        parameters: What is said when it is started: name and bounds, as people read them.
    """

    name: str
    title: str
    parameters: tuple[str, ...]


class MissionRun(NamedTuple):
    """A mission that was started, and is not over."""

    id: str
    tasks: tuple[Task, ...]


class TimeAtWork(NamedTuple):
    """How busy a robot was.

    Attributes:
        now: It is at work.
        worked_s: So long it was, in the time that was asked for.
        counted_s: So much of that time was counted at all.
    """

    now: bool
    worked_s: float
    counted_s: float


class FleetWork(Protocol):
    """What robots are given to do."""

    def tasks_for(self, who: PrincipalId) -> Sequence[TaskEntry]:
        """Return the open tasks that somebody may see, those that have a robot first."""
        ...

    def missions_for(self, who: PrincipalId) -> Sequence[OfferedMission]:
        """Return the missions that somebody may start."""
        ...

    def runs_for(self, who: PrincipalId) -> Sequence[MissionRun]:
        """Return the missions that run, as far as somebody may see."""
        ...

    def work_of(self, robot: RobotId, since_ns: int, now_ns: int) -> TimeAtWork:
        """Return for how long a robot was at work since then, at most eight days ago; wall clock.

        What it costs does not grow with the past.
        """
        ...
