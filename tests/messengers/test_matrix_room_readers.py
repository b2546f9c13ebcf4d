"""Whom a homeserver adds to a room, or to somebody's devices, is given no keys."""

from __future__ import annotations

from pathlib import Path
from typing import Final

import pytest

from rosic.messengers.matrix.room_readers import RoomReaders
from rosic.messengers.matrix.room_table import JoinedRoom
from rosic.messengers.matrix.settings import MatrixSettings
from tests.messengers.matrix_identities import (
    ADA,
    EVE,
    ROBOT,
    Account,
    Device,
    Person,
    met,
    robot_account,
)

BOB: Final = "@bob:example.org"
ROOM: Final = "!room:example.org"


class Lab:
    """The robot, who knows Ada and Bob, in a room with some people."""

    def __init__(self, *members: str, strict: bool = True) -> None:
        self.account: Account = robot_account()
        self.people = {user: Person(user) for user in (ADA, BOB, EVE)}
        for person in self.people.values():
            self.account.homeserver.knows(person)
        settings = MatrixSettings(
            homeserver="https://example.org",
            user=ROBOT,
            folder=Path("/nowhere"),
            require_verified=strict,
        )
        knows = {ADA, BOB}.__contains__
        self.readers = RoomReaders(self.account.cross_signing, settings, knows)
        self.room = JoinedRoom(encrypted=True)
        self.enters(ROBOT, *members)

    def enters(self, *members: str) -> None:
        for user in members:
            self.becomes(user, "join")

    def becomes(self, user: str, membership: str) -> None:
        content = {"membership": membership}
        self.room.follow({"type": "m.room.member", "state_key": user, "content": content})

    async def compares(self, user: str) -> None:
        phone = await met(self.account, self.people[user])
        await self.account.cross_signing.compared(phone, self.people[user].master_public)

    async def given(self) -> set[tuple[str, str]]:
        return {(one.user, one.device) for one in await self.readers.of(ROOM, self.room)}


@pytest.fixture
async def lab() -> Lab:
    found = Lab(ADA, BOB, EVE)
    await found.account.cross_signing.start()
    return found


async def test_a_stranger_whom_the_homeserver_adds_is_given_none(lab: Lab) -> None:
    assert await lab.given() == {(ADA, "PHONE"), (BOB, "PHONE")}


async def test_where_keys_were_compared_nobody_else_is_given_any(lab: Lab) -> None:
    await lab.compares(ADA)
    assert await lab.given() == {(ADA, "PHONE")}
    lab.becomes(ADA, "leave")  # so the homeserver says
    assert await lab.given() == set()


async def test_a_device_that_nobody_vouches_for_is_given_none(lab: Lab) -> None:
    for _ in range(2):
        lab.account.homeserver.add(Device(ADA, "INSERTED"))
        lab.account.homeserver.add(Device(BOB, "INSERTED"))
        lab.account.directory.forget(ADA)
        lab.account.directory.forget(BOB)
        assert (ADA, "PHONE") in await lab.given()
        assert not {(ADA, "INSERTED"), (BOB, "INSERTED")} & await lab.given()
        await lab.compares(ADA)


async def test_when_other_keys_are_shown_nobody_is_given_any(lab: Lab) -> None:
    assert (ADA, "PHONE") in await lab.given()
    lab.account.homeserver.knows(Person(ADA))
    lab.account.directory.forget(ADA)
    assert await lab.given() == {(BOB, "PHONE")}


async def test_among_strangers_alone_everybody_may_read_how_to_begin() -> None:
    lab = Lab(EVE)
    await lab.account.cross_signing.start()
    assert await lab.given() == {(EVE, "PHONE")}


async def test_where_unverified_devices_are_followed_everybody_there_is_given_them() -> None:
    lab = Lab(ADA, EVE, strict=False)
    await lab.account.cross_signing.start()
    assert await lab.given() == {(ADA, "PHONE"), (EVE, "PHONE")}


async def test_somebody_without_cross_signing_is_given_keys_on_all_devices() -> None:
    lab = Lab(ADA)
    await lab.account.cross_signing.start()
    for table in ("master_keys", "self_signing_keys"):
        del lab.account.homeserver.shown[table][ADA]
    lab.account.homeserver.add(Device(ADA, "LAPTOP"))
    assert await lab.given() == {(ADA, "PHONE"), (ADA, "LAPTOP")}
