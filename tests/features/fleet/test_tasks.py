"""Tasks given in a chat: carried out by orders like any other, moved when a robot fails, told."""

from __future__ import annotations

from copy import deepcopy
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.fleet.state import TASK
from rosic.core.fleet.task import TaskState
from rosic.core.order import OrderEnding, Outcome
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules, SkillPrecondition
from rosic.core.records import Fact
from rosic.core.robot.profile import Busy
from rosic.core.robot.view import Pose
from rosic.errors import RobotBusy, StoreFault
from rosic.features.fleet import FleetFeature
from rosic.features.fleet.integration import RuleTasks
from rosic.robots.memory import MemoryRobot
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, FLEET, VI, BrokenStore, Place, profile

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.contracts.robot import Tell
    from rosic.core.fleet.task import Task
    from rosic.core.order import Order
    from rosic.core.order_gate import OrderGate
    from rosic.core.records import Record
    from rosic.core.robot.profile import Presence, Profile

WAREHOUSE = tuple(profile(name, groups=("warehouse",)) for name in ("w1", "w2", "w3"))
HOUR_S = 3600.0


class Worker(MemoryRobot):
    """Works until it is told how it ended.

    Attributes:
        moving: It has not come to rest, whatever it does.
    """

    def __init__(self, profile: Profile, gate: OrderGate, clock: Clock) -> None:
        super().__init__(profile, gate, clock)
        self.work_s = HOUR_S
        self.ends: Outcome | None = None
        self.moving = False

    async def execute(self, order: Order, tell: Tell) -> Outcome:
        outcome = await super().execute(order, tell)
        ends, self.ends = self.ends, None
        return outcome if ends is None else ends

    def presence(self) -> Presence:
        seen = super().presence()
        return replace(seen, at_rest=False) if self.moving else seen

    def end(self, ending: OrderEnding, note: str = "") -> None:
        self.ends = Outcome(ending, note)
        self.finish()


class Warehouse(Place):
    kind = Worker


def warehouse(store: MemoryStore | None = None, fleet: tuple[Profile, ...] = WAREHOUSE) -> Place:
    return Warehouse(store, fleet=(*fleet, FLEET[0]))


def later(store: MemoryStore) -> Place:
    """Return the same place an hour later."""
    here = warehouse(store)
    here.clock.jump_wall(HOUR_S)
    return here


def tasks(here: Place) -> dict[str, Task]:
    return here.gateway.features.get(FleetFeature).dispatching.fleet.tasks


def worker(here: Place, name: str) -> Worker:
    found = here.robot(name)
    assert isinstance(found, Worker)
    return found


async def heard(here: Place, seconds: float = 1.0, account: str = ADA) -> str:
    """Let time pass; return what one person was told meanwhile."""
    before = len(here.chat.told)
    for _ in range(max(1, int(seconds / 0.5))):
        await here.clock.advance(0.5)
        await here.quiet()
    return "\n".join(
        told.outbound.text
        for told in list(here.chat.told)[before:]
        if told.outbound.chat.id == account
    )


async def test_a_task_goes_to_a_robot_of_the_group_and_is_told_when_it_is_done() -> None:
    async with warehouse().open() as here:
        told = await here.say("/task warehouse move 1 m then wave")
        assert "Task 1: move 1 m; wave · one of 3 robots" in told
        [task] = tasks(here).values()
        assert (task.state, task.robot, task.done) == (TaskState.RUNNING, "w1", 0)
        assert "w1: move, 1.00 m forward · task 1, step 1 of 2" in await here.say("hm") + told
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        assert tasks(here)["1"].done == 1
        worker(here, "w1").end(OrderEnding.DONE)
        assert "Task 1 (move 1 m; wave): done by w1." in await heard(here)
        assert here.acted("w1") == 2
        assert here.gateway.rooms.organiser.holder("w1") is None, "it was taken for the task alone"
        assert "No task is open." in await here.say("/tasks")
        assert "No robot that you see can do that" in await here.say("/task any dance")


