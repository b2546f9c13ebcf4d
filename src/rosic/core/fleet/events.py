"""What happens to a fleet, and what is to be done about it."""

from __future__ import annotations

import enum
from typing import TypeAlias

import msgspec

from rosic.core.fleet.task import FleetMembership, Task, TaskId, TaskReason
from rosic.core.robot.profile import RobotId


class AttemptEnd(enum.Enum):
    """How an attempt ended, as far as a fleet cares."""

    __hash__ = object.__hash__  # Enum hashes the name, in Python, every time

    DONE = "done"
    FAILED = "failed"
    STOPPED = "stopped"
    """Somebody stopped the robot: they meant it, so the task goes nowhere else by itself."""
    TAKEN = "taken"
    """Somebody has the robot now; whoever took it has seen it at rest."""
    BUSY = "busy"
    """Not admitted, and no robot has moved: it may be otherwise in a while."""
    REFUSED = "refused"
    """Not admitted, and no robot has moved: this robot will not be asked again."""
    UNKNOWN = "unknown"
    """It may or may not have been carried out."""
    SENT = "sent"
    """It was sent, and this robot never says what came of it."""
    SHUT_DOWN = "shut down"
    INTERRUPTED = "interrupted"
    """ROSIC stood still meanwhile, so the motion was ended: no robot goes on with it by itself."""


# ---- what happened ----


class TaskGiven(msgspec.Struct, frozen=True):
    """Somebody gave a task."""

    task: Task


class RobotChosen(msgspec.Struct, frozen=True):
    """A robot was chosen for a task that waits."""

    task: TaskId
    robot: RobotId


class AttemptBegun(msgspec.Struct, frozen=True):
    """The order of an attempt is on disk."""

    task: TaskId
    attempt: int


class AttemptEnded(msgspec.Struct, frozen=True):
    """An attempt is over."""

    task: TaskId
    attempt: int
    end: AttemptEnd


class RobotDeviated(msgspec.Struct, frozen=True):
    """A robot does not do as it should: it is late, or was not heard of for too long."""

    task: TaskId
    attempt: int
    why: TaskReason


class RobotRested(msgspec.Struct, frozen=True):
    """The robot that a task leaves is at rest, or nothing that it does counts any more."""

    task: TaskId
    attempt: int


class TaskHeld(msgspec.Struct, frozen=True):
    """Somebody wants a task paused or cancelled."""

    task: TaskId
    why: TaskReason


class TaskReleased(msgspec.Struct, frozen=True):
    """Somebody wants a task to go on that is paused, has failed, or is in doubt.

    Attributes:
        skip: The step in doubt was done: go on with the next.
    """

    task: TaskId
    skip: bool = False


class TaskExpired(msgspec.Struct, frozen=True):
    """A task was not begun in time."""

    task: TaskId


class TaskOverdue(msgspec.Struct, frozen=True):
    """A task is not done by when it was to be.

    Attributes:
        whole: It is the deadline of all of its mission.
    """

    task: TaskId
    whole: bool


class MembershipSet(msgspec.Struct, frozen=True):
    """Somebody lets a robot take part, or not."""

    robot: RobotId
    standing: FleetMembership


class TaskHanded(msgspec.Struct, frozen=True):
    """Somebody else looks after a task from now on."""

    task: TaskId
    author: str


class TaskFound(msgspec.Struct, frozen=True):
    """A task that had a robot when the last run ended, and what is known of its order.

    Attributes:
        end: None: it was claimed, and nobody saw its end.
    """

    task: TaskId
    end: AttemptEnd | None


Event: TypeAlias = (
    TaskGiven
    | RobotChosen
    | AttemptBegun
    | AttemptEnded
    | RobotDeviated
    | RobotRested
    | TaskHeld
    | TaskReleased
    | TaskExpired
    | TaskOverdue
    | MembershipSet
    | TaskHanded
    | TaskFound
)


# ---- what is to be done ----


class BeginAttempt(msgspec.Struct, frozen=True):
    """Ask a robot for the next step, as an order like any other."""

    task: TaskId
    robot: RobotId
    attempt: int
    step: int


class RecallAttempt(msgspec.Struct, frozen=True):
    """End what a robot does for a task, see it at rest or cut it off for good; then say so."""

    task: TaskId
    robot: RobotId
    attempt: int
    why: TaskReason


class TaskChanged(msgspec.Struct, frozen=True):
    """A task has changed in a way that whoever gave it wants to know."""

    before: Task
    after: Task


Doing: TypeAlias = BeginAttempt | RecallAttempt | TaskChanged


class Transition(msgspec.Struct, frozen=True):
    """What an event makes of a fleet: nothing of it is so before it is written down.

    Attributes:
        tasks, standings: As they are from now on; those not named stay as they are.
        doings: What is to be done once that is so, in order.
    """

    tasks: tuple[Task, ...] = ()
    standings: tuple[tuple[RobotId, FleetMembership], ...] = ()
    doings: tuple[Doing, ...] = ()


NOTHING = Transition()
