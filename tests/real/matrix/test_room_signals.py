"""What people see while they wait: ROSIC is deciding, and has read what is settled."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.messengers.matrix.messenger import matrix_messenger
from rosic.system import SystemClock
from tests.pace import pace
from tests.real.matrix.person import Person

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.core.message import Inbound
    from tests.real.matrix.synapse import Synapse


class Deciding:
    """A gateway that decides when the test says so, and whose disk is as slow as it likes."""

    def __init__(self, known: str) -> None:
        self.known = known
        self.heard: list[Inbound] = []
        self.decided = asyncio.Event()
        self.settled = asyncio.Event()

    async def receive(self, inbound: Inbound) -> None:
        self.heard.append(inbound)
        await self.decided.wait()

    async def settle(self, within_s: float) -> bool:
        try:
            await asyncio.wait_for(self.settled.wait(), within_s * pace())
        except TimeoutError:
            return False
        return True


@asynccontextmanager
async def deciding(
    synapse: Synapse, folder: Path
) -> AsyncIterator[tuple[Deciding, Person, str, str]]:
    robots = synapse.create_account("robots")
    settings = {
        "homeserver": robots.url,
        "user": robots.user,
        "password": robots.password,
        "folder": str(folder / "robots"),
        "require_verified": False,
    }
    messenger = matrix_messenger("lab", settings, SystemClock())
    async with Person(synapse.create_account("ada"), folder / "ada") as ada:
        gateway = Deciding(ada.user)
        messenger.settle_with(gateway.settle)
        messenger.know_with(lambda who: who.account == gateway.known)
        run = asyncio.create_task(messenger.run(gateway.receive))
        try:
            room = await ada.create_room(robots.user, direct=True)
            await ada.until(lambda: not ada.client.rooms[room].invited_users)
            yield gateway, ada, room, robots.user
        finally:
            run.cancel()
            await asyncio.wait([run])


def _read(ada: Person, room: str, user: str) -> str:
    receipt = ada.client.rooms[room].read_receipts.get(user)
    return "" if receipt is None else receipt.event_id


async def test_what_takes_a_while_is_shown_and_what_is_settled_is_read(
    synapse: Synapse, tmp_path: Path
) -> None:
    async with deciding(synapse, tmp_path) as (gateway, ada, room, robots):
        said = await ada.say(room, "omni move 1 m")
        await ada.until(lambda: robots in ada.client.rooms[room].typing_users)
        assert _read(ada, room, robots) != said, "nothing is decided yet"

        gateway.decided.set()
        await ada.until(lambda: robots not in ada.client.rooms[room].typing_users)
        assert _read(ada, room, robots) != said, "nothing is on disk yet"

        gateway.settled.set()
        await ada.until(lambda: _read(ada, room, robots) == said)

        again = await ada.say(room, "omni move 2 m")
        await ada.until(lambda: _read(ada, room, robots) == again)


async def test_strangers_are_shown_nothing(synapse: Synapse, tmp_path: Path) -> None:
    async with (
        deciding(synapse, tmp_path) as (gateway, ada, room, robots),
        Person(synapse.create_account("eve"), tmp_path / "eve") as eve,
    ):
        gateway.settled.set()
        theirs = await eve.create_room(robots, direct=True)
        await eve.until(lambda: not eve.client.rooms[theirs].invited_users)
        await eve.say(theirs, "hello")
        await ada.until(lambda: bool(gateway.heard))
        said = await ada.say(room, "omni move 1 m")
        await ada.until(lambda: robots in ada.client.rooms[room].typing_users)
        await eve.look()
        assert not eve.client.rooms[theirs].typing_users, "and she wrote before"

        gateway.decided.set()
        await ada.until(lambda: _read(ada, room, robots) == said)
        await eve.look()
        assert _read(eve, theirs, robots) == ""
