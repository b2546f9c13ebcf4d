"""Hands over what a messenger received, in the order that the contract asks for."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from rosic.contracts.messenger import Receive
    from rosic.core.message import Chat, Inbound

WAITING: Final = 256


class ChatLanes:
    """A stop at once, each chat in order, chats side by side. Bounded.

    Whoever writes an adapter need not write this: `hand_over` is called for each message, and
    ``settled`` is called back once it may be confirmed to the platform.

    Args:
        receive: What `contracts.messenger.Messenger.run` was given. What it raises ends the tasks.
        tasks: The tasks of that run: when they are cancelled, nothing is left.
        at_most: So many messages wait, of all chats together; half as many of strangers, so that
            these take no place from people who are known.
    """

    def __init__(self, receive: Receive, tasks: asyncio.TaskGroup, at_most: int = WAITING) -> None:
        self._receive = receive
        self._tasks = tasks
        self._at_most = at_most
        self._waiting: dict[Chat, deque[tuple[Inbound, Callable[[], None]]]] = {}
        self._count = 0

    def hand_over(
        self, inbound: Inbound, settled: Callable[[], None], *, known: bool, urgent: bool = False
    ) -> bool:
        """Take one message.

        Args:
            inbound: Which.
            settled: Called when it was received to the end.
            known: Its author is known here.
            urgent: It waits for nothing; only what somebody known wrote does not.

        Returns:
            Whether it was taken; False: too many wait, and ``settled`` is never called.
        """
        if urgent and known:
            self._tasks.create_task(self._hand_over(inbound, settled))
            return True
        if self._count >= (self._at_most if known else self._at_most // 2):
            return False
        self._count += 1
        lane = self._waiting.get(inbound.chat)
        if lane is None:
            lane = self._waiting[inbound.chat] = deque()
            self._tasks.create_task(self._follow(inbound.chat, lane))
        lane.append((inbound, settled))
        return True

    async def _follow(self, chat: Chat, lane: deque[tuple[Inbound, Callable[[], None]]]) -> None:
        while lane:
            await self._hand_over(*lane.popleft())
            self._count -= 1
        del self._waiting[chat]

    async def _hand_over(self, inbound: Inbound, settled: Callable[[], None]) -> None:
        await self._receive(inbound)
        settled()
