"""Missions from the chat: started, paused, gone on with, cancelled, each step once."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.fleet.mission import Mission, MissionPart
from rosic.core.fleet.task import TaskState
from rosic.core.order import OrderEnding
from rosic.stores.memory import MemoryStore
from tests.features.fleet.test_tasks import heard, tasks, warehouse, worker
from tests.gateway.place import BO, VI, Place, WritingStore

if TYPE_CHECKING:
    from rosic.core.records import Record

RESTOCK = Mission(
    name="restock",
    title="Restock an aisle",
    do=(
        MissionPart(on="warehouse", steps=("move 1 m", "wave")),
        MissionPart(
            together=(MissionPart(on="w2", steps=("wave",)), MissionPart(on="any", steps=("wave",)))
        ),
    ),
)


def lab(store: MemoryStore | None = None) -> Place:
    here = warehouse(store)
    loud = Mission(name="loud", do=(MissionPart(on="w1", steps=("wave",)),))
    here.gateway._settings = replace(here.gateway._settings, missions=(RESTOCK, loud))
    return here


def states(here: Place) -> list[TaskState]:
    return [task.state for task in tasks(here).values()]


async def test_what_follows_waits_and_what_is_side_by_side_runs_side_by_side() -> None:
    async with lab().open() as here:
        told = await here.say("/mission start restock")
        assert "Restock an aisle is begun as restock-1 · 3 tasks" in told
        assert states(here) == [TaskState.RUNNING, TaskState.QUEUED, TaskState.QUEUED]
        assert "after 1" in await here.say("/tasks")
        for _ in range(2):
            worker(here, "w1").end(OrderEnding.DONE)
            await heard(here)
        assert states(here) == [TaskState.DONE, TaskState.RUNNING, TaskState.RUNNING]
        assert tasks(here)["2"].robot == "w2"
        assert "restock-1: 1 of 3 tasks done" in await here.say("/missions")
        worker(here, "w2").end(OrderEnding.DONE)
        worker(here, tasks(here)["3"].robot).end(OrderEnding.DONE)
        await heard(here)
        assert states(here) == [TaskState.DONE] * 3
        assert "No mission called restock is under way" in await here.say("/mission cancel restock")


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ("", ""),
        ("/robot retire w2", "This is not what was shown any more"),
        ("/grant Vi viewer w1 for 2h", "The rules here have changed since you were asked"),
    ],
)
async def test_a_mission_begins_by_a_button_as_it_was_shown_or_not_at_all(
    changed: str, why: str
) -> None:
    """What a tap agrees to is every step of every robot that may carry it out (I16)."""
    async with lab().open() as here:
        await here.say("/mission restock")
        button = here.button("Start restock")
        if changed:
            await here.say(changed)
        told = await here.tap(*button)
        assert why in told
        assert len(tasks(here)) == (0 if why else 3)


async def test_it_is_paused_gone_on_with_and_cancelled_as_one() -> None:
    async with lab().open() as here:
        await here.say("/mission start restock")
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        await here.say("/mission pause restock")
        await heard(here)
        assert states(here) == [TaskState.PAUSED] * 3
        assert here.robot("w1").presence().doing == ""
        await here.say("/mission go restock-1")
        await heard(here)
        assert states(here)[0] is TaskState.RUNNING
        assert tasks(here)["1"].done == 1, "the first step is not done again"
        await here.say("/mission cancel restock")
        await heard(here)
        assert states(here) == [TaskState.CANCELLED] * 3


async def test_a_failed_task_is_taken_over_and_only_what_is_left_is_done() -> None:
    async with lab().open() as here:
        await here.say("/mission start restock")
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        worker(here, "w1").end(OrderEnding.FAILED)
        await heard(here, 2)
        task = tasks(here)["1"]
        assert (task.done, task.moves) == (1, 1)
        worker(here, task.robot).end(OrderEnding.DONE)
        await heard(here)
        assert tasks(here)["1"].state is TaskState.DONE
        assert sum(here.acted(name) for name in ("w1", "w2", "w3")) >= 3


async def test_nobody_starts_or_ends_what_they_may_not() -> None:
    async with lab().open() as here:
        assert "Nobody of warehouse can do task 1" in await here.say(
            "/mission start restock", account=VI
        )
        assert not tasks(here)
        await here.say("/mission start restock")
        assert "is Ada's" in await here.say("/mission cancel restock", account=BO)
        assert "I know no mission called dance" in await here.say("/mission start dance")
        assert "w1: wave" in await here.say("/mission loud")


async def test_it_begins_by_itself_at_its_time_once_each_time() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        told = await here.say("/mission start loud in 2 min")
        assert "1: loud begins by itself, " in told
        await heard(here, 60)
        assert not tasks(here)
        told = await heard(here, 90)
        assert "loud is begun as loud-1 · one task" in told
        assert here.acted("w1") == 1
        await heard(here, 200)
        assert len(tasks(here)) == 1
        assert "That time is over" in await here.say("/mission start loud 2020-01-01 10:00")
        worker(here, "w1").end(OrderEnding.DONE)
        await here.say("/mission start loud every day 8:00")
        assert "loud begins by itself, next " in await here.say("/missions")
        for _ in range(2):
            here.clock.jump_wall(86_400)
            await heard(here, 5)
        assert len(tasks(here)) <= 2, "what was slept through is left out"
    here = lab(store)
    here.clock.jump_wall(2 * 86_400 + 400)
    async with here.open():
        assert "loud begins by itself, next " in await here.say("/missions")
        assert "has planned that" in await here.say("/mission off 1", account=BO)
        assert "does not begin by itself any more" in await here.say("/mission off 1")
        assert "begins by itself" not in await here.say("/missions")


async def test_what_is_planned_begins_only_while_whoever_planned_it_may() -> None:
    async with lab().open() as here:
        await here.say("/mission start loud in 1 min", account=BO)
        await here.say("/lock Bo")
        told = await heard(here, 90, account=BO)
        assert "loud was to begin now, and does not." in told
        assert here.acted("w1") == 0


class SlowDisk(WritingStore):
    """Each write takes some turns of the event loop."""

    async def write(self, *records: Record) -> None:
        for _ in range(5):
            await asyncio.sleep(0)
        await super().write(*records)


async def test_no_robot_begins_because_what_it_did_was_held_before_the_rest() -> None:
    for verb in ("cancel", "pause"):
        here, priorities = warehouse(SlowDisk()), (9, *[1] * 8, 5)
        parts = tuple(MissionPart(on="w1", steps=("wave",), priority=n) for n in priorities)
        queue = Mission(name="queue", do=(MissionPart(together=parts),))
        here.gateway._settings = replace(here.gateway._settings, missions=(queue,))
        async with here.open():
            await here.say("/mission start queue")
            await heard(here)
            assert here.acted("w1") == 1
            here.chat.say(f"/mission {verb} queue")
            for _ in range(500):
                await asyncio.sleep(0)
            await heard(here, 3)
            assert not {TaskState.QUEUED, TaskState.RUNNING}.intersection(states(here))
            assert here.acted("w1") == 1, "nothing of it moves any more"
