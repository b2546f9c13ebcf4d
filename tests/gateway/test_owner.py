"""What the machine's owner decides at the machine is told in the chats, as if an admin had."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.app.admin.api import AdminRequest, AdminVerb, books_of
from rosic.app.admin.dispatch import AdminApi
from tests.gateway.place import ADA, BO, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@pytest.fixture
async def place() -> AsyncIterator[Place]:
    async with Place().open() as opened:
        yield opened


async def told(place: Place, verb: AdminVerb, name: str) -> list[tuple[str, str]]:
    """Ask as the owner; return who read what because of it."""
    before = len(place.chat.told)
    await AdminApi(books_of(place.gateway, "UTC")).do(AdminRequest(verb, (name,)))
    await place.quiet()
    new = list(place.chat.told)[before:]
    return sorted((one.outbound.chat.id, one.outbound.text) for one in new)


async def test_a_lock_and_its_end(place: Place) -> None:
    assert await told(place, AdminVerb.LOCK, "Bo") == [
        (ADA, "The operator locked Bo."),
        (BO, "Your access is locked. Ask an admin."),
    ]
    assert await told(place, AdminVerb.UNLOCK, "Bo") == [
        (ADA, "The operator unlocked Bo."),
        (BO, "The operator unlocked you. You may do again what you could before."),
    ]


@pytest.mark.parametrize("verb", [AdminVerb.REVOKE, AdminVerb.TAKE_KEY])
async def test_an_access_that_ends_for_good(place: Place, verb: AdminVerb) -> None:
    ended = [
        (ADA, "The operator ended the access of Bo."),
        (BO, "Your access here has ended. The admin of this place can renew it."),
    ]
    assert await told(place, verb, "Bo") == ended


async def test_one_key_of_two(place: Place) -> None:
    access = place.gateway.access
    bo = place.gateway.rooms.authoriser.directory.named("Bo")[0].id
    old = access.keys.current(bo)
    assert old is not None
    async with access.changes.turn() as turn:
        await turn.write(access.keys.rotate(bo, "test", grace_s=60).records)
    assert await told(place, AdminVerb.TAKE_KEY, old.id) == [
        (ADA, "The operator took a key of Bo back. Bo has another one."),
        (BO, "One of your keys was taken back. You can go on as before."),
    ]
    await place.say("omni wave", account=BO, chat=BO)
    assert place.acted() == 1
