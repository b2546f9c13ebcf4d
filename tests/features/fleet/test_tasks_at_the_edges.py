"""Tasks where they meet stops, crashes, backlogs and each other: nothing moves unwanted."""

from __future__ import annotations

import asyncio
from copy import deepcopy

from msgspec.structs import replace

from rosic.core.fleet.state import KEPT_OVER
from rosic.core.fleet.task import TaskState
from rosic.core.order import OrderEnding
from rosic.core.records import Claimed, Concluded, Fact
from rosic.core.robot.profile import Busy
from rosic.features.fleet import FleetFeature
from rosic.features.fleet.integration import RuleTasks
from rosic.features.fleet.messages import ERASED
from rosic.features.fleet.task_commands import OF_ONE_AT_MOST
from rosic.features.robot_to_robot import RobotToRobotFeature
from rosic.stores.memory import MemoryStore
from tests.features.fleet.test_missions import lab
from tests.features.fleet.test_tasks import WAREHOUSE, heard, later, tasks, warehouse, worker
from tests.gateway.place import BO, BrokenStore, SlowStore

SECOND_NS = 1_000_000_000


async def test_a_task_that_waited_on_the_way_here_is_not_given() -> None:
    async with warehouse().open() as here:
        old_ns = here.clock.wall_ns() - 3_600 * SECOND_NS
        told = await here.say("/task w1 wave", sent_ns=old_ns)
        assert not tasks(here), told
        here.chat.gap()
        missed_ns = here.clock.wall_ns() - SECOND_NS
        told = await here.say("/task w1 wave", sent_ns=missed_ns)
        assert not tasks(here), told
        await heard(here)
        assert here.acted("w1") == 0


async def test_a_task_that_is_brought_again_after_a_crash_is_not_given_twice() -> None:
    store = MemoryStore()
    async with warehouse(store).open() as here:
        await here.clock.advance(1)
        said = here.chat.say("/task w1 wave")
        await here.quiet()
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        crashed = deepcopy(store)
    async with later(crashed).open() as here:
        here.chat.gap()
        here.chat.deliver(replace(said, listening_since_ns=here.chat.listening_since_ns))
        await here.quiet()
        await heard(here)
        assert here.acted("w1") == 0


async def test_two_people_at_once_give_two_tasks() -> None:
    store = SlowStore(Fact)
    async with warehouse(store).open() as here:
        here.chat.say("/task w1 wave")
        here.chat.say("/task w2 move 1 m", account=BO, chat=BO)
        await here.quiet()
        store.ready.set()
        await heard(here)
        telling = here.gateway.features.get(FleetFeature).telling
        said = {task.among: telling.what(task, task.author) for task in tasks(here).values()}
        assert said == {("w1",): "wave", ("w2",): "move 1 m"}


async def test_a_task_that_is_cancelled_while_it_is_claimed_moves_nothing() -> None:
    store = SlowStore(Claimed)
    async with warehouse(store).open() as here:
        await here.say("/task w1 wave")
        await here.say("/task cancel 1")
        await here.quiet()  # within the second that a claim may wait for the record
        store.ready.set()
        await heard(here)
        assert here.acted("w1") == 0
        assert tasks(here)["1"].state is TaskState.CANCELLED


async def test_a_task_that_is_paused_while_it_is_claimed_goes_on_with_one_robot() -> None:
    store = SlowStore(Claimed)
    async with warehouse(store).open() as here:
        await here.say("/task warehouse wave")
        await here.say("/task pause 1")
        await heard(here)
        await here.say("/task go 1")
        await heard(here)
        store.ready.set()
        await heard(here, 4)
        assert sum(here.acted(name) for name in ("w1", "w2", "w3")) == 1


async def test_an_order_that_waits_for_its_robot_goes_with_its_task() -> None:
    queues = tuple(replace(robot, busy=Busy.QUEUE) for robot in WAREHOUSE[:1])
    store = SlowStore(Claimed)
    async with warehouse(store, fleet=queues).open() as here:
        here.chat.say("w1 move 1 m", chat="other")
        await here.say("/task w1 wave")
        store.ready.set()
        await heard(here)
        assert here.gateway.rooms.linker.waiting("w1") == 1
        await here.say("/task cancel 1")
        await heard(here)
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        assert here.acted("w1") == 1


