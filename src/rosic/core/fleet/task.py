"""A task: something that one robot of several is to do, step by step, and where it stands."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.robot.profile import RobotId

if TYPE_CHECKING:
    from collections.abc import Iterable

TaskId: TypeAlias = str
"""A number, as people read and type it."""

STEPS_AT_MOST: Final = 64
MOVES_AT_MOST: Final = 5
"""A task that so many robots have failed at is no robot's fault."""
PRIORITIES: Final = (0, 9)


class TaskState(enum.Enum):
    """Where a task is in its life."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    QUEUED = "queued"
    ASSIGNED = "assigned"
    """A robot was chosen, and its order is being admitted: it may have been claimed already."""
    RUNNING = "running"
    PAUSED = "paused"
    DONE = "done"
    FAILED = "failed"
    CANCELLED = "cancelled"
    UNKNOWN = "unknown"
    """A step of it may or may not have been carried out; a person says what is to follow."""


class TaskReason(enum.Enum):
    """Why a task leaves its robot before it is done, or did so last."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    NONE = ""
    FAILED = "failed"
    LATE = "late"
    LOST = "lost"
    TAKEN = "taken"
    STOPPED = "stopped"
    REFUSED = "refused"
    PAUSED = "paused"
    CANCELLED = "cancelled"
    WITHDRAWN = "withdrawn"
    """Its robot is not to be used any more."""
    EXPIRED = "expired"
    RESTARTED = "restarted"
    INTERRUPTED = "interrupted"
    """ROSIC stood still while its robot moved: what was meant then need not be meant now."""


HELD: Final = frozenset({TaskState.ASSIGNED, TaskState.RUNNING})
"""States in which a task has a robot, and nobody else has it."""
OVER: Final = frozenset({TaskState.DONE, TaskState.CANCELLED})
RESTING: Final = frozenset({TaskState.PAUSED, TaskState.FAILED, TaskState.UNKNOWN})
"""States that only a person ends."""


class TaskNeed(msgspec.Struct, frozen=True, array_like=True):
    """What has to be so before a robot is asked. That it is idle is always needed.

    Attributes:
        battery: At least so many percent; 0 asks nothing. A robot that does not say has too little.
        localised: It knows where it is.
    """

    battery: float = 0.0
    localised: bool = False


class TaskDeadline(msgspec.Struct, frozen=True, array_like=True):
    """By when a task of a mission is to be done. Zero never passes.

    Attributes:
        lasts_ns: It may take so long since it could begin.
        at_ns: Wall clock; all of its mission is to be done then.
        cancels: If its own passes, the rest of the mission is cancelled.
        cancels_all: If that of the mission passes, likewise.
        said: That its own has passed was said.
        said_all: That the mission's has passed was said, with this task.
    """

    lasts_ns: int = 0
    at_ns: int = 0
    cancels: bool = False
    cancels_all: bool = False
    said: bool = False
    said_all: bool = False


class Task(msgspec.Struct, frozen=True, kw_only=True):
    """One task. Ids and numbers only: what was said lies in its letter, in its author's container.

    Attributes:
        author: Whose rights count for every attempt, at that moment.
        among: Robots that can carry it out, in the order in which they were named.
        wanted: A robot's id, a group's name, or empty for any that can.
        steps: How many there are; each is one order.
        skills: Of the steps, for those who may not read what was said.
        priority: 0 to 9; higher goes first.
        given_ns: Wall clock.
        until_ns: Wall clock; not begun later, but seen through once a step is done. 0 never passes.
        expected_ns: How long one step may take before the robot counts as late; 0: no matter.
        once: A step that may have been carried out is not repeated by itself.
        place: Where it is, in m, for choosing the nearest; None when nothing says so.
        mission: Id of the mission it belongs to; empty for none.
        after: Tasks that have to be done first.
        due: By when.
        robot: Who has it; empty unless it is assigned or running.
        attempt: Number of the newest attempt; with the task it is the identity of an order.
        asked: Which step the newest attempt is about, counted from 0.
        done: How many steps are done; never falls.
        why: Why it leaves its robot now, or left the last.
        leaving: Its robot is being brought to rest, or cut off for good.
        tried: Robots that are not asked again.
        moves: How often it went from a robot back to the others.
        since_ns: Wall clock of the newest change.
    """

    id: TaskId
    author: PrincipalId
    among: tuple[RobotId, ...]
    wanted: str = ""
    steps: int = 1
    skills: tuple[str, ...] = ()
    priority: int = 1
    given_ns: int = 0
    until_ns: int = 0
    expected_ns: int = 0
    once: bool = False
    need: TaskNeed = TaskNeed()
    place: tuple[float, float] | None = None
    mission: str = ""
    after: tuple[TaskId, ...] = ()
    due: TaskDeadline = TaskDeadline()
    state: TaskState = TaskState.QUEUED
    robot: RobotId = ""
    attempt: int = 0
    asked: int = 0
    done: int = 0
    why: TaskReason = TaskReason.NONE
    leaving: bool = False
    tried: tuple[RobotId, ...] = ()
    moves: int = 0
    since_ns: int = 0

    def __post_init__(self) -> None:
        if not self.among:
            raise ValueError("a task needs a robot that can carry it out")
        if not 1 <= self.steps <= STEPS_AT_MOST or not 0 <= self.done <= self.steps:
            raise ValueError(f"a task has 1 to {STEPS_AT_MOST} steps")
        if (self.state in HELD) != bool(self.robot):
            raise ValueError("a task has a robot exactly while it is assigned or running")

    @property
    def over(self) -> bool:
        """Whether nothing will come of it any more."""
        return self.state in OVER

    def too_late(self, now_ns: int) -> bool:
        """Whether it may not be begun any more, wall clock."""
        return bool(self.until_ns) and now_ns > self.until_ns and not self.done

    @property
    def left(self) -> tuple[RobotId, ...]:
        """Return whom it may still be given to."""
        return tuple(robot for robot in self.among if robot not in self.tried)


def idle_first(tasks: Iterable[Task]) -> list[Task]:
    """Return tasks that are to be held, so that none gets a robot that another has just left."""
    return sorted(tasks, key=lambda task: task.state in HELD)


class FleetMembership(enum.Enum):
    """Whether a robot is part of the fleet."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    ACTIVE = "active"
    DISABLED = "disabled"
    RETIRED = "retired"
