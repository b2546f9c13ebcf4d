"""A name is its owner's to choose, and chooses nobody else's fate.

Whoever is called "Bo confirmed", "Bo operator" or "Cy for 2h" is one person with a long name; no
word of a name is read as something else, and where a line can mean two people it is asked which.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.app.admin.naming import the_one
from rosic.authoriser.directory import Directory
from rosic.core.identity import Address, Principal
from rosic.core.language import clean_name
from rosic.errors import NotUnderstood
from tests.features.access.access_gateway import VI, house
from tests.features.access.access_handlers import ADA, BO, CY, DI, ED, a_hall

if TYPE_CHECKING:
    from tests.features.access.access_handlers import Hall

WORDS = (
    "Bo",
    "confirmed",
    "operator",
    "viewer",
    "kuka1",
    "for",
    "2h",
    "back",
    "to",
    "me",
    "with",
    "as",
    "not",
    "all",
    "p-2",
    "\u200bBo",
    "Bo\u202e",
)
NAME = st.lists(st.sampled_from(WORDS), min_size=1, max_size=3).map(" ".join)


def has_access(hall: Hall, account: str) -> bool:
    found = hall.directory.at(Address("telegram", account))
    return found is not None and hall.directory.has_good_key(found[0].id)


async def test_who_is_called_confirmed_ends_nobodys_access() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "Bo confirmed", "viewer")
        for line in ("/revoke Bo confirmed", "/revoke Bo confirmed confirmed"):
            await hall.say(ADA, line)
            assert has_access(hall, BO)
            assert has_access(hall, DI)
        await hall.say(ADA, "/revoke Bo confirmed")
        await hall.tap(ADA, "Revoke")
        assert has_access(hall, BO)
        assert not has_access(hall, DI)


async def test_no_word_that_is_typed_confirms_anything() -> None:
    async with a_hall() as hall:
        for line in ("/revoke Cy Young confirmed", "/revoke p-3 confirmed", "/revoke Cy Young"):
            await hall.say(ADA, line)
            assert has_access(hall, CY)


async def test_a_question_whose_answer_has_changed_is_asked_again() -> None:
    async with a_hall() as hall:
        await hall.say(ADA, "/revoke Cy Young")
        await hall.knows(CY, "Cy Young", "admin")
        assert "admin" in await hall.tap(ADA, "Revoke")
        assert has_access(hall, CY)
        await hall.tap(ADA, "Revoke")
        assert not has_access(hall, CY)


async def test_who_is_called_like_anothers_id_is_asked_about() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "p-3", "viewer")
        assert await hall.say(ADA, "/lock p-3") == '2 people are called "p-3". Which one?'
        assert hall.ended == []
        await hall.tap(ADA, "p-3, viewer")
        assert hall.ended == [("p-4", True)]
        assert await hall.in_group(ADA, "/revoke p-3") != ""
        assert has_access(hall, CY)


async def test_a_line_that_can_mean_two_people_is_asked_about() -> None:
    async with house() as place:
        directory = place.gateway.rooms.authoriser.directory
        bo = directory.named("Bo")[0]
        directory.enrol(Principal(id="p-x", name="Bo senior", roles=(), addresses=()))
        told = await place.line(ADA, "/grant Bo senior operator kuka1 for 2h")
        assert told == '2 people are called "Bo". Which one?'
        assert place.labels(ADA) == [
            "Bo senior, without a role of their own, operator kuka1 for 2h",
            "Bo, operator, senior operator kuka1 for 2h",
        ]
        assert await place.press(ADA, "Bo, operator, senior operator kuka1 for 2h")
        assert len(place.gateway.authority.grants_book.grants_of(bo.id)) == 3
        assert not place.gateway.authority.grants_book.grants_of("p-x")


async def test_who_is_called_back_is_given_rights_like_anybody() -> None:
    async with house() as place:
        directory = place.gateway.rooms.authoriser.directory
        directory.enrol(Principal(id="p-x", name="Back", roles=("viewer",), addresses=()))
        told = await place.line(ADA, "/grant back operator kuka1 for 2h")
        assert told == "Back has no access. Nothing was done." or "Back" in told


async def test_an_access_request_is_not_answered_for_somebody_of_a_longer_name() -> None:
    async with house(Bo="viewer") as place:
        directory = place.gateway.rooms.authoriser.directory
        bo = directory.named("Bo")[0]
        directory.enrol(
            Principal(id=bo.id, name="Vi for 2h", roles=bo.roles, addresses=bo.addresses)
        )
        await place.line(BO, "/ask omni move")
        await place.line(VI, "/ask omni wave")
        told = await place.line(ADA, "/approve Vi for 2h")
        assert told.startswith("These wait for your answer:")
        assert {"Allow Vi 1 h", "Allow Vi for 2h 1 h"} <= set(place.labels(ADA))
        assert len(place.gateway.access.access_requests.open()) == 2
        assert (await place.press(ADA, "Allow Vi 1 h")).startswith("Vi may now: wave on omni")


async def test_who_wants_in_under_a_members_name_is_not_let_in_by_an_answer_to_them() -> None:
    async with house() as place:
        await place.line(VI, "/ask omni wave")
        told = await place.line(ADA, "/invite viewer confirm as Vi")
        code = told.partition("Code ")[2][:9]
        await place.say(code, account="77", chat="77")
        await place.press("77", "Join")
        [waits] = place.gateway.access.enrolment.applicants.all()
        assert waits.name == "Vi 2", "nobody comes in under a name that is taken"
        assert (await place.line(ADA, "/approve Vi")).startswith("Vi may now: wave on omni")
        assert place.gateway.access.enrolment.applicants.all()


@pytest.mark.parametrize(
    "name", ["Ada", "\u0410D\u0410", "Ad\u0430", "A d a", "A\u200bda", "Àda", "ADA"]
)
async def test_nobody_comes_in_under_a_name_that_looks_like_anothers(name: str) -> None:
    async with a_hall() as hall:
        hall._names[DI] = clean_name(name)
        await hall.say(DI, await hall.invited("viewer"))
        await hall.tap(DI, "Join")
        [found] = [p for p in hall.directory.people() if p.addresses[0].account == DI]
        assert found.name == f"{clean_name(name)} 2"


async def test_a_name_of_nothing_that_can_be_seen_is_nobodys() -> None:
    directory = Directory()
    directory.enrol(Principal(id="p-1", name="", roles=(), addresses=()))
    assert directory.called("\u200b\u202e") == ()


def test_the_operator_is_asked_too() -> None:
    directory = Directory()
    directory.enrol(Principal(id="p-1", name="Ada", roles=(), addresses=()))
    directory.enrol(Principal(id="p-2", name="p-1", roles=(), addresses=()))
    with pytest.raises(NotUnderstood, match="Several people"):
        the_one(directory, "p-1")
    assert the_one(directory, "p-2").name == "p-1"


@settings(max_examples=60, deadline=None)
@given(
    names=st.lists(NAME, min_size=1, max_size=3),
    said=NAME,
    verb=st.sampled_from(["revoke", "lock"]),
)
@pytest.mark.limit(600)
def test_only_whoever_is_called_exactly_so_is_ever_meant(
    names: list[str], said: str, verb: str
) -> None:
    asyncio.run(_means(names, said, verb))


async def _means(names: list[str], said: str, verb: str) -> None:
    accounts = (DI, ED, "6")
    async with a_hall() as hall:
        for account, name in zip(accounts, names, strict=False):
            await hall.knows(account, name, "viewer")
        before = {person.id: person.name for person in hall.directory.people()}
        exact = {person.id for person in hall.directory.called(said)}
        told = await hall.say(ADA, f"/{verb} {said}")
        touched = {
            who for who in before if hall.locks.locked(who) or not hall.directory.has_good_key(who)
        }
        if said.casefold() in {"me", "myself"}:
            return  # oneself, in a few words that are nobody's name first
        assert told
        assert touched <= exact
        assert not touched or len(exact) == 1
        assert not touched or verb == "lock", "an access ends after a question only"
