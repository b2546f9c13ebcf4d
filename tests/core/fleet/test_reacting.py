"""Single turns in the life of a task that a history once got wrong."""

from __future__ import annotations

from rosic.core.fleet import events as e
from rosic.core.fleet.state import FleetState
from rosic.core.fleet.task import Task, TaskReason, TaskState
from rosic.core.fleet.transitions import react


def fleet_after(*events: e.Event) -> FleetState:
    fleet = FleetState()
    for event in events:
        for fact in fleet.facts(react(fleet, event, 1)):
            fleet.apply(fact)
    return fleet


def test_a_step_that_was_counted_is_not_in_doubt_after_a_crash() -> None:
    fleet = fleet_after(
        e.TaskGiven(Task(id="1", author="ann", among=("r1", "r2"))),
        e.RobotChosen("1", "r1"),
        e.AttemptBegun("1", 1),
        e.RobotDeviated("1", 1, TaskReason.LOST),
        e.AttemptEnded("1", 1, e.AttemptEnd.DONE),
        e.TaskFound("1", None),
    )
    assert fleet.tasks["1"].state is TaskState.DONE


def test_a_counted_step_of_several_is_not_done_again_after_a_crash() -> None:
    fleet = fleet_after(
        e.TaskGiven(Task(id="1", author="ann", among=("r1", "r2"), steps=2)),
        e.RobotChosen("1", "r1"),
        e.RobotDeviated("1", 1, TaskReason.LATE),
        e.AttemptEnded("1", 1, e.AttemptEnd.DONE),
        e.TaskFound("1", None),
    )
    task = fleet.tasks["1"]
    assert (task.state, task.done) == (TaskState.QUEUED, 1)
