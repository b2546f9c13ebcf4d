"""Robots that take part or not, the view of all of them, shifts, and commands to many at once."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.core.fleet.task import TaskState
from rosic.core.message import ChatKind
from rosic.core.order import OrderEnding
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules, SkillPrecondition
from rosic.features.fleet import FleetFeature
from rosic.stores.memory import MemoryStore
from tests.features.fleet.test_tasks import (
    WAREHOUSE,
    Warehouse,
    heard,
    later,
    tasks,
    warehouse,
    worker,
)
from tests.gateway.place import ADA, BO, FLEET, VI


async def test_a_robot_that_is_disabled_in_the_middle_gives_its_task_away_and_stays_stopped() -> (
    None
):
    async with warehouse().open() as here:
        await here.say("/task warehouse wave")
        told = await here.say("/robot disable w1") + await heard(here, 2)
        assert "w1 is stopped and takes no part: not to be used now." in told
        assert tasks(here)["1"].robot in {"w2", "w3"}
        assert "so it stays stopped" in await here.say("resume w1")
        assert here.gateway.rooms.stops["w1"].latched
        assert "not to be used now already" in await here.say("/robot disable w1")
        assert "takes part again" in await here.say("/robot enable w1")
        assert here.gateway.rooms.stops["w1"].latched, "motion wants a resume of its own"
        await here.say("resume w1")
        assert not here.gateway.rooms.stops["w1"].latched
        assert "in the fleet already" in await here.say("/robot add w1")


async def test_a_retired_robot_is_given_nothing_also_after_a_restart_until_it_is_added() -> None:
    store = MemoryStore()
    async with warehouse(store).open() as here:
        await here.say("/task w1 wave")
        told = await here.say("/robot retire w1") + await heard(here, 2)
        assert "Task 1 (wave): failed" in told, "nobody else was wanted"
    async with later(store).open() as here:
        here.gateway.rooms.stops["w1"].latched = False
        await here.say("/task warehouse wave", message="another")
        assert tasks(here)["2"].robot in {"w2", "w3"}
        assert "/robot add w1" in await here.say("/robot enable w1")
        told = await here.say("/robot add w1")
        assert "w1 can:" in told
        assert "distance 0.01 to 5 m" in told


async def test_nobody_is_offered_to_resume_what_has_to_stay_stopped() -> None:
    async with warehouse().open() as here:

        def offered() -> list[str]:
            return [button.command for row in here.last()[1].buttons for button in row]

        await here.say("/robot retire w1")
        told = await here.say("w1 wave")
        assert told == (
            "w1 is retired, so it stays stopped. Whoever may assign tasks can change that. "
            "Nothing was done."
        )
        assert not offered()
        await here.say("/robot disable w2")
        assert "w1 is retired" in await here.say("resume")
        assert not offered()
        await here.say("stop w3")
        assert "Say which one may go on" in await here.say("resume")
        assert offered() == ["resume w3"]
        old_ns = here.clock.wall_ns() - 3_600 * 1_000_000_000
        assert "w1 is retired" in await here.say("resume w1", sent_ns=old_ns)
        assert not offered()
        await here.say("/robot add w1")
        assert "is stopped, by you" in await here.say("w1 wave")
        assert offered() == ["resume w1"]


async def test_of_a_group_whose_robots_are_all_retired_nobody_is_waited_for() -> None:
    async with warehouse().open() as here:
        for robot in ("w1", "w2"):
            await here.say(f"/robot retire {robot}")
        assert "· w3" in await here.say("/task warehouse wave"), "the only one that is left"
        await here.say("/robot retire w3")
        told = await here.say("/task warehouse move 1 m")
        assert told == (
            "Nobody of warehouse can do that. w1 was retired. Take it in again with /robot add w1."
        )
        assert len(tasks(here)) == 1


async def test_only_whoever_may_assign_decides_who_takes_part() -> None:
    async with warehouse().open() as here:
        assert "Only somebody who may assign" in await here.say("/robot disable w1", account=BO)
        assert "w1 can:" in await here.say("/robot w1", account=VI)
        assert "no robot called w9" in await here.say("/robot w9")
        assert not here.gateway.rooms.stops["w1"].latched


async def test_the_view_shows_every_robot_every_task_and_what_is_not_as_it_should_be() -> None:
    async with warehouse().open() as here:
        here.robot("w2").values = {"battery": 12}
        here.robot("w3").online = False
        await here.clock.advance(60)
        await here.say("/task w1 wave")
        await here.say("/task w1 move 1 m")
        await heard(here, 60)
        told = await here.say("/fleet warehouse")
        assert "one robot at work, 0 free, 2 not ready" in told
        assert "one task running, one waits, the longest for 1 min" in told
        assert "At work 17 % of the time" in told
        assert "w1: one task waits; 0 of 1 robots are free." in told
        lines = told.splitlines()
        assert lines.pop().startswith("updated 12:00:00")
        assert lines[-3:-1] == [
            "w2: battery 12 %, low · not ready · heard 0 ms ago",
            "w3: not there · not ready · heard 0 ms ago",
        ]
        assert lines[-1] == "w1: task 1 (wave) · running · heard 0 ms ago"
        message, _ = here.last()
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here, 8)
        now = here.chat.shown(message).text
        assert "w1: task 2 (move 1 m) · running" in now, "the same message, edited"
        await here.say("/fleet off")
        await heard(here, 8)
        assert "w1:" not in here.chat.shown(message).text


async def test_what_people_order_themselves_is_work_too_and_counts_once() -> None:
    async with warehouse().open() as here:
        await here.clock.advance(60)
        await here.say("w1 wave", account=BO)
        await heard(here, 20)
        told = await here.say("/fleet w1")
        assert "one robot at work, 0 free" in told
        assert "At work 25 % of the time; idle for 0 s on the average." in told
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here, 20)
        told = await here.say("/fleet w1")
        assert "0 robots at work" in told
        assert "At work 20 % of the time; idle for 20 s on the average." in told
        await here.say("w1 look", account=BO)
        await heard(here, 10)
        assert "0 robots at work" in await here.say("/fleet w1"), "to be asked is no work"
        worker(here, "w1").end(OrderEnding.DONE)
        await here.clock.advance(60)  # nobody's any more
        await here.say("/task w1 wave then wave")
        await heard(here, 15)
        worker(here, "w1").end(OrderEnding.DONE)  # and the second step begins
        await heard(here, 15)
        told = await here.say("/fleet w1")
        assert "At work 25 % of the time" in told, "50 s of 200, no second of them twice"
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        assert "0 robots at work, one free" in await here.say("/fleet w1")


async def test_a_shift_is_handed_over_only_when_it_is_accepted_and_rights_are_the_others() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 move 1 m then wave")
        await here.say("/task w1 wave")
        assert "Vi may move no robot" in await here.say("/handover Vi")
        assert "do not know for certain" in await here.say("/handover Nobody")
        told = await here.say("/handover Bo")
        assert "Ada hands over to you: 2 tasks." in told
        assert {task.author for task in tasks(here).values()} == {_id(here, "Ada")}
        button, under = here.button("I take over")
        told = await here.tap(button, under, account=BO)
        assert "Yours now, from Ada: 2 tasks." in told
        assert {task.author for task in tasks(here).values()} == {_id(here, "Bo")}
        assert here.gateway.rooms.organiser.holder("w1") == _id(here, "Ada"), "its step goes on"
        worker(here, "w1").end(OrderEnding.DONE)
        await heard(here)
        assert tasks(here)["1"].done == 1
        assert here.gateway.rooms.organiser.holder("w1") == _id(here, "Bo")
        assert here.acted("w1") == 2


async def test_of_two_who_share_a_name_the_one_who_is_meant_is_asked() -> None:
    async with warehouse().open() as here:
        directory = here.gateway.rooms.authoriser.directory
        bo, vi = directory.person(_id(here, "Bo")), directory.person(_id(here, "Vi"))
        assert bo is not None
        assert vi is not None
        directory.enrol(replace(vi, name="Bo"))
        await here.say("/task w1 wave")
        group = await here.say("/handover Bo", chat="-5", kind=ChatKind.GROUP)
        assert '2 people are called "Bo". Ask me in a private chat' in group
        assert '2 people are called "Bo". Which one?' in await here.say("/handover Bo")
        await here.tap(*here.button("Bo, operator"))
        assert {t.outbound.chat.id for t in here.chat.told if "hands over" in t.outbound.text} == {
            BO
        }
        # Renamed between reading and tapping, it is who was read of.
        await here.say("/handover Bo")
        button, under = here.button("Bo, operator")
        directory.enrol(replace(bo, name="Cy"))
        before = len(here.chat.told)
        assert "Cy is asked." in await here.tap(button, under)
        told = [
            t.outbound for t in list(here.chat.told)[before:] if "hands over" in t.outbound.text
        ]
        assert [outbound.chat.id for outbound in told] == [BO]


@pytest.mark.parametrize("called", ["an id", "accept 1", "to Bo"])
async def test_a_shift_goes_by_an_id_and_whoever_is_called_like_it_is_asked_about(
    called: str,
) -> None:
    async with warehouse().open() as here:
        directory, bo = here.gateway.rooms.authoriser.directory, _id(here, "Bo")
        vi = directory.person(_id(here, "Vi"))
        assert vi is not None
        directory.enrol(replace(vi, name=bo if called == "an id" else called))
        await here.say("/task w1 wave")
        told = await here.say(f"/handover {bo}")
        if called == "an id":
            assert "Which one?" in told
            await here.tap(*here.button("Bo, operator"))
        assert {t.outbound.chat.id for t in here.chat.told if "hands over" in t.outbound.text} == {
            BO
        }


async def test_who_takes_a_task_over_reads_its_orders_unless_a_group_does() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 move 1 m then wave")
        await here.say("/task w2 move 1 m then wave", chat="-5", kind=ChatKind.GROUP)
        await here.say("/handover Bo")
        await here.tap(*here.button("I take over"), account=BO)
        before = len(here.chat.told)
        for robot in ("w1", "w2"):
            worker(here, robot).end(OrderEnding.DONE)
        await heard(here, 2)
        told = [(t.outbound.chat.id, t.outbound.text) for t in list(here.chat.told)[before:]]
        assert {chat for chat, text in told if "task 1, step 2 of 2" in text} == {BO}
        assert {chat for chat, text in told if "task 2, step 2 of 2" in text} == {"-5"}


async def test_a_robot_that_idles_in_somebodys_hands_goes_with_their_shift_and_no_other_does() -> (
    None
):
    async with warehouse().open() as here:
        organiser = here.gateway.rooms.organiser
        for robot, account in (("w1", ADA), ("w2", ADA), ("w3", BO)):
            worker(here, robot).work_s = 1e-9
            await here.say(f"{robot} wave", account=account)
        worker(here, "w2").work_s = 3600.0
        await here.say("w2 wave")
        fence = organiser.lease("w1").fence
        assert "Ada hands over to you: one robot." in await here.say("/handover Bo")
        assert organiser.holder("w1") == _id(here, "Ada"), "not before it is accepted"
        button, under = here.button("I take over")
        assert "Yours now, from Ada: one robot." in await here.tap(button, under, account=BO)
        holders = {robot: organiser.holder(robot) for robot in ("w1", "w2", "w3")}
        ada, bo = _id(here, "Ada"), _id(here, "Bo")
        assert holders == {"w1": bo, "w2": ada, "w3": bo}, "what works goes on in its hands"
        assert organiser.lease("w1").fence > fence
        assert "w1 is taken by Bo." in await here.say("w1 wave")
        assert here.acted("w1") == 1


def _id(here: object, name: str) -> str:
    directory = here.gateway.rooms.authoriser.directory  # type: ignore[attr-defined]
    [person] = directory.named(name)
    return str(person.id)


async def test_an_offer_is_good_for_one_person_and_for_a_while() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 wave")
        await here.say("/handover Bo")
        assert "That offer is over" in await here.say("/handover accept 1", account=VI)
        await here.clock.advance(700)
        assert "That offer is over" in await here.say("/handover accept 1", account=BO)
        assert {task.author for task in tasks(here).values()} == {_id(here, "Ada")}


async def test_two_managers_with_overlapping_groups_never_take_from_each_other() -> None:
    async with warehouse().open() as here:
        for account in (ADA, BO, ADA, BO):
            await here.say("/task warehouse wave", account=account)
        held = {task.robot: task.author for task in tasks(here).values() if task.robot}
        assert len(held) == 3
        organiser = here.gateway.rooms.organiser
        assert {robot: organiser.holder(robot) for robot in held} == held
        await here.say("stop w1 w2 w3")
        await heard(here, 5)
        assert {t.state for t in tasks(here).values()} <= {TaskState.PAUSED, TaskState.QUEUED}


async def test_together_all_begin_at_one_moment_or_none() -> None:
    async with warehouse().open() as here:
        here.robot("w2").online = False
        told = await here.say("/together warehouse wave")
        assert "all or none, and not all are ready. Nobody begins." in told
        assert "w2: not there" in told
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [0, 0, 0]
        button, under = here.button("Begin with w1, w3")
        await here.tap(button, under)
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [1, 0, 1]
        starts = {here.gateway.rooms.linker.current(name).start_ns for name in ("w1", "w3")}  # type: ignore[union-attr]
        assert len(starts) == 1
        assert None not in starts


async def test_one_who_is_unknown_is_not_just_left_out() -> None:
    async with warehouse().open() as here:
        for verb in ("together", "broadcast"):
            told = await here.say(f"/{verb} w1+ghost wave")
            assert told == "I know no robot and no group called ghost."
        assert here.acted("w1") == 0


async def test_what_nobody_can_do_makes_nobody_ready() -> None:
    async with warehouse().open() as here:
        await here.say("stop w1")
        told = await here.say("/together warehouse dance")
        assert "ready" not in told
        assert "dance" in told


async def test_a_broadcast_asks_each_for_itself_and_shows_who_received_it() -> None:
    async with warehouse().open() as here:
        await here.say("w2 wave", account=BO)
        told = await here.say("/broadcast warehouse move 1 m")
        assert "2 of 3 robots are asked. The others:" in told
        assert told.splitlines()[-1].startswith("w2 is busy"), "and its name is said once"
        shown = "\n".join(t.outbound.text for t in here.chat.told)
        assert "w1: move, 1.00 m forward" in shown
        assert shown.count("received by the robot") >= 2
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [1, 1, 1]
        assert "no robot and no group" in await here.say("/broadcast nowhere wave")


async def test_what_came_too_late_is_offered_for_those_it_was_meant_for() -> None:
    async with warehouse().open() as here:
        await here.say("use omni")
        for verb in ("together", "broadcast"):
            late_ns = here.clock.wall_ns() - 10_000_000_000
            again = f"/{verb} warehouse wave"
            told = await here.say(again, sent_ns=late_ns) + await heard(here, 5)
            assert "Your command is 10 seconds old" in told
            await here.tap(*here.button(again))
            for robot in ("w1", "w2", "w3"):
                worker(here, robot).end(OrderEnding.DONE)
            await heard(here)
        assert here.acted("omni") == 0, "it was chosen, and not meant"
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [2, 2, 2]


class Careful(Warehouse):
    rulebook = RoleRules(
        roles=DEFAULT_ROLES, care=(SkillPrecondition(scopes=("w2:wave",), confirm=True),)
    )


async def test_what_wants_a_tap_each_time_is_not_asked_of_many() -> None:
    async with Careful(fleet=(*WAREHOUSE, FLEET[0])).open() as here:
        why = "w2 does this only when somebody confirms it: Wave. Say it as a command."
        assert await here.say("/together warehouse wave") == why
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [0, 0, 0]
        told = await here.say("/broadcast warehouse wave")
        assert told.endswith(f"2 of 3 robots are asked. The others:\n{why}")
        assert [here.acted(name) for name in ("w1", "w2", "w3")] == [1, 0, 1]


async def test_what_somebody_has_said_is_read_by_them_alone() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 move 3 m then wave", account=BO)
        assert "1: move 3 m; wave · w1 · running" in await here.say("/tasks", account=BO)
        told = await here.say("/tasks") + await here.say("/fleet")
        assert "1: Move; Wave · w1 · running" in told
        assert "task 1 (Move; Wave)" in told
        assert "3 m" not in told
        shared = await here.say("/fleet", account=BO, chat="-5", kind=ChatKind.GROUP)
        assert "task 1 (Move; Wave)" in shared
        assert "3 m" not in shared


async def test_what_somebody_has_said_goes_with_them() -> None:
    async with warehouse().open() as here:
        await here.say("/task w1 wave", account=BO)
        fleet = here.gateway.features.get(FleetFeature)
        async with here.gateway.access.changes.turn() as turn:
            await turn.write(fleet.end_all(_id(here, "Bo")))
        assert fleet.dispatching.letters.get("1") is None
        assert "what was said for it is erased" in await here.say("/task 1", account=BO)
