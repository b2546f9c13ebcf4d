"""The whole of what a fleet does by itself: an event in, what follows from it out.

An event about an attempt that is not the newest changes nothing: what comes late, twice or after
its robot was cut off finds a task that has moved on.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.fleet import events as e
from rosic.core.fleet.task import (
    HELD,
    MOVES_AT_MOST,
    OVER,
    RESTING,
    FleetMembership,
    Task,
    TaskReason,
    TaskState,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.fleet.state import FleetState

_LEAVES = {
    e.AttemptEnd.FAILED: TaskReason.FAILED,
    e.AttemptEnd.UNKNOWN: TaskReason.LOST,
    e.AttemptEnd.STOPPED: TaskReason.STOPPED,
    e.AttemptEnd.INTERRUPTED: TaskReason.INTERRUPTED,
}
# Nothing moves, or whoever has the robot now has seen it at rest.
_LEFT = {
    e.AttemptEnd.TAKEN: TaskReason.TAKEN,
    e.AttemptEnd.REFUSED: TaskReason.REFUSED,
    e.AttemptEnd.SHUT_DOWN: TaskReason.RESTARTED,
}
_RESTS_AS = {
    TaskReason.PAUSED: TaskState.PAUSED,
    TaskReason.STOPPED: TaskState.PAUSED,
    TaskReason.INTERRUPTED: TaskState.PAUSED,
    TaskReason.RESTARTED: TaskState.PAUSED,
    TaskReason.CANCELLED: TaskState.CANCELLED,
}
_EXCLUDED = frozenset({TaskReason.FAILED, TaskReason.LATE, TaskReason.LOST, TaskReason.REFUSED})
_IN_DOUBT = frozenset(
    {TaskReason.LATE, TaskReason.LOST, TaskReason.FAILED, TaskReason.TAKEN, TaskReason.WITHDRAWN}
)
_OF_ATTEMPTS = (e.AttemptBegun, e.AttemptEnded, e.RobotDeviated, e.RobotRested)


def react(fleet: FleetState, event: e.Event, now_ns: int) -> e.Transition:
    """Return what follows from an event. Nothing is changed here.

    Args:
        fleet: As it is now.
        event: What happened. One that does not fit how things are has no consequences.
        now_ns: Wall clock.
    """
    if isinstance(event, e.TaskGiven):
        known = event.task.id in fleet.tasks
        return e.NOTHING if known else e.Transition(tasks=(replace(event.task, since_ns=now_ns),))
    if isinstance(event, e.MembershipSet):
        return _stood(fleet, event, now_ns)
    task = fleet.tasks.get(event.task)
    if task is None:
        return e.NOTHING
    if isinstance(event, _OF_ATTEMPTS) and not _newest(task, event.attempt):
        return e.NOTHING
    return _OF[type(event)](fleet, task, event, now_ns)


def _newest(task: Task, attempt: int) -> bool:
    return attempt == task.attempt and task.state in HELD


# ---- a robot is chosen, and begins ----


def _chosen(fleet: FleetState, task: Task, event: e.RobotChosen, now_ns: int) -> e.Transition:
    robot = event.robot
    fits = (
        task.state is TaskState.QUEUED
        and robot in task.left
        and robot not in fleet.holds
        and fleet.standing(robot) is FleetMembership.ACTIVE
        and fleet.ready(task)
        and not task.too_late(now_ns)
    )
    return _begin(task, robot, now_ns) if fits else e.NOTHING


def _begin(task: Task, robot: str, now_ns: int) -> e.Transition:
    """Give a task to a robot, or go on with its next step there."""
    after = replace(
        task,
        state=TaskState.ASSIGNED,
        robot=robot,
        attempt=task.attempt + 1,
        asked=task.done,
        why=TaskReason.NONE,
        leaving=False,
        since_ns=now_ns,
    )
    doing = e.BeginAttempt(task.id, robot, after.attempt, task.done)
    return e.Transition(tasks=(after,), doings=(doing,))


def _begun(_fleet: FleetState, task: Task, _event: e.AttemptBegun, now_ns: int) -> e.Transition:
    if task.state is not TaskState.ASSIGNED:
        return e.NOTHING
    after = replace(task, state=TaskState.RUNNING, since_ns=now_ns)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


# ---- it ends, or ought to ----


def _ended(fleet: FleetState, task: Task, event: e.AttemptEnded, now_ns: int) -> e.Transition:
    end = event.end
    if end is e.AttemptEnd.DONE:
        return _step_done(task, now_ns)
    if task.leaving:
        return e.NOTHING  # it is being brought to rest already, and goes on from there
    if end is e.AttemptEnd.BUSY:
        return e.Transition(tasks=(_free(task, TaskState.QUEUED, now_ns),))
    if end is e.AttemptEnd.SENT:
        return _doubted(task, task.why, now_ns)
    if end in _LEFT:
        return _left(fleet, task, _LEFT[end], now_ns)
    return _leave(task, _LEAVES[end], now_ns)


def _step_done(task: Task, now_ns: int) -> e.Transition:
    """Count a step, once: later attempts are about later steps."""
    if task.done != task.asked:
        return e.NOTHING
    after = replace(task, done=task.done + 1, since_ns=now_ns)
    if task.leaving:  # told just before its robot was at rest: nobody does this step again
        return e.Transition(tasks=(after,))
    if after.done == task.steps:
        over = _free(after, TaskState.DONE, now_ns)
        return e.Transition(tasks=(over,), doings=(e.TaskChanged(task, over),))
    return _begin(after, task.robot, now_ns)


def _deviated(_fleet: FleetState, task: Task, event: e.RobotDeviated, now_ns: int) -> e.Transition:
    return e.NOTHING if task.leaving else _leave(task, event.why, now_ns)


def _leave(task: Task, why: TaskReason, now_ns: int) -> e.Transition:
    """Take a task from its robot: first that one comes to rest, or is cut off for good."""
    after = replace(task, why=why, leaving=True, since_ns=now_ns)
    recall = e.RecallAttempt(task.id, task.robot, task.attempt, why)
    return e.Transition(tasks=(after,), doings=(recall, e.TaskChanged(task, after)))


def _rested(fleet: FleetState, task: Task, _event: e.RobotRested, now_ns: int) -> e.Transition:
    return _left(fleet, task, task.why, now_ns) if task.leaving else e.NOTHING


def _left(fleet: FleetState, task: Task, why: TaskReason, now_ns: int) -> e.Transition:
    """Settle what becomes of a task whose robot does nothing for it any more."""
    after = _settled(fleet, task, why, now_ns)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


def _doubted(task: Task, why: TaskReason, now_ns: int) -> e.Transition:
    after = replace(_free(task, TaskState.UNKNOWN, now_ns), why=why)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


def _settled(fleet: FleetState, task: Task, why: TaskReason, now_ns: int) -> Task:
    if task.done == task.steps:
        return _free(task, TaskState.DONE, now_ns)
    if why in _RESTS_AS:
        return replace(_free(task, _RESTS_AS[why], now_ns), why=why)
    if task.once and why in _IN_DOUBT:
        return replace(_free(task, TaskState.UNKNOWN, now_ns), why=why)
    tried = (*task.tried, task.robot) if why in _EXCLUDED else task.tried
    after = replace(
        _free(task, TaskState.QUEUED, now_ns), why=why, tried=tried, moves=task.moves + 1
    )
    if after.moves > MOVES_AT_MOST or not _anybody(fleet, after):
        return replace(after, state=TaskState.FAILED)
    return after


def _anybody(fleet: FleetState, task: Task) -> bool:
    """Whether a robot is left that might do it, if not now."""
    return any(fleet.standing(robot) is not FleetMembership.RETIRED for robot in task.left)


def _free(task: Task, state: TaskState, now_ns: int) -> Task:
    """Return a task that has no robot any more."""
    return replace(task, state=state, robot="", leaving=False, since_ns=now_ns)


# ---- people ----


def _held(_fleet: FleetState, task: Task, event: e.TaskHeld, now_ns: int) -> e.Transition:
    cancelled = event.why is TaskReason.CANCELLED
    if task.state in HELD:
        if task.leaving and not cancelled:
            return e.NOTHING
        if task.leaving:  # on its way out already: only where it goes changes
            after = replace(task, why=TaskReason.CANCELLED, since_ns=now_ns)
            return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))
        return _leave(task, event.why, now_ns)
    if task.state in OVER or (not cancelled and task.state is not TaskState.QUEUED):
        return e.NOTHING
    state = TaskState.CANCELLED if cancelled else TaskState.PAUSED
    after = replace(task, state=state, why=event.why, since_ns=now_ns)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


def _released(_fleet: FleetState, task: Task, event: e.TaskReleased, now_ns: int) -> e.Transition:
    if task.state not in RESTING:
        return e.NOTHING
    skip = event.skip and task.state is TaskState.UNKNOWN
    after = replace(
        task,
        state=TaskState.QUEUED,
        why=TaskReason.NONE,
        tried=(),
        moves=0,
        since_ns=now_ns,
        done=task.done + skip,
    )
    if after.done == task.steps:
        after = replace(after, state=TaskState.DONE)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


def _expired(_fleet: FleetState, task: Task, _event: e.TaskExpired, now_ns: int) -> e.Transition:
    if task.state is not TaskState.QUEUED or not task.too_late(now_ns):
        return e.NOTHING
    after = replace(task, state=TaskState.FAILED, why=TaskReason.EXPIRED, since_ns=now_ns)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


def _overdue(fleet: FleetState, task: Task, event: e.TaskOverdue, _now_ns: int) -> e.Transition:
    """Note that it was said: once a task, and once for all of a mission."""
    due = task.due
    known = due.said
    if event.whole:
        known = due.said_all or any(other.due.said_all for other in fleet.mission(task.mission))
    if task.over or known:
        return e.NOTHING
    noted = replace(due, said_all=True) if event.whole else replace(due, said=True)
    after = replace(task, due=noted)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


def _handed(_fleet: FleetState, task: Task, event: e.TaskHanded, now_ns: int) -> e.Transition:
    if task.over:
        return e.NOTHING
    return e.Transition(tasks=(replace(task, author=event.author, since_ns=now_ns),))


def _stood(fleet: FleetState, event: e.MembershipSet, now_ns: int) -> e.Transition:
    """Let a robot take part or not; what it has is taken from it first."""
    if fleet.standing(event.robot) is event.standing:
        return e.NOTHING
    standings = ((event.robot, event.standing),)
    task = fleet.tasks.get(fleet.holds.get(event.robot, ""))
    if event.standing is FleetMembership.ACTIVE or task is None or task.leaving:
        return e.Transition(standings=standings)
    return replace(_leave(task, TaskReason.WITHDRAWN, now_ns), standings=standings)


# ---- after an interruption ----


def _found(fleet: FleetState, task: Task, event: e.TaskFound, now_ns: int) -> e.Transition:
    """Settle a task that had a robot when the last run ended. No robot begins because of it."""
    if task.state not in HELD:
        return e.NOTHING
    counted = task.done > task.asked  # told, and on disk, before the run ended
    if event.end in {None, e.AttemptEnd.UNKNOWN, e.AttemptEnd.SENT} and not counted:
        return _doubted(task, TaskReason.RESTARTED, now_ns)
    if event.end in {e.AttemptEnd.BUSY, e.AttemptEnd.REFUSED} and not task.leaving:
        after = _free(task, TaskState.QUEUED, now_ns)  # nothing was claimed: it waits as before
    else:
        counts = event.end is e.AttemptEnd.DONE and task.done == task.asked
        why = task.why if task.leaving else TaskReason.RESTARTED
        after = _settled(fleet, replace(task, done=task.done + counts), why, now_ns)
    return e.Transition(tasks=(after,), doings=(e.TaskChanged(task, after),))


_OF: dict[type, Callable[..., e.Transition]] = {
    e.RobotChosen: _chosen,
    e.AttemptBegun: _begun,
    e.AttemptEnded: _ended,
    e.RobotDeviated: _deviated,
    e.RobotRested: _rested,
    e.TaskHeld: _held,
    e.TaskReleased: _released,
    e.TaskExpired: _expired,
    e.TaskOverdue: _overdue,
    e.TaskHanded: _handed,
    e.TaskFound: _found,
}
