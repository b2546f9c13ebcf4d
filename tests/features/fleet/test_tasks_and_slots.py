"""Booked times and fleets together: who may have a task done by which robot, and when."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet.task import TaskState
from tests.features.fleet.test_tasks import WAREHOUSE, heard, tasks, warehouse
from tests.gateway.place import BO

if TYPE_CHECKING:
    from tests.gateway.place import Place

TWO = WAREHOUSE[:2]


def stands(here: Place) -> dict[str, tuple[TaskState, str]]:
    return {number: (task.state, task.robot) for number, task in tasks(here).items()}


async def test_in_somebodys_time_a_robot_is_given_their_tasks_alone() -> None:
    async with warehouse(fleet=TWO).open() as here:
        await here.say("/book w1 now 30 min", account=BO)
        await here.say("/task w1 wave")
        await here.say("/task warehouse wave")
        await heard(here, 20)
        assert stands(here) == {"1": (TaskState.QUEUED, ""), "2": (TaskState.RUNNING, "w2")}
        assert "1: wave · w1 · waiting" in await here.say("/tasks")
        await here.say("/task w1 move 1 m", account=BO)
        assert stands(here)["3"] == (TaskState.RUNNING, "w1"), "it is Bo's time"
        assert here.acted("w1") == 1

        await here.clock.advance(30 * 60)
        await heard(here, 5)
        assert stands(here)["1"] == (TaskState.RUNNING, "w1"), "Bo's time is over"
        assert stands(here)["3"] == (TaskState.QUEUED, ""), "at rest, and given back"


async def test_a_task_leaves_its_robot_at_rest_when_somebody_elses_time_begins() -> None:
    async with warehouse(fleet=TWO).open() as here:
        await here.say("/task w1 wave")
        await here.say("/task warehouse wave")
        await here.say("/book w1 in 2 min 30 min", account=BO)
        told = await heard(here, 150)
        assert "stopped before it ended" in told
        assert "somebody else's time has begun" in told
        assert "Task 1 (wave): w1 was needed for something else. The task waits for w1." in told
        assert stands(here) == {"1": (TaskState.QUEUED, ""), "2": (TaskState.RUNNING, "w2")}
        assert tasks(here)["1"].moves == 1
        await here.say("w1 wave", account=BO)
        assert here.gateway.rooms.linker.current("w1") is not None
        await heard(here, 20)
        assert here.acted("w1") == 2, "the task once, and Bo"
