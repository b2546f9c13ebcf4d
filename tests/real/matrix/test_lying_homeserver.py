"""A homeserver that changes what it passes on: messages really encrypted, in another's name."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest

from rosic.messengers.matrix.trust import SenderAssurance
from tests.real.matrix.person import Person
from tests.real.matrix.verifier import Verifier

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable
    from pathlib import Path

    from tests.real.matrix.synapse import Synapse

Event = dict[str, Any]


class Liar:
    """Stands where the homeserver's answers arrive, and changes encrypted events of rooms.

    Attributes:
        change: Is given an event as it came, and changes it; None: honest.
    """

    def __init__(self, robot: Verifier) -> None:
        self.change: Callable[[Event], None] | None = None
        self._honest = robot.client.read_body
        robot.client.read_body = self._read  # type: ignore[method-assign]

    async def _read(self, response: object, most: int) -> bytes:
        told = json.loads(await self._honest(response, most) or "null")
        joined = told.get("rooms", {}).get("join", {}) if isinstance(told, dict) else {}
        for room in joined.values():
            for event in room.get("timeline", {}).get("events", ()):
                if self.change is not None and event["type"] == "m.room.encrypted":
                    self.change(event)
        return json.dumps(told).encode()


class World:
    """The robot, Ada whose keys it has compared, and Eve, in one encrypted room."""

    def __init__(self, robot: Verifier, ada: Verifier, eve: Person) -> None:
        self.robot, self.ada, self.eve = robot, ada, eve
        self.liar = Liar(robot)
        self.room = ""

    async def meet(self) -> None:
        self.room = await self.eve.create_room(self.robot.user, self.ada.user)
        await self.robot.join(self.room)
        await self.ada.join(self.room)
        keys, _ = await self.robot.cross_signing.look_up(self.ada.user)
        device = keys.device(self.ada.device)
        assert device is not None
        await self.robot.cross_signing.compared(device, keys.master)
        await self.robot.cross_signing.look_up(self.eve.user)
        assert await self.hears_ada("honest") is SenderAssurance.ENCRYPTED_VERIFIED
        assert await self.hears_eve("honest, too") is SenderAssurance.ENCRYPTED_UNVERIFIED

    async def hears_ada(self, text: str) -> SenderAssurance | None:
        content = {"msgtype": "m.text", "body": text}
        await self.ada.client.send(self.room, "m.room.message", content)
        return await self._heard(text)

    async def hears_eve(self, text: str) -> SenderAssurance | None:
        await self.eve.say(self.room, text)
        return await self._heard(text)

    async def _heard(self, text: str) -> SenderAssurance | None:
        await self.robot.until(lambda: text in dict(self.robot.heard) or bool(self.robot.unread))
        if self.robot.unread:
            self.robot.unread.clear()
            return None  # there is no such session, or it did not encrypt that
        return dict(self.robot.heard)[text]


@pytest.fixture
async def world(synapse: Synapse, tmp_path: Path) -> AsyncIterator[World]:
    async with (
        Verifier(synapse.create_account("Robot"), tmp_path / "robot") as robot,
        Verifier(synapse.create_account("Ada"), tmp_path / "ada") as ada,
        Person(synapse.create_account("Eve"), tmp_path / "eve") as eve,
    ):
        found = World(robot, ada, eve)
        await found.meet()
        yield found


async def test_nothing_passes_in_the_name_of_another(world: World) -> None:
    ada_key = world.ada.client.machine.account.identity_keys["curve25519"]

    def by_ada(event: Event) -> None:
        event["sender"] = world.ada.user

    def by_adas_device(event: Event) -> None:
        by_ada(event)
        event["content"]["device_id"] = world.ada.device

    def with_adas_key(event: Event) -> None:
        by_adas_device(event)
        event["content"]["sender_key"] = ada_key

    for number, lie in enumerate((by_ada, by_adas_device)):
        world.liar.change = lie
        assert await world.hears_eve(f"drive {number}") is SenderAssurance.FORGED
    world.liar.change = with_adas_key
    assert await world.hears_eve("drive 3") is None

    def by_eve(event: Event) -> None:
        event["sender"] = world.eve.user

    world.liar.change = by_eve
    assert await world.hears_ada("stand still") is SenderAssurance.FORGED


async def test_what_the_homeserver_says_of_the_device_means_nothing(world: World) -> None:
    def by_another_device(event: Event) -> None:
        event["content"]["device_id"] = "INSERTED"

    world.liar.change = by_another_device
    assert await world.hears_ada("drive 1 2") is SenderAssurance.ENCRYPTED_VERIFIED
    assert await world.hears_eve("drive 3 4") is SenderAssurance.ENCRYPTED_UNVERIFIED


async def test_a_ciphertext_that_was_changed_is_not_read(world: World) -> None:
    def changed(event: Event) -> None:
        text = event["content"]["ciphertext"]
        event["content"]["ciphertext"] = text[:-4] + ("AAAA" if text[-4:] != "AAAA" else "BBBB")

    world.liar.change = changed
    assert await world.hears_ada("drive 1 2") is None
