"""One chat's messages pass in order, others do not wait for them, and the queue is bounded."""

from __future__ import annotations

import asyncio

import pytest

from rosic.core.message import Chat
from rosic.errors import TooManyRequests
from rosic.gateway.chat_locks import WAITING_AT_MOST, ChatLocks
from rosic.testing.clock import settle
from tests.pace import pace

A, B = Chat("t", "a"), Chat("t", "b")


async def test_messages_of_a_chat_keep_their_order() -> None:
    turns, passed = ChatLocks(), list[int]()
    release = asyncio.Event()

    async def message(number: int) -> None:
        await turns.take(A)
        if number == 0:
            await release.wait()
        passed.append(number)
        turns.give(A)

    tasks = [asyncio.create_task(message(number)) for number in range(5)]
    await settle()
    assert passed == []
    release.set()
    await asyncio.gather(*tasks)
    assert passed == [0, 1, 2, 3, 4]


async def test_another_chat_does_not_wait() -> None:
    turns = ChatLocks()
    await turns.take(A)
    await asyncio.wait_for(turns.take(B), 60 * pace())


async def test_a_cancelled_message_passes_its_turn_on() -> None:
    turns = ChatLocks()
    await turns.take(A)
    first = asyncio.create_task(turns.take(A))
    second = asyncio.create_task(turns.take(A))
    await settle()
    turns.give(A)
    first.cancel()
    await asyncio.wait_for(second, 60 * pace())


async def test_too_many_waiting_are_refused() -> None:
    turns = ChatLocks()
    await turns.take(A)
    waiting = [asyncio.create_task(turns.take(A)) for _ in range(WAITING_AT_MOST)]
    await settle()
    with pytest.raises(TooManyRequests):
        await turns.take(A)
    for task in waiting:
        task.cancel()
    await asyncio.gather(*waiting, return_exceptions=True)


async def test_nothing_is_kept_of_a_chat_that_is_quiet() -> None:
    turns = ChatLocks()
    await turns.take(A)
    turns.give(A)
    assert not turns._chats