async def test_a_failure_moves_it_once_and_what_is_done_is_not_repeated() -> None:
    async with warehouse().open() as here:
        await here.say("/task warehouse move 1 m then wave")
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        worker(here, "w1").moving = True
        worker(here, "w1").end(OrderEnding.FAILED, "the gripper is open")
        told = await heard(here)
        assert "w1 has failed at it. It is brought to rest first." in told
        assert tasks(here)["1"].robot == "w1", "it is not at rest"
        assert here.acted("w2") == here.acted("w3") == 0
        worker(here, "w1").moving = False
        told = await heard(here)
        assert "The task goes to another robot. 1 of 2 steps are done and stay so." in told
        task = tasks(here)["1"]
        assert (task.state, task.robot in {"w2", "w3"}, task.moves) == (TaskState.RUNNING, True, 1)
        worker(here, task.robot).end(OrderEnding.DONE)
        assert f"done by {task.robot}" in await heard(here)
        assert here.acted("w1") == 2
        assert here.acted("w2") + here.acted("w3") == 1


async def test_a_lost_robot_is_cut_off_and_its_late_answer_counts_for_nothing() -> None:
    async with warehouse().open() as here:
        await here.say("/task warehouse wave")
        lost = worker(here, "w1")
        lost.online = False
        told = await heard(here, 5)
        assert "w1 is not heard of any more" in told
        assert "w1 was not seen at rest: it is stopped" in told
        task = tasks(here)["1"]
        assert task.robot in {"w2", "w3"}
        lost.online = True
        lost.end(OrderEnding.DONE)
        await heard(here)
        assert tasks(here)["1"] == task, "it went on with another"
        assert here.gateway.rooms.stops["w1"].latched
        worker(here, task.robot).end(OrderEnding.DONE)
        assert f"done by {task.robot}" in await heard(here)


async def test_whoever_is_late_is_brought_to_rest_and_another_goes_on() -> None:
    async with warehouse().open() as here:
        await here.say("/task warehouse wave within 20 s")
        assert "too long" not in await heard(here, 19)
        told = await heard(here, 3)
        assert "w1 takes too long" in told
        assert tasks(here)["1"].robot != "w1"
        assert not here.gateway.rooms.stops["w1"].latched
        assert here.robot("w1").presence().doing == ""


async def test_a_stop_is_meant_so_the_task_goes_nowhere_else_by_itself() -> None:
    async with warehouse().open() as here:
        await here.say("/task warehouse wave")
        told = await here.say("stop w1") + await heard(here, 2)
        assert tasks(here)["1"].state is TaskState.PAUSED
        assert "Task 1 (wave): paused." in told
        assert here.acted("w2") == here.acted("w3") == 0
        button, under = here.button("Go on")
        await here.tap(button, under)
        await heard(here)
        assert tasks(here)["1"].robot in {"w2", "w3"}


async def test_a_robot_of_somebody_else_is_not_taken_and_is_given_back_when_a_task_is_over() -> (
    None
):
    async with warehouse(fleet=WAREHOUSE[:1]).open() as here:
        worker(here, "w1").work_s = 1e-9
        await here.say("w1 wave", account=BO)
        await here.say("/task warehouse wave")
        await heard(here, 20)
        assert tasks(here)["1"].state is TaskState.QUEUED, "it is Bo's for half a minute"
        await heard(here, 15)
        assert tasks(here)["1"].state is TaskState.DONE
        organiser = here.gateway.rooms.organiser
        assert organiser.holder("w1") is None


async def test_rights_are_those_of_whoever_gave_it_at_that_moment() -> None:
    async with warehouse().open() as here:
        told = await here.say("/task warehouse wave", account=VI)
        assert "Nobody of warehouse can do that." in told
        await here.say("/task warehouse wave", account=BO)
        told = await here.say("/task cancel 1", account=VI)
        assert "Task 1 is Bo's. They can do that" in told
        assert "w1 is brought to rest" in await here.say("/task cancel 1", account=ADA)
        await heard(here)
        assert tasks(here)["1"].state is TaskState.CANCELLED