async def test_a_stop_between_two_steps_is_meant_too() -> None:
    async with warehouse().open() as here:
        await here.say("/task warehouse wave then wave")
        worker(here, "w1").end(OrderEnding.DONE)
        for _ in range(400):
            if tasks(here)["1"].attempt == 2:
                break
            await asyncio.sleep(0)
        here.gateway.stop_lane.stop_robots(("w1",), "someone")
        await heard(here, 3)
        assert tasks(here)["1"].state is TaskState.PAUSED


async def test_a_stop_that_is_undone_at_once_was_meant_too() -> None:
    store = SlowStore(Concluded)
    async with warehouse(store).open() as here:
        await here.say("/task warehouse wave")
        await here.say("stop w1")
        await here.say("resume w1")
        store.ready.set()
        await heard(here, 3)
        assert tasks(here)["1"].state is TaskState.PAUSED


async def test_whatever_a_stopped_robot_says_its_task_goes_nowhere_else() -> None:
    for ending in (OrderEnding.FAILED, OrderEnding.UNKNOWN, OrderEnding.CANCELLED):
        async with warehouse().open() as here:
            await here.say("/task warehouse wave")
            worker(here, "w1").end(ending)
            here.gateway.stop_lane.stop_robots(("w1",), "someone")
            await heard(here, 3)
            assert tasks(here)["1"].state is TaskState.PAUSED


async def test_whoever_is_erased_leaves_no_words_and_no_robot_moves_for_them() -> None:
    store = MemoryStore()
    async with warehouse(store).open() as here:
        await here.say("/task w1 wave", account=BO, chat=BO)
        await here.say("/task w1 move 1 m", account=BO, chat=BO)
        await here.say("/shared w1 follow", account=BO, chat=BO)
        post = here.gateway.features.get(RobotToRobotFeature).messaging.circle.around.post
        assert list(post.chats("w1", "road"))
        assert "2: move 1 m" in await here.say("/tasks", account=BO, chat=BO)
        await here.say("/forget me", account=BO, chat=BO)
        button, under = here.button("Forget me for good")
        await here.tap(button, under, account=BO)
        await heard(here, 15)
        assert {task.state for task in tasks(here).values()} == {TaskState.CANCELLED}
        telling = here.gateway.features.get(FleetFeature).telling
        assert {telling.what(task, task.author) for task in tasks(here).values()} == {ERASED}
        assert not [fact for fact in await store.facts("shared-ear", "", 9) if fact.body]
        await here.say("resume w1")
        await heard(here)
        assert here.acted("w1") == 1


async def test_tasks_that_nobody_can_begin_keep_no_other_waiting() -> None:
    async with warehouse().open() as here:
        await here.say("stop w1")
        for _ in range(201):
            await here.say("/task w1 wave priority 9")
        await here.say("/task w2 wave", account=BO, chat=BO)
        await heard(here)
        assert tasks(here)["202"].state is TaskState.RUNNING


async def test_what_one_robot_refuses_it_is_not_asked_again_at_once() -> None:
    async with warehouse(fleet=WAREHOUSE[:1]).open() as here:
        for _ in range(40):
            await here.say("/task w1 wave")
        here.clock.jump_wall(-100)
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here, 10)
        assert here.gateway.rooms.organiser.in_doubt
        assert 2 <= sum(task.attempt for task in tasks(here).values()) <= 8


async def test_no_task_begins_before_what_was_sent_meanwhile_has_come() -> None:
    store = MemoryStore()
    async with warehouse(store).open() as here:
        await here.say("/task w1 wave then wave")
        here.chat.catching_up = lambda: True
        await here.say("/task w2 wave")
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here, 5)
        assert (here.acted("w1"), here.acted("w2")) == (1, 0), "a stop may be on its way"
    here = later(store)
    here.chat.catching_up = lambda: True
    async with here.open():
        await heard(here, 5)
        await here.say("stop w2")
        here.chat.catching_up = bool
        await heard(here, 5)
        assert here.acted("w2") == 0
        assert tasks(here)["2"].state is TaskState.PAUSED


