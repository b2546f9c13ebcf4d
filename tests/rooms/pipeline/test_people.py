"""People whose rights have ended, and words that are not meant for ROSIC."""

from __future__ import annotations

from rosic.core.message import ChatKind
from rosic.core.rate import RateLimit
from rosic.stores.memory import MemoryStore
from tests.rooms.pipeline.place import BO, VI, Place

FLOOD = 20


async def test_nobody_is_sent_to_an_admin_whose_access_has_ended() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        ada = place.gateway.rooms.authoriser.directory.named("Ada")[0].id
        await place.gateway.revoke(ada, "test")
        assert "Ada" not in await place.say("omni move 1 m", account=VI, chat="3")
    async with Place(store).open() as place:
        told = await place.say("omni move 1 m", account=VI, chat="3", message="another")
        assert "Ada" not in told, told


async def test_a_revocation_stops_only_what_its_person_still_has() -> None:
    async with Place().open() as place:
        await place.say("omni wave", account=BO, chat="2")
        await place.clock.advance(3_600.0)
        assert place.gateway.rooms.organiser.holder("omni") is None
        bo = place.gateway.rooms.authoriser.directory.named("Bo")[0].id
        await place.gateway.revoke(bo, "test")
        assert not place.robot("omni").gate.latched


async def test_a_typed_question_mark_costs_as_much_as_any_line() -> None:
    async with Place(limit=RateLimit(burst=2.0, per_s=0.1)).open() as place:
        answers = [await place.say("?omni wave") for _ in range(FLOOD)]
        assert sum(map(bool, answers)) <= 3


async def test_people_may_ask_each_other_in_a_group() -> None:
    async with Place().open() as place:
        assert await place.say("?? really", kind=ChatKind.GROUP) == ""
        assert await place.say("leave it", kind=ChatKind.GROUP) == ""
