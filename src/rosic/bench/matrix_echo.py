"""A bare bot of matrix-nio in a process of its own: it says again whatever is said.

Arguments: the homeserver, the account, its password, a folder for its keys. It joins whatever room
it is invited to, and prints ``ready`` once it listens.
"""

from __future__ import annotations

import asyncio
import logging
import sys
from typing import Final

from nio import (
    AsyncClient,
    AsyncClientConfig,
    InviteMemberEvent,
    LoginError,
    MatrixRoom,
    RoomMessageText,
    SyncResponse,
)

LONG_POLL_MS: Final = 30_000


async def run(url: str, user: str, password: str, folder: str) -> None:
    """Log in, and answer until the process ends.

    Raises:
        RuntimeError: The homeserver lets nobody in.
    """
    told = False
    config = AsyncClientConfig(encryption_enabled=True)
    client = AsyncClient(url, user, store_path=folder, config=config)
    answer = await client.login(password, device_name="echo")
    if isinstance(answer, LoginError):
        raise RuntimeError(str(answer))  # noqa: TRY004 - it is an answer

    async def join(room: MatrixRoom, _event: InviteMemberEvent) -> None:
        await client.join(room.room_id)

    async def say_again(room: MatrixRoom, event: RoomMessageText) -> None:
        if event.sender != client.user_id:
            said = {"msgtype": "m.text", "body": event.body}
            await client.room_send(
                room.room_id, "m.room.message", said, ignore_unverified_devices=True
            )

    async def tell_once(_response: SyncResponse) -> None:
        nonlocal told
        if not told:
            told = True
            print("ready", flush=True)

    client.add_event_callback(join, InviteMemberEvent)
    client.add_event_callback(say_again, RoomMessageText)
    client.add_response_callback(tell_once, SyncResponse)
    await client.sync_forever(LONG_POLL_MS, full_state=True)


if __name__ == "__main__":
    logging.disable(logging.ERROR)  # nio tells of keys that come later; nobody reads it here
    asyncio.run(run(*sys.argv[1:]))