async def test_nobody_keeps_the_others_from_giving_tasks() -> None:
    async with warehouse(fleet=WAREHOUSE[:1]).open() as here:
        for _ in range(OF_ONE_AT_MOST):
            here.chat.say("/task w1 wave")
        await here.clock.advance(1)
        told = await here.say("/task w1 wave")
        assert "You have 500 tasks open already" in told
        assert len(tasks(here)) == OF_ONE_AT_MOST
        await here.say("/task w1 wave", account=BO, chat=BO)
        assert len(tasks(here)) == OF_ONE_AT_MOST + 1


async def test_what_was_said_of_tasks_that_are_forgotten_is_forgotten_too() -> None:
    async with warehouse(fleet=WAREHOUSE[:1]).open() as here:
        dispatching = here.gateway.features.get(FleetFeature).dispatching
        for _ in range(KEPT_OVER + 20):
            await here.say("/task w1 wave once")
            worker(here, "w1").end(OrderEnding.FAILED, "the gripper is open")
            await here.quiet()
            await here.say(f"/task cancel {max(tasks(here), key=int)}")
        assert len(tasks(here)) <= KEPT_OVER + 1
        assert set(dispatching.why) | set(dispatching.rested) <= set(tasks(here))


async def test_whoever_resumes_a_robot_reads_what_it_begins_by_itself() -> None:
    async with warehouse(fleet=WAREHOUSE[:1]).open() as here:
        await here.say("/task w1 wave", account=BO, chat=BO)
        await here.say("/task w1 move 1 m", account=BO, chat=BO)
        await here.say("stop w1")
        told = await here.say("resume w1")
        assert "It moves by itself as soon as it is given a task that waits: 2." in told
        await here.say("/task cancel 2")
        await here.say("stop w1")
        assert "by itself" not in await here.say("resume w1")


async def test_a_robot_is_taken_out_of_the_fleet_although_nothing_can_be_written() -> None:
    store = BrokenStore()
    async with warehouse(store).open() as here:
        store.broken = True
        assert "is stopped and takes no part" in await here.say("/robot disable w1")
        store.broken = False
        assert "so it stays stopped" in await here.say("resume w1")
        assert here.gateway.rooms.stops["w1"].latched


async def test_times_of_missions_outlast_a_disk_that_was_full() -> None:
    store = BrokenStore()
    async with lab(store).open() as here:
        await here.say("/mission start loud in 1 min")
        await here.say("/mission start loud in 3 min", account=BO, chat=BO)
        store.broken = True
        await heard(here, 90)
        assert here.acted("w1") == 0
        store.broken = False
        await heard(here, 5)
        assert here.acted("w1") == 1
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here, 120)
        assert here.acted("w1") == 2


async def test_a_time_that_is_taken_back_as_it_comes_begins_nothing() -> None:
    store = SlowStore(Fact)
    store.ready.set()
    async with lab(store).open() as here:
        await here.say("/mission start loud every day 8:00")
        timetable = here.gateway.features.get(FleetFeature)._timetable
        wait_ns = (timetable.next_ns(timetable.plans["1"]) or 0) - here.clock.wall_ns()
        store.ready.clear()
        here.chat.say("/mission off 1")
        await here.quiet()
        here.clock.jump_wall(wait_ns / 1e9)
        await heard(here, 2)
        store.ready.set()
        await heard(here, 3)
        assert not timetable.plans
        assert not tasks(here)


async def test_two_people_at_once_plan_two_times() -> None:
    store = SlowStore(Fact)
    async with lab(store).open() as here:
        here.chat.say("/mission start loud in 1 min")
        here.chat.say("/mission start loud in 2 min", account=BO, chat=BO)
        await here.quiet()
        store.ready.set()
        await heard(here)
        assert len(here.gateway.features.get(FleetFeature)._timetable.plans) == 2


