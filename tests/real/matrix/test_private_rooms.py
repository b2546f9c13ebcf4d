"""Somebody who has not just asked is told in the room that they have with the robots alone."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING

import pytest

from rosic.contracts.chats import private_chat_of
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, Outbound
from rosic.messengers.matrix.messenger import MatrixMessenger, matrix_messenger
from rosic.system import SystemClock
from rosic.testing.messenger_harness import HarnessInbox, settled
from tests.real.matrix.person import Person

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse


@asynccontextmanager
async def met(
    synapse: Synapse, folder: Path, *, strict: bool
) -> AsyncIterator[tuple[MatrixMessenger, Person]]:
    robots = synapse.create_account("robots")
    settings = {
        "homeserver": robots.url,
        "user": robots.user,
        "password": robots.password,
        "folder": str(folder / "robots"),
        "require_verified": strict,
    }
    messenger = matrix_messenger("lab", settings, SystemClock())
    messenger.settle_with(settled)
    async with Person(synapse.create_account("ada"), folder / "ada") as ada:
        run = asyncio.create_task(messenger.run(HarnessInbox().receive))
        try:
            yield messenger, ada
        finally:
            run.cancel()
            await asyncio.wait([run])


async def test_a_room_is_made_for_whom_we_have_none_and_found_again(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with met(synapse, tmp_path, strict=True) as (messenger, ada):
        address = Address("matrix", ada.user)
        there = private_chat_of(messenger, address)
        assert there == Chat("matrix", ada.user), "there is none yet"
        await messenger.send(Outbound(chat=there, text="Your turn begins."))
        await ada.until(lambda: bool(ada.client.invited_rooms))
        (room,) = ada.client.invited_rooms
        await ada.join(room)
        assert (await ada.hears(room, "Your turn begins.")).encrypted

        found = private_chat_of(messenger, address)
        assert (found.id, found.kind) == (room, ChatKind.PRIVATE)
        message = await messenger.send(Outbound(chat=there, text="Your turn ends."))
        assert (await ada.hears(room, "Your turn ends.")).id == message
        assert not ada.client.invited_rooms, "the same room"


async def test_it_is_the_encrypted_one_where_somebody_wrote_last(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with met(synapse, tmp_path, strict=False) as (messenger, ada):
        address = Address("matrix", ada.user)
        one, other, plain = [
            await ada.create_room(messenger.account, encrypted=encrypted, direct=True)
            for encrypted in (True, True, False)
        ]
        rooms = ada.client.rooms
        await ada.until(lambda: not any(rooms[r].invited_users for r in (one, other, plain)))
        for room in (one, other, one):
            await ada.say(room, "hello")
            await ada.until(partial(_is_told_in, messenger, address, room))
        await ada.say(plain, "hello")
        await ada.say(other, "hello")
        await ada.until(partial(_is_told_in, messenger, address, other))


def _is_told_in(messenger: MatrixMessenger, address: Address, room: str) -> bool:
    return private_chat_of(messenger, address).id == room


@pytest.mark.parametrize("strict", [True, False])
async def test_nothing_is_told_in_the_open_where_keys_count(
    synapse: Synapse, tmp_path: Path, strict: bool
) -> None:
    async with met(synapse, tmp_path, strict=strict) as (messenger, ada):
        room = await ada.create_room(messenger.account, encrypted=False, direct=True)
        await ada.until(lambda: not ada.client.rooms[room].invited_users)
        await ada.say(room, "hello")
        there = private_chat_of(messenger, Address("matrix", ada.user))
        message = await messenger.send(Outbound(chat=there, text="Your turn begins."))
        if strict:
            await ada.until(lambda: bool(ada.client.invited_rooms))
        else:
            assert (await ada.hears(room, "Your turn begins.")).id == message


@pytest.mark.parametrize("encrypted", [True, False])
async def test_a_room_that_a_stranger_made_and_left_is_nobodys(
    synapse: Synapse, tmp_path: Path, encrypted: bool
) -> None:
    async with (
        met(synapse, tmp_path, strict=False) as (messenger, ada),
        Person(synapse.create_account("mallory"), tmp_path / "mallory") as mallory,
    ):
        robots = messenger.account
        room = await mallory.create_room(robots, ada.user, encrypted=encrypted, direct=True)
        known = mallory.client.rooms[room]
        await mallory.until(lambda: robots in known.users and robots not in known.invited_users)
        await ada.join(room)
        await mallory.leave(room)
        await ada.say(room, "hello")

        there = private_chat_of(messenger, Address("matrix", ada.user))
        await messenger.send(Outbound(chat=there, text="Your turn begins."))
        await ada.until(lambda: bool(ada.client.invited_rooms))
        assert room not in ada.client.invited_rooms
        assert not [seen for seen in await ada.sees(room, robots) if "turn" in seen.text]