async def test_what_makes_no_sense_is_refused_with_what_would() -> None:
    async with warehouse().open() as here:
        assert "no robot and no group called nowhere" in await here.say("/task nowhere wave")
        assert "Nobody of warehouse can do that" in await here.say("/task warehouse dance")
        assert "That time is over" in await here.say("/task warehouse wave by 2020-01-01 10:00")
        assert "takes longer than that" in await here.say("/task w1 wave within 0 s")
        assert "from 0 to 9" in await here.say("/task warehouse wave priority 12")
        assert "at most 5 m" in await here.say("/task w1 move 40 m")
        assert "I know no task 9" in await here.say("/task cancel 9")
        assert "Say what is to be done" in await here.say("/task warehouse")
        assert not tasks(here)


async def test_the_nearest_with_enough_battery_goes() -> None:
    async with warehouse().open() as here:
        for name, x, battery in (("w1", 9.0, 90), ("w2", 1.0, 10), ("w3", 4.0, 50)):
            here.robot(name).pose = Pose(x, 0.0)
            here.robot(name).values = {"battery": battery}
        await here.say("/task warehouse wave battery 30 localised")
        assert tasks(here)["1"].robot == "w1", "way counts only where a task has a place"
        await here.say("/task warehouse wave battery 30 localised")
        await here.say("/task warehouse wave battery 30 localised")
        assert tasks(here)["2"].robot == "w3"
        assert tasks(here)["3"].state is TaskState.QUEUED, "w2 is too empty"


async def test_a_deadline_that_passes_fails_what_waits() -> None:
    busy = tuple(replace(robot, busy=Busy.REFUSE) for robot in WAREHOUSE[:1])
    async with warehouse(fleet=busy).open() as here:
        await here.say("/task w1 wave")
        echo = await here.say("/task w1 wave within 90 s by in 2 min")
        assert "begun by " in echo
        assert ", or not at all" in echo
        assert "a step takes 90 s at most" in echo
        told = await heard(here, 200)
        assert "Task 2 (wave): failed. Why: it was not begun in time." in told


async def test_after_a_crash_what_may_have_been_done_is_said_and_not_repeated() -> None:
    store = MemoryStore()
    async with warehouse(store).open() as here:
        await here.say("/task warehouse wave")
        await here.say("/task w1 wave")
        assert tasks(here)["1"].state is TaskState.RUNNING
        crashed = deepcopy(store)
    async with later(crashed).open() as here:
        assert tasks(here)["1"].state is TaskState.UNKNOWN
        said = "\n".join(told.outbound.text for told in here.chat.told)
        assert "w1: wave · task 1" in said
        assert "It may or may not have been carried out" in said
        assert "not known whether it was done" in await here.say("/task 1")
        assert "Task 1 (wave): done" in await here.say("/task done 1", message="another")
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [0, 0, 0]
        assert tasks(here)["2"].state is TaskState.QUEUED, "w1 is held until somebody has looked"
        await here.say("resume w1")
        await heard(here)
        assert tasks(here)["2"].state is TaskState.RUNNING


async def test_after_an_orderly_end_what_ran_is_paused() -> None:
    store = MemoryStore()
    async with warehouse(store).open() as here:
        await here.say("/task warehouse move 1 m then wave")
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
    async with later(store).open() as here:
        task = tasks(here)["1"]
        assert (task.state, task.done) == (TaskState.PAUSED, 1)
        await here.say("/task go 1", message="another")
        await heard(here)
        assert tasks(here)["1"].state is TaskState.RUNNING
        assert "step 2 of 2" in "\n".join(t.outbound.text for t in here.chat.told)


async def test_whoever_is_locked_lets_no_robot_do_anything() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 wave", account=BO)
        await here.say("/lock Bo")
        await heard(here, 3)
        await here.say("resume w1")
        assert tasks(here)["1"].state is not TaskState.RUNNING
        await here.say("/task go 1")
        await heard(here, 3)
        assert here.acted("w1") == 1
        assert tasks(here)["1"].state is TaskState.FAILED


