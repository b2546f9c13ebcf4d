"""After a motion was broken off nothing begins again by itself: no queue, no task (I6)."""

from __future__ import annotations

import pytest

from rosic.core.deadman import INTERRUPTED, STOOD_STILL
from rosic.core.fleet.task import TaskState
from rosic.core.order import OrderEnding, Outcome
from rosic.core.robot.profile import Busy
from tests.features.fleet.test_tasks import heard, tasks, warehouse, worker
from tests.gateway.place import profile


@pytest.mark.parametrize(
    "ends",
    [
        Outcome(OrderEnding.FAILED, "drove for 3.0 s", code=STOOD_STILL),
        Outcome(OrderEnding.CANCELLED, "link lost, holding", code=INTERRUPTED),
        Outcome(OrderEnding.UNKNOWN, "w9 has not answered."),
    ],
)
async def test_what_waits_behind_a_motion_that_was_broken_off_is_not_done(ends: Outcome) -> None:
    async with warehouse(fleet=(profile("w9", busy=Busy.QUEUE),)).open() as here:
        await here.say("w9 move 1 m")
        await here.say("w9 move 2 m")
        robot = worker(here, "w9")
        robot.ends = ends
        robot.finish()
        told = await heard(here)
        assert here.acted("w9") == 1, "it went on by itself"
        assert "What came before this was broken off, so this was not done." in told
        await here.say("w9 move 1 m")
        assert here.acted("w9") == 2, "a new command moves it"


async def test_a_task_waits_for_a_person_when_rosic_stood_still() -> None:
    async with warehouse().open() as here:
        await here.say("/task warehouse move 1 m then wave")
        robot = worker(here, "w1")
        robot.ends = Outcome(OrderEnding.FAILED, "drove for 3.0 s", code=STOOD_STILL)
        robot.finish()
        told = await heard(here, 30)
        assert "ROSIC itself stood still" in told
        assert tasks(here)["1"].state is TaskState.PAUSED
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [1, 0, 0]


async def test_a_task_that_the_robots_own_side_ended_does_not_come_back_to_it() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 move 1 m")
        robot = worker(here, "w1")
        robot.ends = Outcome(OrderEnding.CANCELLED, "link lost, holding", code=INTERRUPTED)
        robot.finish()
        await heard(here, 30)
        assert tasks(here)["1"].state is TaskState.FAILED
        assert here.acted("w1") == 1