async def test_a_rule_brings_a_robot_to_rest_although_nothing_can_be_written() -> None:
    store = BrokenStore()
    async with warehouse(store).open() as here:
        await here.say("/task w1 wave")
        store.broken = True
        rules = RuleTasks(here.gateway.rooms, here.gateway.features.get(FleetFeature).dispatching)
        assert await rules.pause("w1", "somebody", "it is too warm")
        await heard(here)
        assert not here.robot("w1").presence().doing
        assert tasks(here)["1"].state is TaskState.PAUSED


async def test_what_was_not_begun_in_time_is_given_anew_and_what_was_is_seen_through() -> None:
    async with warehouse().open() as here:
        here.robot("w1").online = False
        await here.say("/task w1 wave by in 1 min")
        told = await heard(here, 70)
        assert "Task 1 (wave): failed. Why: it was not begun in time." in told
        _, shown = here.last()
        commands = [button.command for row in shown.buttons for button in row]
        assert commands == ["/task cancel 1", "use w1", "robots"]
        here.robot("w1").online = True
        told = await here.say("/task go 1")
        assert "Task 1 was to be begun by a time that is over. Give it anew." in told
        await here.say("/task w2 move 1 m then wave by in 1 min")
        worker(here, "w2").end(OrderEnding.DONE)
        await heard(here)
        await here.say("/task pause 2")
        await heard(here, 70)
        await here.say("/task go 2", message="go")
        await heard(here)
        assert tasks(here)["2"].state is TaskState.RUNNING, "a step of it was done in time"
        assert (here.acted("w1"), here.acted("w2")) == (0, 3)


async def test_a_time_from_now_is_kept_to_the_second() -> None:
    async with warehouse().open() as here:
        here.robot("w1").online = False
        await here.clock.advance(19)  # of a minute that is nearly over
        for said in ("1 min", "90 s"):
            await here.say(f"/task w1 wave by in {said}")
        assert "That time is over" in await here.say("/task w1 wave by in 0 min")
        await heard(here, 55)
        assert {task.state for task in tasks(here).values()} == {TaskState.QUEUED}
        await heard(here, 10)
        assert [task.state for task in tasks(here).values()] == [TaskState.FAILED, TaskState.QUEUED]


async def test_what_came_of_a_task_is_said_once_and_in_sentences() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 move 1 m then wave")
        told = await here.say("/task pause 1") + await heard(here)
        assert "Task 1 (move 1 m; wave): paused. 0 of 2 steps are done." in told
        await here.say("/task w2 move 1 m then wave")
        worker(here, "w2").end(OrderEnding.FAILED, "the gripper is open")
        told = await heard(here, 3)
        assert "failed. Why: w2 has failed at it: the gripper is open. 0 of 2 steps" in told


async def test_a_line_that_is_too_long_is_refused_and_not_cut() -> None:
    async with warehouse().open() as here:
        steps = " then ".join(["move direction=forward distance=1 m"] * 60)
        told = await here.say(f"/task w1 {steps} then move 1.5 m once")
        assert "A task is said in at most 2000 characters." in told
        assert not tasks(here)
        steps = " then ".join(["move direction=forward distance=1 m"] * 40)
        await here.say(f"/task w1 {steps} once")
        assert (tasks(here)["1"].steps, tasks(here)["1"].once) == (40, True)


async def test_who_was_lost_once_has_as_long_as_anybody_to_be_heard_of_again() -> None:
    async with warehouse().open() as here:
        lost = worker(here, "w1")
        await here.say("/task w1 wave")
        lost.online = False
        assert "w1 is not heard of any more" in await heard(here, 5)
        lost.online = True
        await here.say("/task cancel 1")
        await here.say("resume w1")
        await here.say("/task w1 wave")
        assert tasks(here)["2"].robot == "w1"
        lost.online = False
        await heard(here, 2)
        lost.online = True
        await heard(here, 2)
        assert (tasks(here)["2"].state, tasks(here)["2"].robot) == (TaskState.RUNNING, "w1")
