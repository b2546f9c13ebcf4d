"""Robots that will not take a task now: others are asked, and nobody is asked without end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet.task import TaskState
from rosic.core.order import OrderEnding
from rosic.errors import RobotBusy
from rosic.features.fleet.dispatch_state import AGAIN_NS, LONGEST_NS, RetryBackoff
from tests.features.fleet.test_tasks import WAREHOUSE, Warehouse, Worker, heard, tasks, worker
from tests.gateway.place import FLEET

if TYPE_CHECKING:
    from rosic.contracts.robot import Tell
    from rosic.core.order import Order, Outcome

FLYING = "already flying. Nothing was done."


class Reluctant(Worker):
    """Refuses like a drone that is asked to take off in the air.

    Attributes:
        willing: It does not.
        asked: How often it was asked.
    """

    willing = True
    asked = 0

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        self.asked += 1
        if not self.willing:
            raise RobotBusy(FLYING)
        return await super().execute(order, tell)


class Airfield(Warehouse):
    kind = Reluctant


def airfield() -> Airfield:
    return Airfield(fleet=(*WAREHOUSE, FLEET[0]))


def drone(here: Airfield, name: str) -> Reluctant:
    found = worker(here, name)
    assert isinstance(found, Reluctant)
    return found


async def test_a_robot_that_refuses_keeps_no_task_from_one_that_would_take_it() -> None:
    async with airfield().open() as here:
        drone(here, "w1").willing = drone(here, "w2").willing = False
        await here.say("/task warehouse wave")
        await heard(here, 10)
        assert (tasks(here)["1"].state, tasks(here)["1"].robot) == (TaskState.RUNNING, "w3")
        assert (drone(here, "w1").asked, drone(here, "w2").asked) == (1, 1)


async def test_who_goes_on_refusing_is_asked_ever_more_seldom() -> None:
    async with airfield().open() as here:
        drone(here, "w1").willing = False
        await here.say("/task w1 wave")
        for _ in range(300):
            await here.clock.advance(2)
        assert 5 <= drone(here, "w1").asked <= 9, "somebody reads of each time"
        assert tasks(here)["1"].state is TaskState.QUEUED
        drone(here, "w1").willing = True
        await here.say("/task pause 1")
        await here.say("/task go 1", message="go")
        await heard(here, 1)
        assert tasks(here)["1"].state is TaskState.RUNNING, "a person says so: it is asked at once"


async def test_what_it_refuses_keeps_no_robot_from_what_it_can_do() -> None:
    async with airfield().open() as here:
        drone(here, "w1").willing = False
        await here.say("/task w1 wave")
        await heard(here, 10)
        drone(here, "w1").willing = True
        await here.say("/task w1 move 1 m")
        await heard(here, 3)
        assert {key: task.state for key, task in tasks(here).items()} == {
            "1": TaskState.QUEUED,
            "2": TaskState.RUNNING,
        }
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here, 60)
        assert tasks(here)["1"].state is TaskState.RUNNING, "it is asked again by itself"


def test_patience_grows_to_its_bound_and_ends_with_the_task() -> None:
    patience, now_ns, waits = RetryBackoff(), 0, []
    for _ in range(12):
        patience.refused("1", "w1", now_ns)
        began_ns = now_ns
        while patience.declined("w1", now_ns):
            now_ns += AGAIN_NS // 2
        waits.append(now_ns - began_ns)
    assert waits == sorted(waits)
    assert waits[0] > 2 * AGAIN_NS, "other robots come first"
    assert waits[-1] == LONGEST_NS
    patience.refused("1", "w1", now_ns)
    assert patience.not_now(now_ns) == (frozenset({"1"}), frozenset({"w1"}))
    patience.forget("1")
    assert not patience.declined("w1", now_ns)
    assert not patience.declined("w2", now_ns)
