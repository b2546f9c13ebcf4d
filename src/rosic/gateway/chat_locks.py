"""One chat's messages in order: a queue of one per chat, free while nobody waits."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.errors import TooManyRequests

if TYPE_CHECKING:
    from rosic.core.message import Chat

WAITING_AT_MOST = 256


class ChatLocks:
    """A queue of one per chat that costs nothing while nobody waits.

    ``asyncio.Lock`` per chat would do the same, but would have to be created, kept and thrown
    away for every chat.
    """

    def __init__(self) -> None:
        # None: somebody has the turn, and nobody waits for it.
        self._chats: dict[tuple[str, str], deque[asyncio.Future[None]] | None] = {}

    def try_acquire(self, chat: Chat) -> bool:
        """Take the chat's turn if nobody has it; ``give`` must follow."""
        where = (chat.platform, chat.id)
        if where in self._chats:
            return False
        self._chats[where] = None
        return True

    async def take(self, chat: Chat) -> None:
        """Wait for the chat's turn; ``give`` must follow.

        Raises:
            TooManyRequests: Too many messages of this chat wait already (I15); no ``give`` is due.
        """
        if self.try_acquire(chat):
            return
        where = (chat.platform, chat.id)
        waiting = self._chats[where]
        if waiting is None:
            waiting = self._chats[where] = deque()
        if len(waiting) >= WAITING_AT_MOST:
            raise TooManyRequests(
                said("Too many messages at once. Wait a moment."), retry_after_s=5.0
            )
        future: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        waiting.append(future)
        try:
            await future
        except asyncio.CancelledError:
            if future.done() and not future.cancelled():
                self.give(chat)
            raise

    def give(self, chat: Chat) -> None:
        """Give the turn to the next message of the chat."""
        where = (chat.platform, chat.id)
        waiting = self._chats[where]
        while waiting:
            future = waiting.popleft()
            if not future.done():
                future.set_result(None)
                return
        del self._chats[where]