class Careful(Warehouse):
    rulebook = RoleRules(
        roles=DEFAULT_ROLES, care=(SkillPrecondition(scopes=("w1:wave",), confirm=True),)
    )


async def test_what_wants_a_tap_is_not_given_as_a_task() -> None:
    async with Careful(fleet=WAREHOUSE).open() as here:
        told = await here.say("/task w1 wave")
        assert "w1 does this only when somebody confirms it: Wave. Say it as a command." in told
        await here.say("/task warehouse wave")
        assert tasks(here)["1"].among == ("w2", "w3")


async def test_the_same_message_has_its_effect_once_whatever_crashes_between() -> None:
    store = MemoryStore()
    async with warehouse(store).open() as here:
        await here.say("/task w1 wave", message="m1")
        assert list(tasks(here)) == ["1"]
        crashed = deepcopy(store)
    async with later(crashed).open() as here:
        sent_ns = here.clock.wall_ns()
        await here.say("/task w1 wave", message="m1", sent_ns=sent_ns)
        assert list(tasks(here)) == ["1"]
        await here.say("/task go 1", message="m2")
        await here.say("resume w1")
        await heard(here, 2)
        assert here.acted("w1") == 1
        crashed = deepcopy(crashed)
    async with later(crashed).open() as here:
        here.clock.jump_wall(HOUR_S)
        await here.say("resume w1")
        await here.say("/task go 1", message="m2")
        await heard(here, 2)
        assert here.acted("w1") == 0, "that message was followed before the crash"


class ForgetsTasks(BrokenStore):
    """Writes everything but tasks, once it is asked to."""

    tasks = True

    async def write(self, *records: Record) -> None:
        forgets = any(isinstance(r, Fact) and r.kind == TASK for r in records)
        if forgets and not self.tasks:
            raise StoreFault("the disk is full")
        await super().write(*records)


async def test_nothing_moves_that_could_not_be_written_down() -> None:
    store = ForgetsTasks()
    async with Warehouse(store, fleet=WAREHOUSE).open() as here:
        store.tasks = False
        assert "nothing was changed" in await here.say("/task w1 wave")
        assert not tasks(here)
        store.tasks = True
        here.gateway.rooms.stops["w1"].latched = True
        await here.say("/task w1 wave")
        here.gateway.rooms.stops["w1"].latched = False
        store.tasks = False
        await heard(here, 5)
        assert here.acted("w1") == 0
        assert tasks(here)["1"].state is TaskState.QUEUED
        store.tasks = True
        await heard(here, 5)
        assert here.acted("w1") == 1


async def test_a_task_whose_words_are_erased_is_carried_out_by_nobody() -> None:
    async with warehouse().open() as here:
        here.gateway.rooms.stops["w1"].latched = True
        await here.say("/task w1 wave")
        here.gateway.features.get(FleetFeature).dispatching.letters._said.clear()
        here.gateway.rooms.stops["w1"].latched = False
        await heard(here, 3)
        assert tasks(here)["1"].state is TaskState.CANCELLED
        assert here.acted("w1") == 0


async def test_a_rule_gives_a_task_away_only_where_another_robot_could_take_it() -> None:
    async with warehouse().open() as here:
        rules = RuleTasks(here.gateway.rooms, here.gateway.features.get(FleetFeature).dispatching)
        await here.say("/task warehouse wave")
        await rules.reallocate("w1", "", "")
        await heard(here, 2)
        other = tasks(here)["1"].robot
        assert other in {"w2", "w3"}
        await here.say("/task w1 wave")
        await heard(here, 2)
        with pytest.raises(RobotBusy, match="no task that another robot could take"):
            await rules.reallocate("w1", "", "")
        assert tasks(here)["2"].state is TaskState.RUNNING, "nobody else was wanted: it goes on"
        [third] = {"w2", "w3"} - {other}
        await here.say(f"/robot retire {third}")
        with pytest.raises(RobotBusy):
            await rules.reallocate(other, "", "")
