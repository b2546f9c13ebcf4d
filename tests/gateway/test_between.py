"""What ends between acceptance and dispatch: the order does not begin (I8)."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.admin.api import AdminVerb
from rosic.core.policy.roles import Grant
from rosic.core.records import Claimed, Resumed
from rosic.core.robot.profile import Slots
from rosic.organiser.refusals import CLOCK_SET_BACK
from tests.gateway.place import ADA, BO, FLEET, VI, Place, SlowStore, ask_as_operator
from tests.gateway.test_rights import rules, who

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.records import Record

HOUR_S, DAY_S = 3_600, 86_400
A_SECOND_LEFT_S = 59.0


@asynccontextmanager
async def booked(slots: Slots = Slots.REQUIRED) -> AsyncIterator[Place]:
    """Run a place whose disk is slow with claims, where Bo has a minute with each of two robots."""
    fleet = tuple(replace(profile, slots=slots) for profile in FLEET)
    place = Place(SlowStore(Claimed), fleet=fleet)
    place.gateway._settings = replace(place.gateway._settings, rulebook=rules(preempt=("omni",)))
    async with place.open():
        calendar, now_ns = place.gateway.rooms.organiser.calendar, place.clock.wall_ns()
        async with place.gateway.access.changes.turn() as turn:
            for robot in ("omni", "kuka1"):
                await turn.write(calendar.book(who(place, "Bo"), robot, now_ns, 60, "test"))
        await place.clock.advance(0.1)
        yield place


async def accepted(place: Place, line: str, name: str = "Bo") -> None:
    """Let somebody give an order that is accepted; its claim is on the way to the disk."""
    account = {"Bo": BO, "Vi": VI}[name]
    place.chat.say(line, account=account, chat=account)
    await place.quiet()
    assert place.gateway.rooms.organiser.holder(line.split(maxsplit=1)[0]) == who(place, name)


async def written(place: Place) -> str:
    """Let the disk be ready; return what was told since."""
    before = len(place.chat.told)
    assert isinstance(place.store, SlowStore)
    place.store.ready.set()
    await place.quiet()
    await place.clock.advance(0.1)
    return "\n".join(place.chat.shown(told.message).text for told in list(place.chat.told)[before:])


async def test_in_time_it_begins() -> None:
    async with booked() as place:
        await place.clock.advance(A_SECOND_LEFT_S)
        await accepted(place, "omni wave")
        await written(place)
        assert place.acted() == 1


@pytest.mark.parametrize("seen", [True, False])
async def test_a_slot_that_ends(seen: bool) -> None:
    """Whether or not whoever follows the calendar has woken up for it."""
    async with booked() as place:
        await place.clock.advance(A_SECOND_LEFT_S + 0.5)
        await accepted(place, "omni wave")
        if seen:
            await place.clock.advance(0.9)  # an order waits a second for the record, and no longer
        else:
            place.clock.jump_wall(2.0)
        told = await written(place)
        assert place.acted() == 0
        assert "Nothing was done" in told


async def test_a_slot_of_somebody_else_that_begins() -> None:
    async with booked(Slots.RESPECTED) as place:
        calendar, access = place.gateway.rooms.organiser.calendar, place.gateway.access
        now_ns = place.clock.wall_ns()
        async with access.changes.turn() as turn:
            starts_ns = now_ns + 62 * 10**9
            await turn.write(calendar.book(who(place, "Ada"), "omni", starts_ns, 60, "test"))
        await place.clock.advance(61.0)
        await accepted(place, "omni wave")
        place.clock.jump_wall(2.0)
        told = await written(place)
        assert place.acted() == 0
        assert "Ada" in told


async def test_a_slot_that_is_given_back_by_somebody_else() -> None:
    async with booked() as place:
        calendar, access = place.gateway.rooms.organiser.calendar, place.gateway.access
        await accepted(place, "omni wave")
        slot = calendar.present("omni", place.clock.wall_ns())
        assert slot is not None
        async with access.changes.turn() as turn:
            await turn.write(calendar.cancel(slot.id, "test", anybodys=True))
        await written(place)
        assert place.acted() == 0


async def test_what_waits_behind_another_order_when_the_slot_ends() -> None:
    async with booked() as place:
        assert isinstance(place.store, SlowStore)
        place.store.ready.set()
        kuka = place.robot("kuka1")
        kuka.work_s = HOUR_S
        await place.say("kuka1 wave", account=BO, chat=BO)
        await place.say("kuka1 move 1 m", account=BO, chat=BO)
        place.clock.jump_wall(61.0)
        assert kuka._end is not None
        kuka._end.set_result(None)
        await place.quiet()
        assert place.acted("kuka1") == 1


async def test_a_clock_that_is_set_back() -> None:
    async with booked() as place:
        await accepted(place, "omni wave")
        place.clock.jump_wall(-DAY_S)
        assert CLOCK_SET_BACK in await written(place)
        assert place.acted() == 0


async def test_a_robot_that_is_taken_over() -> None:
    async with booked() as place:
        await accepted(place, "omni wave")
        assert "omni is yours now" in await place.say("take over omni", account=ADA, chat=ADA)
        await written(place)
        assert place.acted() == 0, "it is Ada's"


async def test_a_session_that_is_ended() -> None:
    async with booked() as place:
        await accepted(place, "omni wave")
        await place.say("/end omni", account=ADA, chat=ADA)
        await written(place)
        assert place.acted() == 0


async def test_a_right_that_ends() -> None:
    async with booked(Slots.NONE) as place:
        grants_book, vi = place.gateway.authority.grants_book, who(place, "Vi")
        ends_ns = place.clock.wall_ns() + 10**9
        grant = Grant(id="g1", scopes=("omni:wave",), expires_ns=ends_ns)
        async with place.gateway.access.changes.turn() as turn:
            await turn.write(grants_book.give(vi, (grant,), "test"))
        await accepted(place, "omni wave", "Vi")
        place.clock.jump_wall(2.0)  # nobody has had time to see that it ended
        assert "ended" in await written(place)
        assert place.acted() == 0


class FirstSlowStore(SlowStore):
    """Keeps the first claim waiting, and no other."""

    def __init__(self) -> None:
        super().__init__(Claimed)
        self._first = True

    async def write(self, *records: Record) -> None:
        """Write them, the first claim once the test is ready."""
        ready = self.ready
        if any(isinstance(record, Claimed) for record in records):
            self._first, first = False, self._first
            self.ready = ready if first else _at_once()
        try:
            await super().write(*records)
        finally:
            self.ready = ready


@pytest.mark.parametrize("line", ["omni wave\nkuka1 wave\ncf1 wave", "/broadcast swarm wave"])
async def test_nothing_more_of_a_message_begins_once_its_author_is_locked(line: str) -> None:
    """Its first line waits for the disk meanwhile."""
    store = FirstSlowStore()
    async with Place(store).open() as place:
        place.chat.say(line, account=BO, chat=BO)
        await place.quiet()
        assert "locked" in await place.say("/lock Bo")
        store.ready.set()
        await place.quiet()
        await place.clock.advance(0.1)
        assert not any(robot.acted for robot in map(place.robot, ("omni", "kuka1", "cf1", "cf2")))
        told = "\n".join(told.outbound.text for told in place.chat.told)
        assert "Your access is locked" in told


def _at_once() -> asyncio.Event:
    ready = asyncio.Event()
    ready.set()
    return ready


async def test_whose_right_to_resume_ends_while_it_is_written_resumes_nothing() -> None:
    store = SlowStore(Resumed)
    async with Place(store).open() as place:
        await place.say("stop omni")
        await place.clock.advance(1.0)
        place.chat.say("resume omni", account=BO, chat=BO)
        await place.quiet()
        await ask_as_operator(place.gateway, AdminVerb.REVOKE, "Bo")
        store.ready.set()
        await place.quiet()
        await place.clock.advance(0.1)
        assert place.robot("omni").gate.latched
        assert "is stopped" in await place.say("omni wave")
