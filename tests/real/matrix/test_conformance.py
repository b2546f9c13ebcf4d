"""Matrix under the rules of all messengers, in encrypted and in plain rooms of a real server."""

from __future__ import annotations

from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest

from rosic.core.message import Chat, MessageValidity
from rosic.messengers.matrix.messenger import matrix_messenger
from rosic.messengers.matrix.signs import KEYS
from rosic.messengers.matrix.sync import POSITION_FILE
from rosic.system import SystemClock
from rosic.testing.messenger_harness import listening
from rosic.testing.messengers import MessengerConformance, SeenMessage
from tests.real.matrix.person import Person
from tests.real.matrix.relay import Relay

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from contextlib import AbstractAsyncContextManager
    from pathlib import Path

    from rosic.contracts.messenger import Messenger
    from tests.real.matrix.synapse import Synapse

PATIENCE_S = 60.0


class MatrixStage:
    """Two people, each in a room of their own with the account of the robots."""

    patience_s = PATIENCE_S
    keeps = True
    taps = True
    unusual: tuple[MessageValidity, ...] = (MessageValidity.EDITED,)

    def __init__(
        self, settings: dict[str, Any], relay: Relay, persons: dict[str, tuple[Person, str]]
    ) -> None:
        messenger = matrix_messenger("lab", settings, SystemClock())
        self.settings = settings
        self.messenger: Messenger = messenger
        self._own = messenger
        self.relay = relay
        self.persons = persons
        self.people: tuple[str, ...] = tuple(persons)

    def chat(self, person: str) -> Chat:
        return Chat("matrix", self.persons[person][1])

    async def write(self, person: str, text: str) -> None:
        who, room = self.persons[person]
        await who.say(room, text)

    async def write_unusually(self, person: str, text: str, standing: MessageValidity) -> None:
        assert standing is MessageValidity.EDITED
        who, room = self.persons[person]
        written = await who.say(room, "hello")
        await who.edit(room, written, text)

    async def tap(self, person: str, message: str, label: str) -> None:
        who, room = self.persons[person]
        own = self._own.account

        def lines() -> list[str]:
            seen = who.timeline(room).messages.get(message)
            return [] if seen is None else seen.text.split("\n")

        def signed() -> bool:
            at = [n for n in range(len(KEYS)) if f"{n + 1}. {label}" in lines()]
            reactions = who.timeline(room).messages[message].reactions if at else {}
            return bool(at) and own in reactions.get(KEYS[at[0]], set())

        await who.until(signed)
        number = next(n for n in range(len(KEYS)) if f"{n + 1}. {label}" in lines())
        await who.react(room, message, KEYS[number])

    async def screen(self, person: str) -> list[SeenMessage]:
        who, room = self.persons[person]
        return [SeenMessage(s.id, s.text) for s in await who.sees(room, self._own.account)]

    async def files(self, person: str) -> list[tuple[str, bytes]]:
        who, room = self.persons[person]
        return await who.files(room, self._own.account)

    async def enclose(self, person: str, name: str, content: bytes) -> None:
        who, room = self.persons[person]
        await who.send_file(room, name, content)

    async def pinned(self, person: str) -> list[str]:
        who, room = self.persons[person]
        answer = await who.client.room_get_state_event(room, "m.room.pinned_events")
        return list(answer.content.get("pinned", []))

    async def unconfirmed(self) -> int:
        token = (self._own._client.folder.read(POSITION_FILE) or b"").decode()
        count = 0
        for who, room in self.persons.values():
            answer = await who.client.room_messages(room, token, direction="f", limit=100)
            said = [e for e in answer.chunk if e.sender == who.user and "state_key" not in e.source]
            count += len(said)
        return count

    def outage(self) -> AbstractAsyncContextManager[None]:
        return self.relay.outage()


@asynccontextmanager
async def matrix_stage(
    synapse: Synapse, folder: Path, *, encrypted: bool
) -> AsyncIterator[MatrixStage]:
    robots = synapse.create_account("robots")
    async with AsyncExitStack() as stack:
        relay = await stack.enter_async_context(Relay(robots.url).running())
        settings: dict[str, Any] = {
            "homeserver": relay.url,
            "user": robots.user,
            "password": robots.password,
            "folder": str(folder / "robots"),
            "require_verified": False,
        }
        persons: dict[str, tuple[Person, str]] = {}
        stage = MatrixStage(settings, relay, persons)
        for name in ("ada", "bob"):
            person = Person(synapse.create_account(name), folder / name)
            persons[name] = (await stack.enter_async_context(person), "")
        async with listening(stage):
            for name, (person, _) in list(persons.items()):
                room = await person.create_room(robots.user, encrypted=encrypted, direct=True)
                persons[name] = (person, room)
                await _joined(person, room, robots.user)
        stage.people = tuple(persons)
        yield stage


async def _joined(person: Person, room: str, user: str) -> None:
    await person.until(
        lambda: (
            user in person.client.rooms[room].users
            and user not in person.client.rooms[room].invited_users
        )
    )


class TestEncrypted(MessengerConformance):
    @pytest.fixture
    async def stage(self, synapse: Synapse, tmp_path: Path) -> AsyncIterator[MatrixStage]:
        async with matrix_stage(synapse, tmp_path, encrypted=True) as stage:
            yield stage


class TestPlain(MessengerConformance):
    @pytest.fixture
    async def stage(self, synapse: Synapse, tmp_path: Path) -> AsyncIterator[MatrixStage]:
        async with matrix_stage(synapse, tmp_path, encrypted=False) as stage:
            yield stage
