"""The machine's clock is set back a day: what has ended does not begin again."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.admin.api import AdminRequest, AdminVerb, books_of
from rosic.app.admin.dispatch import AdminApi
from rosic.core.policy.query import Allow
from rosic.core.policy.roles import Grant
from rosic.core.robot.profile import Slots
from rosic.organiser.refusals import CLOCK_SET_BACK
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import MemoryLatch
from rosic.testing.clock import ManualClock
from tests.gateway.place import ADA, BO, STRANGER, Place
from tests.gateway.test_rights import lab, rules, who

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.records import Record

HOUR_S, DAY_S = 3_600, 86_400
ENDED = "Your access here has ended. The admin of this place can renew it."


async def write(place: Place, decide: Callable[[], tuple[Record, ...]]) -> None:
    async with place.gateway.access.changes.turn() as turn:
        await turn.write(decide())


def may(place: Place, name: str, robot: str, skill: str) -> bool:
    """Whether the rules would let somebody, whatever else stands in the way."""
    caller = place.gateway.rooms.authoriser.stand_for(who(place, name))
    return isinstance(place.gateway.rooms.organiser.decision(caller, robot, skill, {}), Allow)


async def give_an_hour(place: Place) -> None:
    """Let Bo's key be good for an hour only."""
    keys = place.gateway.access.keys
    await write(place, lambda: keys.issue(who(place, "Bo"), "test", lasts_s=HOUR_S)[1])


@pytest.mark.parametrize("back_s", [HOUR_S / 2, DAY_S])
async def test_an_expired_key_is_not_revived(back_s: float) -> None:
    async with Place().open() as place:
        await give_an_hour(place)
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        await place.clock.advance(HOUR_S)
        assert await place.say("omni wave", account=BO, chat=BO) == ENDED
        place.clock.jump_wall(-back_s)
        assert (await place.say("omni wave", account=BO, chat=BO)).startswith(ENDED)
        assert place.acted() == 1


async def test_an_expired_key_is_not_revived_by_a_restart() -> None:
    store, clock = MemoryStore(), ManualClock()
    async with Place(store, clock=clock).open() as place:
        keys = place.gateway.access.keys
        await write(place, lambda: keys.issue(who(place, "Bo"), "test", lasts_s=90)[1])
        await place.clock.advance(100)  # more than the last minute's mark says
    clock.jump_wall(-DAY_S)
    async with Place(store, clock=clock).open() as place:
        assert await place.say("omni wave", account=BO, chat=BO) == ENDED


async def test_a_right_that_has_ended_is_not_revived() -> None:
    async with Place().open() as place:
        ends_ns = place.clock.wall_ns() + HOUR_S * 10**9
        grant = Grant(id="g1", scopes=("omni:wave",), expires_ns=ends_ns)
        grants_book, vi = place.gateway.authority.grants_book, who(place, "Vi")
        await write(place, lambda: grants_book.give(vi, (grant,), "test"))
        await place.say("omni wave", account="3", chat="3")
        assert place.acted() == 1
        place.clock.jump_wall(HOUR_S)  # nobody has had time to write that it ended
        await place.say("omni wave", account="3", chat="3")
        assert place.acted() == 1
        place.clock.jump_wall(-DAY_S)
        assert may(place, "Vi", "omni", "wave") is False


async def test_a_time_that_is_over_does_not_come_again() -> None:
    async with lab(rules(), slots=Slots.REQUIRED) as place:
        calendar, now_ns = place.gateway.rooms.organiser.calendar, place.clock.wall_ns()
        bo = who(place, "Bo")
        await write(place, lambda: calendar.book(bo, "omni", now_ns, HOUR_S, "test"))
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        await place.clock.advance(HOUR_S)
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        place.clock.jump_wall(-HOUR_S / 2)
        assert may(place, "Bo", "omni", "wave") is False


async def test_a_code_that_is_too_old_lets_nobody_in() -> None:
    async with Place().open() as place:
        told = await place.say("/invite operator on omni for 2h")
        code = told.rsplit(maxsplit=1)[-1]
        place.clock.jump_wall(DAY_S)
        await place.say(code, account=STRANGER, chat=STRANGER)
        place.clock.jump_wall(-DAY_S)
        assert "You are invited" not in await place.say(code, account=STRANGER, chat=STRANGER)


async def test_a_replaced_key_ends_with_its_grace() -> None:
    async with Place().open() as place:
        bo, keys = who(place, "Bo"), place.gateway.access.keys
        authoriser, organiser = place.gateway.rooms.authoriser, place.gateway.rooms.organiser
        old = keys.current(bo)
        assert old is not None
        await write(place, lambda: keys.rotate(bo, "test", grace_s=60.0).records)
        assert [key.id for key in keys.of(bo) if keys.good(key.id)].count(old.id) == 1

        found = organiser.key_of(old.id)
        assert found is not None
        assert found.expires_ns == place.clock.wall_ns() + 60 * 10**9
        # As after a restart, or for a program that still has the old one.
        authoriser.directory._current[bo] = old
        authoriser.forget(bo)
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        await place.clock.advance(60)
        assert await place.say("omni wave", account=BO, chat=BO) == ENDED
        place.clock.jump_wall(-DAY_S)
        assert (await place.say("omni wave", account=BO, chat=BO)).startswith(ENDED)
        assert place.acted() == 1


