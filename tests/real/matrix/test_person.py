"""Two people at real clients, on a real homeserver: what tests of Matrix see through."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest

from tests.real.matrix.database import found_in
from tests.real.matrix.person import NotDone, Person

if TYPE_CHECKING:
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse


@pytest.mark.parametrize("encrypted", [True, False])
async def test_two_people_talk(synapse: Synapse, tmp_path: Path, *, encrypted: bool) -> None:
    async with (
        Person(synapse.create_account("Ada"), tmp_path / "ada") as ada,
        Person(synapse.create_account("Bo"), tmp_path / "bo") as bo,
    ):
        room = await ada.create_room(bo.user, encrypted=encrypted)
        await bo.join(room)
        assert await ada.members(room) == {ada.user, bo.user}

        first = await ada.say(room, "drive 1 2")
        gone = await ada.say(room, "never mind")
        await ada.edit(room, first, "drive 3 4")
        await ada.redact(room, gone)
        await bo.react(room, first, "👍")
        withdrawn = await bo.react(room, first, "👎")
        await bo.redact(room, withdrawn)
        reply = await bo.say(room, "very well", reply_to=first, thread=first)
        await bo.send_file(room, "report.txt", b"all is well " * 1000)
        await bo.show_location(room, 48.1, 11.6)

        for person in (ada, bo):
            seen = await person.sees(room)
            assert [(one.text, one.edits, one.encrypted) for one in seen] == [
                ("drive 3 4", 1, encrypted),
                ("very well", 0, encrypted),
                ("report.txt", 0, encrypted),
                ("Here", 0, encrypted),
            ]
            assert seen[0].reactions == {"👍": {bo.user}}
            assert (seen[1].id, seen[1].reply_to, seen[1].thread) == (reply, first, first)
            assert await person.files(room) == [("report.txt", b"all is well " * 1000)]
            assert person.timeline(room).unreadable == []
            assert await person.sees(room, ada.user) == seen[:1]

    for text in ("drive 3 4", "never mind", "very well", "report.txt", "all is well"):
        assert bool(found_in(synapse, text)) is not encrypted


async def test_a_device_is_the_same_after_a_restart_of_both(
    synapse: Synapse, tmp_path: Path
) -> None:
    account = synapse.create_account("Ada")
    async with Person(synapse.create_account("Bo"), tmp_path / "bo") as bo:
        async with Person(account, tmp_path / "ada") as ada:
            room = await bo.create_room(ada.user)
            await ada.join(room)
            device = ada.device
        await bo.say(room, "while you were away")
        synapse.restart()
        async with Person(account, tmp_path / "ada") as ada:
            assert ada.device == device
            await ada.hears(room, "while you were away")
            await ada.say(room, "here again")
        await bo.hears(room, "here again")


async def test_people_compare_emoji(synapse: Synapse, tmp_path: Path) -> None:
    async with (
        Person(synapse.create_account("Ada"), tmp_path / "ada") as ada,
        Person(synapse.create_account("Bo"), tmp_path / "bo") as bo,
    ):
        room = await ada.create_room(bo.user)
        await bo.join(room)
        transaction = await ada.begin_verification(bo.user, bo.device)
        assert await bo.accept_verification(ada.user) == transaction
        shown, same = await asyncio.gather(ada.emoji(transaction), bo.emoji(transaction))
        assert len(shown) == 7
        assert shown == same
        await asyncio.gather(ada.confirm(transaction), bo.confirm(transaction))
        assert bo.client.device_store[ada.user][ada.device].verified
        assert ada.client.device_store[bo.user][bo.device].verified


async def test_what_the_homeserver_refuses_is_said(synapse: Synapse, tmp_path: Path) -> None:
    async with Person(synapse.create_account("Ada"), tmp_path / "ada") as ada:
        with pytest.raises(NotDone, match="M_"):
            await ada.join("!nowhere:rosic.test")
