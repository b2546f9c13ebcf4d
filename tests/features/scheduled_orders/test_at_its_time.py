"""At its time it is an order of its author: with the rights, stops and bounds of then, or not."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding
from rosic.core.records import Claimed, Decided, Fact
from rosic.core.robot.skill import Parameter, Skill
from rosic.features.scheduled_orders.schedule import KIND
from rosic.stores.memory import MemoryStore
from tests.features.scheduled_orders.planning import (
    DAY_S,
    HOUR_S,
    Recording,
    lab,
    later,
    next_time,
    plan,
    quick,
    schedule,
    worker,
)
from tests.gateway.place import BO, FLEET, MOVE, BrokenStore


async def test_at_its_time_it_is_an_order_of_its_author() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m", BO)
        assert await later(here, 4 * HOUR_S - 10, BO) == ""
        assert here.acted() == 0
        told = await later(here, 10, BO)
        assert "omni: move, 1.00 m forward · planned 1" in told
        assert here.acted() == 1
        order = here.gateway.rooms.linker.current("omni")
        assert order is not None
        assert here.gateway.rooms.organiser.name_of(order.permit.principal) == "Bo"
        assert not schedule(here).orders
        worker(here).end(OrderEnding.DONE)
        assert "done 12:00:00" in await later(here, 5, BO)
        await later(here, DAY_S, BO)
        assert here.acted() == 1


async def test_the_decision_is_on_disk_before_anything_moves() -> None:
    store = Recording()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        await later(here, 4 * HOUR_S)
        written = list(store.written)
    [ran] = [
        n for n, r in enumerate(written) if isinstance(r, Decided) and r.act == "scheduled-run"
    ]
    [claimed] = [n for n, r in enumerate(written) if isinstance(r, Claimed)]
    assert ran < claimed
    for record in written:
        if isinstance(record, Fact) and record.kind == KIND:
            assert b"move" not in record.body, "what was said stands in the container"


async def test_steps_follow_one_another_and_all_of_it_is_said_to_be_done() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m; swarm wave; omni move 2 m")
        told = await later(here, 4 * HOUR_S)
        assert "omni: move, 1.00 m forward · planned 1, step 1 of 3" in told
        assert (here.acted(), here.acted("cf1")) == (1, 0)
        worker(here).end(OrderEnding.DONE)
        await later(here, 5)
        assert (here.acted(), here.acted("cf1"), here.acted("cf2")) == (1, 1, 1)
        worker(here, "cf1").end(OrderEnding.DONE)
        await later(here, 5)
        assert here.acted() == 1, "the other has not ended"
        worker(here, "cf2").end(OrderEnding.DONE)
        await later(here, 5)
        assert here.acted() == 2
        worker(here).end(OrderEnding.DONE)
        told = await later(here, 5)
        assert "Planned order 1 (omni move 1 m; swarm wave; omni move 2 m): done." in told
        assert not schedule(here).orders


async def test_what_is_not_carried_out_ends_it() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m; omni wave; cf1 wave")
        await later(here, 4 * HOUR_S)
        worker(here).end(OrderEnding.FAILED, "the wheel is loose")
        told = await later(here, 5)
        assert "ended with step 1 of 3: that was not carried out, so the rest was not" in told
        assert (here.acted(), here.acted("cf1")) == (1, 0)
        assert not schedule(here).orders


async def test_a_robot_at_work_is_not_made_to_leave_off() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        await here.say("omni wave")
        told = await later(here, 4 * HOUR_S)
        assert "Planned order 1 (omni move 1 m) was not done: omni is busy" in told
        assert here.acted() == 1


async def test_cancel_ends_the_rest_of_it_and_nothing_that_waits() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m; cf1 wave")
        await plan(here, "/at 16:00 omni wave")
        await later(here, 4 * HOUR_S)
        await here.say("cancel")
        await later(here, 5)
        assert here.acted("cf1") == 0
        await next_time(here)
        assert here.acted() == 2, "what is planned goes on waiting"


async def test_cancelled_by_its_number_it_begins_no_further_step() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m; cf1 wave")
        await later(here, 4 * HOUR_S)
        assert "1: 15:00: omni move 1 m; cf1 wave" in await here.say("/planned")
        await here.say("/unplan 1")
        worker(here).end(OrderEnding.DONE)
        told = await later(here, 5)
        assert "ended before step 2 of 2, and the rest was not done: You cancelled this" in told
        assert here.acted("cf1") == 0


# ---- who may, then ----


async def test_the_rights_of_then_count() -> None:
    async with lab().open() as here:
        await here.say("/grant Vi operator omni for 2h")
        await plan(here, "/at 14:00 omni move 1 m", "3")
        told = await later(here, 3 * HOUR_S, "3")
        assert "Planned order 1 (omni move 1 m) was not done: " in told
        assert here.acted() == 0


async def test_what_was_planned_before_a_lock_is_not_done_though_it_is_lifted() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m", BO)
        await plan(here, "/every day 15:00 omni wave", BO)
        told = await here.say("/lock Bo")
        assert "so the 2 orders that you had planned are taken back." in told
        await here.say("/unlock Bo")
        await later(here, 4 * HOUR_S, BO)
        assert here.acted() == 0
        assert "You have planned nothing." in await here.say("/planned", account=BO, chat=BO)
    async with lab(store).open() as here:
        assert not schedule(here).orders, "a restart brings nothing back"


async def test_nothing_begins_for_somebody_whose_access_is_revoked() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m", BO)
        await here.revoke("Bo")
        assert not schedule(here).orders
        await later(here, 4 * HOUR_S)
        assert here.acted() == 0


async def test_a_robot_of_somebody_else_is_not_taken() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m", BO)
        here.clock.jump_wall(4 * HOUR_S - 5)
        quick(here)
        await here.say("omni wave")
        told = await later(here, 8, BO)
        assert "Planned order 1 (omni move 1 m) was not done: " in told
        assert "Ada" in told
        assert here.acted() == 1


# ---- stops ----


async def test_a_robot_that_is_stopped_then_does_nothing() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        await here.say("stop omni", account=BO, chat=BO)
        told = await later(here, 4 * HOUR_S)
        assert "Planned order 1 (omni move 1 m) was not done: omni is stopped" in told
        assert here.acted() == 0


async def test_what_was_planned_before_a_stop_is_not_done_though_it_is_resumed() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        await plan(here, "/at 15:00 cf1 wave")
        await here.say("stop omni")
        await here.say("resume omni")
        assert "1: 15:00: omni move 1 m · rests since a stop" in await here.say("/planned")
        told = await later(here, 4 * HOUR_S)
        assert (
            "Planned order 1 (omni move 1 m) was not done: omni was stopped after you planned it."
        ) in told
        assert (here.acted(), here.acted("cf1")) == (0, 1)


async def test_what_comes_again_goes_on_after_a_stop_only_by_a_word() -> None:
    async with lab().open() as here:
        quick(here)
        await plan(here, "/every day 15:00 omni wave")
        await later(here, 4 * HOUR_S)
        assert here.acted() == 1
        await here.say("stop omni")
        await here.say("resume omni")
        told = await next_time(here)
        assert "omni was stopped after you planned it." in told
        assert here.acted() == 1
        told = await here.tap(*here.button("Go on the next time"))
        assert told == "Planned order 1 goes on, next tomorrow 15:00."
        assert await here.say("/planned go 1") == "Planned order 1 does not rest."
        await next_time(here)
        assert here.acted() == 2


async def test_a_stop_between_two_steps_is_meant_for_those_that_follow() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 cf1 wave; omni move 1 m")
        await later(here, 4 * HOUR_S)
        await here.say("stop omni")
        await here.say("resume omni")
        worker(here, "cf1").end(OrderEnding.DONE)
        told = await later(here, 5)
        assert "ended before step 2 of 2" in told
        assert "omni was stopped after you planned it." in told
        assert here.acted() == 0


async def test_a_plan_is_not_begun_once_any_of_its_robots_was_stopped() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 cf1 wave; omni move 1 m")
        await here.say("stop omni")
        await here.say("resume omni")
        told = await later(here, 4 * HOUR_S)
        assert "was not done: omni was stopped after you planned it." in told
        assert (here.acted(), here.acted("cf1")) == (0, 0)


async def test_nothing_begins_before_what_was_sent_meanwhile_has_come() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        await plan(here, "/at 15:00 cf1 wave; kuka1 wave")
        await plan(here, "/at 16:00 omni wave")
        here.chat.catching_up = lambda: True
        assert await later(here, 4 * HOUR_S) == ""
        assert here.acted() == 0, "a stop may be on its way"
        here.chat.catching_up = bool
        await later(here, 3)
        assert (here.acted(), here.acted("cf1")) == (1, 1), "it is in time still"
        here.chat.catching_up = lambda: True
        worker(here, "cf1").end(OrderEnding.DONE)
        told = await later(here, 6)
        assert here.acted("kuka1") == 0
        assert "rest was not done: It was too late to begin." in told + await later(here, 6)
        told = await next_time(here) + await later(here, 6)
        assert "Planned order 3 (omni wave) was not done: It was too late to begin." in told
        here.chat.catching_up = bool
        await later(here, 5)
        assert here.acted() == 1


# ---- late ----


@pytest.mark.parametrize(("late_s", "done"), [(3.0, True), (7.0, False)])
async def test_it_is_never_late(late_s: float, *, done: bool) -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
    here = lab(store)
    here.clock.jump_wall(4 * HOUR_S + late_s - 1.0)
    async with here.open():
        told = await later(here, 5)
        assert here.acted() == done
        missed = "was for 15:00, and I could not begin it in time. It was not done."
        assert (missed in told + str(here.chat.told)) is not done
        assert not schedule(here).orders


async def test_what_was_slept_through_again_and_again_is_said_once_and_goes_on() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/every day 15:00 omni wave")
    here = lab(store)
    here.clock.jump_wall(5 * DAY_S)
    async with here.open():
        quick(here)
        await later(here, 5)
        assert str([told.outbound.text for told in here.chat.told]).count("not begin it") == 1
        await later(here, 4 * HOUR_S - 10)
        assert here.acted() == 1


async def test_an_order_is_as_old_as_its_time() -> None:
    """A disk that takes long makes it too late, and not fresh (I2)."""
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        due_ns = next(iter(schedule(here).orders.values())).when.at_ns
        await later(here, 4 * HOUR_S)
        order = here.gateway.rooms.linker.current("omni")
        assert order is not None
        assert order.expires_ns == due_ns + order.skill.order_lifetime_ns


async def test_it_begins_only_once_that_can_be_written_and_is_late_else() -> None:
    store = BrokenStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        await plan(here, "/at 16:00 omni wave")
        store.broken = True
        await later(here, 4 * HOUR_S)
        assert here.acted() == 0
        store.broken = False
        await later(here, 3)
        assert here.acted() == 1
        worker(here).end(OrderEnding.DONE)
        store.broken = True
        told = await later(here, HOUR_S) + await later(here, 6)
        assert "was for 16:00, and I could not begin it in time" in told
        store.broken = False
        await later(here, 5)
        assert here.acted() == 1


# ---- over a restart ----


async def test_what_is_planned_waits_over_a_restart() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
    async with lab(store).open() as here:
        quick(here)
        told = await later(here, 4 * HOUR_S)
        assert "omni: move, 1.00 m forward · planned 1" in told
        assert "Planned as 2" in await plan(here, "/at 16:00 omni wave")


async def test_what_was_under_way_is_said_and_not_gone_on_with() -> None:
    store = Recording()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m; cf1 wave")
        await plan(here, "/every day 15:00 kuka1 wave; cf2 wave")
        await later(here, 4 * HOUR_S)
        kept = list(store.written)
    crashed = MemoryStore()  # as it was on disk at that moment
    await crashed.open()
    await crashed.write(*kept)
    here = lab(crashed)
    here.clock.jump_wall(4 * HOUR_S + 60)
    async with here.open():
        await later(here, 5)
        told = str([told.outbound.text for told in here.chat.told])
        assert told.count("was under way when I was shut down. What had not begun is not") == 2
        assert (here.acted("cf1"), here.acted("cf2")) == (0, 0)
        assert list(schedule(here).orders) == ["2"], "what comes again goes on"


async def test_an_orderly_end_in_between_is_said_once() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m; cf1 wave")
        await later(here, 4 * HOUR_S)
    told = str([told.outbound.text for told in here.chat.told])
    again = lab(store)
    again.clock.jump_wall(4 * HOUR_S + 60)
    async with again.open():
        await later(again, 5)
        assert again.acted("cf1") == 0
        assert not schedule(again).orders
    told += str([told.outbound.text for told in again.chat.told])
    over = told.count("was under way when I was shut down"), told.count("the rest was not done")
    assert sum(over) == 1, "at the end, or at the next start"


async def test_its_next_time_does_not_begin_while_it_is_under_way() -> None:
    async with lab().open() as here:
        await plan(here, "/every day 15:00 omni move 1 m; cf1 wave")
        await later(here, 4 * HOUR_S)
        worker(here).work_s = 10 * DAY_S
        told = await next_time(here)
        assert "was not done this time: it is under way still." in told
        assert here.acted() == 1


async def test_a_robot_that_was_retired_meanwhile_does_nothing() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
        await here.say("/robot retire omni")
        told = await later(here, 4 * HOUR_S)
        assert "Planned order 1 (omni move 1 m) was not done: " in told
        assert here.acted() == 0


CHANGED = replace(
    FLEET[0],
    skills={
        **FLEET[0].skills,
        "move": replace(
            MOVE, parameters={**MOVE.parameters, "fast": Parameter(min=0, max=1, default=0)}
        ),
    },
)
BACK = replace(
    FLEET[0],
    skills={
        **FLEET[0].skills,
        "move": replace(
            MOVE,
            parameters={
                **MOVE.parameters,
                "direction": replace(MOVE.parameters["direction"], default="back"),
            },
        ),
    },
)
WAVES = replace(FLEET[0], skills={"wave": Skill(id="wave")})


@pytest.mark.parametrize(
    ("fleet", "why"),
    [
        ((BACK, *FLEET[1:]), "It is not what was shown any more, now it would be: omni: move"),
        ((CHANGED, *FLEET[1:]), "It is not what was shown any more"),
        ((WAVES, *FLEET[1:]), 'omni has no "move"'),
        (FLEET[1:], "was not done: "),
    ],
)
async def test_what_would_be_something_else_by_then_is_not_done(
    fleet: tuple[object, ...], why: str
) -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni move 1 m")
    here = lab(store, fleet=fleet)  # type: ignore[arg-type]
    async with here.open():
        told = await later(here, 4 * HOUR_S)
        assert why in told
        assert not any(robot.acted for robot in here.gateway.robots.values())  # type: ignore[attr-defined]


async def test_a_group_that_has_another_member_by_then_is_not_moved() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 swarm wave")
    here = lab(store, fleet=(replace(FLEET[0], groups=("swarm",)), *FLEET[1:]))
    async with here.open():
        told = await later(here, 4 * HOUR_S)
        assert "not what was shown any more" in told
        assert here.acted("cf1") == here.acted("omni") == 0
