"""What happens to rooms on a real homeserver: who comes, who leaves, and where rooms move."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind, Outbound
from rosic.messengers.matrix.messenger import MatrixMessenger, matrix_messenger
from rosic.system import SystemClock
from rosic.testing.messenger_harness import HarnessInbox, settled
from tests.real.matrix.person import Person
from tests.real.matrix.synapse import synapse_in

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse


class Lab:
    """The robots' account, Ada who is known, and Eve who is not."""

    def __init__(self, messenger: MatrixMessenger, ada: Person, eve: Person) -> None:
        self.messenger = messenger
        self.ada = ada
        self.eve = eve
        self.inbox = HarnessInbox()
        self.events: list[ChatEvent] = []

    def happened(self, kind: ChatEventKind, room: str) -> list[ChatEvent]:
        return [one for one in self.events if one.what is kind and one.chat.id == room]

    async def group(self, *others: str) -> str:
        """Let Ada make a group with the robots in it, and others invited."""
        room = await self.ada.create_room(self.messenger.account, *others, name="Lab")
        await self.ada.until(partial(_is_in, self.ada, room, self.messenger.account))
        return room


@asynccontextmanager
async def lab(synapse: Synapse, folder: Path) -> AsyncIterator[Lab]:
    robots = synapse.create_account("robots")
    settings = {
        "homeserver": robots.url,
        "user": robots.user,
        "password": robots.password,
        "folder": str(folder / "robots"),
        "require_verified": False,
    }
    messenger = matrix_messenger("lab", settings, SystemClock())
    async with (
        Person(synapse.create_account("ada"), folder / "ada") as ada,
        Person(synapse.create_account("eve"), folder / "eve") as eve,
    ):
        found = Lab(messenger, ada, eve)
        messenger.settle_with(settled)
        messenger.know_with(lambda who: who.account == ada.user)
        messenger.watch_chats(found.events.append)
        run = asyncio.create_task(messenger.run(found.inbox.receive))
        try:
            yield found
        finally:
            run.cancel()
            await asyncio.wait([run])


async def test_known_people_bring_it_into_groups_and_strangers_do_not(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with lab(synapse, tmp_path) as place:
        robots = place.messenger.account
        theirs = await place.eve.create_room(robots, name="Trap")
        await place.eve.until(lambda: robots not in place.eve.client.rooms[theirs].users)
        assert robots not in await place.eve.members(theirs), "it has declined"

        room = await place.group(place.eve.user)
        assert robots in await place.ada.members(room)
        await place.ada.until(lambda: bool(place.happened(ChatEventKind.ADDED, room)))
        [added] = place.happened(ChatEventKind.ADDED, room)
        assert added.chat.kind is ChatKind.GROUP
        assert not place.happened(ChatEventKind.ADDED, theirs)


async def test_who_leaves_is_told_of_and_that_it_was_put_out(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with lab(synapse, tmp_path) as place:
        room = await place.group(place.eve.user)
        await place.eve.join(room)
        await place.eve.leave(room)
        await place.ada.until(lambda: bool(place.happened(ChatEventKind.LEFT, room)))
        [left] = place.happened(ChatEventKind.LEFT, room)
        assert left.who is not None
        assert left.who.account == place.eve.user

        await place.ada.kick(room, place.messenger.account)
        await place.ada.until(lambda: bool(place.happened(ChatEventKind.REMOVED, room)))


async def test_a_room_that_is_upgraded_is_followed(synapse: Synapse, tmp_path: Path) -> None:
    async with lab(synapse, tmp_path) as place:
        room = await place.group(place.eve.user)
        await place.eve.join(room)
        new = await _upgraded(place.ada, room)
        await place.ada.invite(new, place.messenger.account)
        await place.ada.until(lambda: bool(place.happened(ChatEventKind.MOVED, room)))
        [moved] = place.happened(ChatEventKind.MOVED, room)
        assert moved.new_id == new
        await place.ada.until(partial(_encrypted, place.ada, new))
        await place.messenger.send(
            Outbound(chat=Chat("matrix", new, ChatKind.GROUP), text="Here I am.")
        )
        assert (await place.ada.hears(new, "Here I am.")).encrypted


def _is_in(person: Person, room: str, user: str) -> bool:
    found = person.client.rooms[room]
    return user in found.users and user not in found.invited_users


def _encrypted(person: Person, room: str) -> bool:
    found = person.client.rooms.get(room)
    return found is not None and bool(found.encrypted)


async def _upgraded(person: Person, room: str) -> str:
    made = await _call(person, "POST", f"rooms/{room}/upgrade", {"new_version": "10"})
    return str(made["replacement_room"])


async def _call(person: Person, method: str, path: str, body: dict[str, Any]) -> dict[str, Any]:
    client = person.client
    assert client.client_session is not None
    async with client.client_session.request(
        method,
        f"{client.homeserver}/_matrix/client/v3/{path}",
        json=body,
        headers={"Authorization": f"Bearer {client.access_token}"},
    ) as answer:
        answer.raise_for_status()
        found: dict[str, Any] = await answer.json()
        return found


async def test_a_thread_is_a_topic_and_answers_land_in_it(synapse: Synapse, tmp_path: Path) -> None:
    async with lab(synapse, tmp_path) as place:
        room = await place.group(place.eve.user)
        await place.eve.join(room)
        root = await place.ada.say(room, "about omni")
        await place.ada.say(room, "omni status", thread=root)
        await place.ada.until(lambda: len(place.inbox.done) > 1)
        heard = place.inbox.done[-1]
        assert (heard.chat.topic, heard.answers) == (root, "")
        await place.messenger.send(Outbound(chat=heard.chat, text="at rest"))
        assert (await place.ada.hears(room, "at rest")).thread == root


async def test_a_homeserver_that_asks_to_wait_is_obeyed_and_nothing_is_lost(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "synapse"
    folder.mkdir()
    slow = {"per_second": 1.0, "burst_count": 3}
    with synapse_in(folder, rc_message=slow) as synapse:
        async with lab(synapse, tmp_path) as place:
            room = await place.ada.create_room(place.messenger.account, direct=True)
            user = place.ada.user
            await place.ada.until(lambda: place.messenger.private_chat(user) is not None)
            texts = [f"number {number}" for number in range(7)]
            began = asyncio.get_running_loop().time()
            for text in texts:
                await place.messenger.send(Outbound(chat=Chat("matrix", room), text=text))
            waited_s = asyncio.get_running_loop().time() - began
            await place.ada.hears(room, texts[-1])
            shown = [seen.text for seen in await place.ada.sees(room, place.messenger.account)]
            assert shown == texts, "each once, in order"
            assert waited_s > len(texts) - slow["burst_count"] - 2, "it was made to wait"
