"""People at a homeserver of Matrix: clients of matrix-nio that ask a bot and await its answer."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from time import perf_counter_ns
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from nio import (
    AsyncClient,
    AsyncClientConfig,
    ErrorResponse,
    MatrixRoom,
    RoomMessageText,
    RoomPreset,
)

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable
    from pathlib import Path

    from rosic.testing.matrix import Account

WITHIN_S: Final = 30.0
LONG_POLL_MS: Final = 30_000
ENCRYPTION: Final = {
    "type": "m.room.encryption",
    "state_key": "",
    "content": {"algorithm": "m.megolm.v1.aes-sha2"},
}


class ChatFault(Exception):
    """The homeserver refused what somebody asked for, or a bot did not answer."""


class BotText(NamedTuple):
    """What a bot said.

    Attributes:
        seen_ns: When the client had read it, decrypted.
        edit: It changes an earlier one.
    """

    seen_ns: int
    text: str
    edit: bool


class MatrixUser:
    """Somebody with a client of their own.

    Attributes:
        user: As in ``@ada:rosic.test``.
    """

    def __init__(self, account: Account, folder: Path) -> None:
        self.user = account.user
        self._password = account.password
        folder.mkdir(parents=True, exist_ok=True)
        config = AsyncClientConfig(encryption_enabled=True)
        self._client = AsyncClient(account.url, account.user, store_path=str(folder), config=config)
        self._said: dict[str, asyncio.Queue[BotText]] = {}

    async def log_in(self) -> None:
        """Log in, and publish the keys of this device, so that others share theirs with it.

        Raises:
            ChatFault: The homeserver does not take it.
        """
        await _taken(self._client.login(self._password, device_name="phone"))
        if self._client.should_upload_keys:
            await _taken(self._client.keys_upload())

    async def close(self) -> None:
        """Close its connections."""
        await self._client.close()

    async def create_room(self, *invited: str, encrypted: bool) -> str:
        """Create a room whose members alone may read it; return its identifier."""
        made = await _taken(
            self._client.room_create(
                invite=invited,
                preset=RoomPreset.private_chat,
                initial_state=[ENCRYPTION] if encrypted else [],
            )
        )
        return str(made.room_id)

    async def invite(self, room: str, user: str) -> None:
        """Invite somebody."""
        await _taken(self._client.room_invite(room, user))

    async def join(self, room: str) -> None:
        """Accept an invitation."""
        await _taken(self._client.join(room))

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[None]:
        """Sync while inside."""
        self._client.add_event_callback(self._hear, RoomMessageText)
        await _taken(self._client.sync(0, full_state=True))
        syncing = asyncio.create_task(self._client.sync_forever(LONG_POLL_MS))
        try:
            yield
        finally:
            syncing.cancel()
            await asyncio.wait([syncing])

    async def until_joined(self, room: str, user: str) -> None:
        """Wait until somebody is in a room.

        Raises:
            TimeoutError: They do not come.
        """
        async with asyncio.timeout(WITHIN_S):
            while not self._is_in(room, user):  # noqa: ASYNC110 - nio tells nobody
                await asyncio.sleep(0.05)

    def _is_in(self, room: str, user: str) -> bool:
        known = self._client.rooms.get(room)
        return known is not None and user in known.users and user not in known.invited_users

    async def ask(self, room: str, text: str, *, ends: str = "") -> int:
        """Say something; return how long it took until the bot's answer was read, in ns.

        Args:
            room: One that a bot is in, too.
            text: Said.
            ends: Wait, outside of that time, until the bot has said this, too.

        Raises:
            ChatFault: It is not answered in time.
        """
        answers = self._said[room] = asyncio.Queue()
        begun_ns = perf_counter_ns()
        await _taken(
            self._client.room_send(
                room,
                "m.room.message",
                {"msgtype": "m.text", "body": text},
                ignore_unverified_devices=True,
            )
        )
        try:
            async with asyncio.timeout(WITHIN_S):
                first = last = await answers.get()
                while ends not in last.text:
                    last = await answers.get()
        except TimeoutError:
            raise ChatFault(f"{text!r} was not answered in {WITHIN_S:.0f} s") from None
        return first.seen_ns - begun_ns

    def _hear(self, room: MatrixRoom, event: RoomMessageText) -> None:
        if event.sender == self.user:
            return
        content = event.source["content"]
        edit = "m.new_content" in content
        text = content["m.new_content"]["body"] if edit else event.body
        if (waiting := self._said.get(room.room_id)) is not None:
            waiting.put_nowait(BotText(perf_counter_ns(), text, edit))


async def _taken(asked: Awaitable[Any]) -> Any:  # noqa: ANN401 - nio has no types
    answer = await asked
    if isinstance(answer, ErrorResponse):
        raise ChatFault(str(answer))
    return answer