async def test_the_owner_of_the_machine_says_when_its_clock_is_right_again() -> None:
    async with Place().open() as place:
        desk = AdminApi(books_of(place.gateway, "UTC"))
        assert "shows the latest time" in "".join(await desk.do(AdminRequest(AdminVerb.CLOCK)))
        await give_an_hour(place)
        place.clock.jump_wall(DAY_S)  # somebody set it wrong
        assert await place.say("omni wave", account=BO, chat=BO) == ENDED
        place.clock.jump_wall(-DAY_S)
        said = "".join(await desk.do(AdminRequest(AdminVerb.CLOCK)))
        assert "24 hours behind the latest time that was seen" in said
        assert ENDED in await place.say("omni wave", account=BO, chat=BO)
        await desk.do(AdminRequest(AdminVerb.CLOCK, ("accept",)))
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        decided = await place.store.decisions(1)  # type: ignore[attr-defined]
        assert decided[0].act == "accept-clock"


async def test_nothing_new_moves_while_the_clock_is_set_back() -> None:
    async with Place().open() as place:
        kuka = place.robot("kuka1")
        kuka.work_s = 3_600.0
        await place.say("kuka1 wave", account=BO, chat=BO)
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1
        place.clock.jump_wall(-1.5)  # how clocks are kept right
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 2

        place.clock.jump_wall(-DAY_S)
        told = (await place.say("omni wave", account=BO, chat=BO)).splitlines()
        assert told == [CLOCK_SET_BACK] * 2, "the admins hear of it as well"
        assert (await place.say("swarm wave")).count(CLOCK_SET_BACK) == 1, "its admin neither"
        assert (place.acted(), place.acted("cf1")) == (2, 0)
        assert "omni" in await place.say("status", account=BO, chat=BO)
        assert kuka.presence().doing, "what moves goes on"
        assert "STOP" in await place.say("stop", account=BO, chat=BO)
        assert not kuka.presence().doing

        place.clock.jump_wall(DAY_S + 1.5)
        await place.say("resume omni", account=BO, chat=BO)
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 3, "it has caught up"


async def test_what_was_stopped_before_the_clock_was_set_back_can_be_resumed() -> None:
    store, latch, clock = MemoryStore(), MemoryLatch(), ManualClock()
    async with Place(store, latch, clock=clock).open() as place:
        await place.say("stop omni")
        await clock.advance(100)
        clock.jump_wall(-DAY_S)
        assert (await place.say("resume omni")).startswith(CLOCK_SET_BACK)
        await AdminApi(books_of(place.gateway, "UTC")).do(
            AdminRequest(AdminVerb.CLOCK, ("accept",))
        )
        assert await place.say("resume omni") == "omni is ready again."
        await place.say("omni wave")
        assert place.acted() == 1
        await place.say("stop omni")
    clock.jump_wall(-DAY_S)
    async with Place(store, latch, clock=clock).open() as place:
        assert "omni is stopped, by you, since" in await place.say("omni wave")
        assert (await place.say("resume omni")).startswith("omni is ready again.")
        await AdminApi(books_of(place.gateway, "UTC")).do(
            AdminRequest(AdminVerb.CLOCK, ("accept",))
        )
        await place.say("omni wave")
        assert place.acted() == 1


async def test_the_admins_hear_of_it_once_and_the_owner_lets_things_move() -> None:
    async with Place().open() as place:
        place.clock.jump_wall(-DAY_S)
        told = await place.say("omni wave", account=BO, chat=BO)
        told += await place.say("omni wave", account=BO, chat=BO)
        await place.clock.advance(120.0)
        everything = [t.outbound for t in place.chat.told if t.outbound.text == CLOCK_SET_BACK]
        assert [outbound.chat.id for outbound in everything].count(ADA) == 1
        await AdminApi(books_of(place.gateway, "UTC")).do(
            AdminRequest(AdminVerb.CLOCK, ("accept",))
        )
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 1


async def test_a_restart_forgets_no_clock_that_was_set_back() -> None:
    store, clock = MemoryStore(), ManualClock()
    async with Place(store, clock=clock).open():
        await clock.advance(100)
    clock.jump_wall(-DAY_S)
    async with Place(store, clock=clock).open() as place:
        assert await place.say("omni wave", account=BO, chat=BO) == CLOCK_SET_BACK
        assert place.acted() == 0


async def test_a_key_that_expires_ends_the_motion_under_it() -> None:
    async with Place().open() as place:
        await place.clock.advance(30.0)  # long after anything was minded
        keys = place.gateway.access.keys
        await write(place, lambda: keys.issue(who(place, "Bo"), "test", lasts_s=10)[1])
        robot = place.robot("omni")
        robot.work_s = 3_600.0
        await place.say("omni wave", account=BO, chat=BO)
        await place.clock.advance(9.0)
        await place.quiet()
        assert robot.presence().doing
        await place.clock.advance(2.0)
        await place.quiet()
        assert not robot.presence().doing
        assert place.gateway.rooms.organiser.holder("omni") is None


async def test_whoever_talks_under_a_key_that_is_replaced_goes_on_under_the_new_one() -> None:
    async with Place().open() as place:
        bo, keys = who(place, "Bo"), place.gateway.access.keys
        await place.say("omni wave", account=BO, chat=BO)
        await write(place, lambda: keys.rotate(bo, "test", grace_s=60.0).records)
        await place.clock.advance(120)
        await place.say("omni wave", account=BO, chat=BO)
        assert place.acted() == 2
