"""Where only verified devices are followed: what moves something, what does not, and why not."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.contracts.verification import VerificationEnd
from rosic.core.message import Button, MessageValidity, Outbound
from rosic.core.policy.roles import Assurance
from rosic.messengers.matrix.messenger import MatrixMessenger, matrix_messenger
from rosic.messengers.matrix.signs import KEYS
from rosic.system import SystemClock
from rosic.testing.messenger_harness import HarnessInbox, settled
from tests.pace import pace
from tests.real.matrix.verifier import Verifier

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Mapping
    from pathlib import Path

    from rosic.contracts.verification import ShownCode, VerificationResult
    from rosic.core.message import Inbound
    from tests.real.matrix.synapse import Account, Synapse

GO = Button("Go", "omni move 1 m", "nonce-1")


class Admin:
    """Somebody beside the gateway who looks at emoji."""

    def __init__(self) -> None:
        self.codes: list[ShownCode] = []
        self.results: list[VerificationResult] = []

    def accepts(self, user: str) -> bool:
        return bool(user)

    def show(self, code: ShownCode) -> None:
        self.codes.append(code)

    def tell(self, result: VerificationResult) -> None:
        self.results.append(result)


def strict(account: Account, folder: Path) -> MatrixMessenger:
    settings = {
        "homeserver": account.url,
        "user": account.user,
        "password": account.password,
        "folder": str(folder / "robots"),
    }
    return matrix_messenger("lab", settings, SystemClock())


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(30 * pace()):
        while not condition():  # noqa: ASYNC110 - several things may make it true
            await asyncio.sleep(0.02)


class Place:
    """A messenger that follows verified devices alone, Ada at a client of hers, and an admin."""

    def __init__(self, messenger: MatrixMessenger, ada: Verifier, room: str) -> None:
        self.messenger = messenger
        self.ada = ada
        self.room = room
        self.admin = Admin()
        self.inbox = HarnessInbox()

    async def says(self, text: str, more: Mapping[str, object] | None = None) -> Inbound:
        """Let Ada write; return how it came."""
        count = len(self.inbox.done)
        content = {"msgtype": "m.text", "body": text} | dict(more or {})
        await self.ada.client.send(self.room, "m.room.message", content)
        await until(lambda: len(self.inbox.done) > count)
        return self.inbox.done[-1]

    async def taps(self, message: str) -> Inbound:
        """Let Ada put the first sign beneath a message."""
        count = len(self.inbox.done)
        link = {"rel_type": "m.annotation", "event_id": message, "key": KEYS[0]}
        await self.ada.client.send(self.room, "m.reaction", {"m.relates_to": link})
        await until(lambda: len(self.inbox.done) > count)
        return self.inbox.done[-1]

    async def verify(self) -> None:
        """Have Ada and the admin compare emoji."""
        name = await self.ada.emoji.begin(self.messenger.account, room=self.room)
        shown = await self.ada.shown()
        await until(lambda: bool(self.admin.codes))
        assert self.admin.codes[0].emoji == shown.emoji
        await self.messenger.confirm_verification(name)
        await self.ada.emoji.confirm(name)
        await until(lambda: bool(self.admin.results))
        assert self.admin.results[0].end is VerificationEnd.COMPARED


@asynccontextmanager
async def place(synapse: Synapse, folder: Path) -> AsyncIterator[Place]:
    robots = synapse.create_account("robots")
    messenger = strict(robots, folder)
    async with Verifier(synapse.create_account("ada"), folder / "ada") as ada:
        found = Place(messenger, ada, "")
        messenger.settle_with(settled)
        messenger.verify_with(found.admin)
        run = asyncio.create_task(messenger.run(found.inbox.receive))
        try:
            found.room = await met(ada, robots.user)
            yield found
        finally:
            run.cancel()
            await asyncio.wait([run])


async def test_nothing_moves_before_emoji_were_compared(synapse: Synapse, tmp_path: Path) -> None:
    async with place(synapse, tmp_path) as lab:
        unverified = await lab.says("omni move 1 m")
        assert unverified.standing is MessageValidity.UNVERIFIED
        assert "/verify" in unverified.remedy
        assert unverified.assurance is Assurance.E2EE_UNVERIFIED
        stop = await lab.says("stop")
        assert stop.standing is MessageValidity.UNVERIFIED, "nobody looked whose device it was"

        await lab.verify()

        verified = await lab.says("omni move 2 m")
        assert verified.standing is MessageValidity.FRESH
        assert verified.assurance is Assurance.E2EE_VERIFIED


async def test_a_reaction_moves_nothing_and_a_number_does(synapse: Synapse, tmp_path: Path) -> None:
    async with place(synapse, tmp_path) as lab:
        await lab.verify()
        asked = await lab.says("omni move 2 m")
        offer = Outbound(chat=asked.chat, text="Go?", buttons=((GO,),))
        message = await lab.messenger.send(offer)

        tapped = await lab.taps(message)
        replied = await lab.says("1", {"m.relates_to": {"m.in_reply_to": {"event_id": message}}})

        assert (tapped.nonce, tapped.standing) == (GO.nonce, MessageValidity.UNVERIFIED)
        assert "reply to the message with the number" in tapped.remedy
        assert (replied.nonce, replied.standing) == (GO.nonce, MessageValidity.FRESH)


async def met(ada: Verifier, user: str) -> str:
    encryption = {"type": "m.room.encryption", "content": {"algorithm": "m.megolm.v1.aes-sha2"}}
    asked = {"invite": [user], "is_direct": True, "preset": "trusted_private_chat"}
    made = await ada.client.call(
        "POST", "/_matrix/client/v3/createRoom", {**asked, "initial_state": [encryption]}
    )
    room = str(made["room_id"])
    await ada.until(
        lambda: (
            room in ada.client.rooms
            and user in ada.client.rooms[room].users
            and user not in ada.client.rooms[room].invited_users  # its keys are there by then
        )
    )
    return room
