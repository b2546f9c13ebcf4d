"""People whose rights have ended, and words that are not meant for ROSIC."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.core.message import ChatKind
from rosic.core.rate_limit import RateLimit
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, TWO_ADMINS, VI, Place

FLOOD = 20


class TwoAdmins(Place):
    people = TWO_ADMINS


async def revoke(place: Place, name: str) -> None:
    """Let Ada do it in her own chat."""
    await place.say(f"/revoke {name}", chat=ADA)
    await place.tap(*place.button("Revoke"))


async def test_nobody_is_sent_to_an_admin_whose_access_has_ended() -> None:
    store = MemoryStore()
    async with TwoAdmins(store).open() as place:
        await place.revoke("Ada")
        assert "Ada" not in await place.say("omni move 1 m", account=VI, chat="3")
    async with TwoAdmins(store).open() as place:
        told = await place.say("omni move 1 m", account=VI, chat="3", message="another")
        assert "Ada" not in told, told


async def test_a_revocation_stops_only_what_its_person_still_has() -> None:
    async with Place().open() as place:
        await place.say("omni wave", account=BO, chat="2")
        await place.clock.advance(3_600.0)
        assert place.gateway.rooms.organiser.holder("omni") is None
        await place.revoke("Bo")
        assert not place.robot("omni").gate.latched


@pytest.mark.parametrize("work_s", [0.0, 60.0])
async def test_what_is_at_rest_is_taken_without_a_stop_that_somebody_has_to_undo(
    work_s: float,
) -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = work_s
        await place.say("omni wave", account=BO, chat="2")
        organiser = place.gateway.rooms.organiser
        assert organiser.holder("omni") is not None
        await revoke(place, "Bo")
        assert organiser.holder("omni") is None
        assert place.gateway.rooms.stops["omni"].latched is bool(work_s)
        assert place.robot("omni").gate.latched is bool(work_s)


@pytest.mark.parametrize(
    ("work_s", "at_rest", "holds"),
    [(0.0, False, True), (0.0, None, None), (60.0, True, None)],
    ids=["hovers", "not measured", "not seen to move yet"],
)
async def test_what_may_still_move_is_stopped(
    work_s: float, at_rest: bool | None, holds: bool | None
) -> None:
    async with Place().open() as place:
        robot = place.robot("omni")
        robot.work_s = work_s
        await place.say("omni wave", account=BO, chat="2")
        said = replace(robot.presence(), at_rest=at_rest, holds=holds)
        robot.presence = lambda: said  # type: ignore[method-assign]
        await revoke(place, "Bo")
        assert place.gateway.rooms.stops["omni"].latched


async def test_a_typed_question_mark_costs_as_much_as_any_line() -> None:
    async with Place(limit=RateLimit(burst=2.0, per_s=0.1)).open() as place:
        answers = [await place.say("?omni wave") for _ in range(FLOOD)]
        assert sum(map(bool, answers)) <= 3


async def test_people_may_ask_each_other_in_a_group() -> None:
    async with Place().open() as place:
        assert await place.say("?? really", kind=ChatKind.GROUP) == ""
        assert await place.say("leave it", kind=ChatKind.GROUP) == ""
