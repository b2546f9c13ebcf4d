"""A client that takes nothing: how much is kept for it, and what it is told."""

from __future__ import annotations

import asyncio
import json
import tracemalloc
from typing import TYPE_CHECKING, Any

import pytest
from websockets.exceptions import ConnectionClosed

from rosic.api.event_schemas import Pong
from rosic.gateway.send_queue import MESSAGES_AT_MOST, SLOW, TOO_SLOW
from tests.api.served import served
from tests.pace import pace

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection

LARGE = 65_536
TOPICS = 8
FLOOD = 1_000
GROWS_BY_AT_MOST = (TOPICS + 4) * LARGE + (1 << 20)
"""One message of each topic, the one that is on its way in its forms, and a little of all else."""
ON_ITS_WAY_AT_MOST = 150
"""Messages of a flood of which some MB may have been taken by the two systems."""


async def ids(connection: ClientConnection, until: set[str]) -> list[str]:
    """Return the ids of what is told, until these were."""
    told: list[str] = []
    async with asyncio.timeout(60 * pace()):
        while not until <= set(told):
            event: dict[str, Any] = json.loads(await connection.recv())
            told.append(str(event.get("id")).strip())
    return told


async def everything(connection: ClientConnection) -> None:
    async with asyncio.timeout(60 * pace()):
        while True:
            await connection.recv()


async def test_a_flood_to_a_client_that_takes_nothing_is_kept_in_few_bytes_and_never_old() -> None:
    async with served() as place:
        ada = await place.person("Ada")
        async with place.listening(ada) as connection:
            await connection.recv()
            [listener] = place.server.stream.listeners
            connection.transport.pause_reading()
            tracemalloc.start()
            before, _ = tracemalloc.get_traced_memory()
            for number in range(FLOOD):
                listener.put(f"topic {number % TOPICS}", Pong(str(number).ljust(LARGE)))
                await asyncio.sleep(0)
            _, most = tracemalloc.get_traced_memory()
            tracemalloc.stop()
            assert most - before <= GROWS_BY_AT_MOST
            assert listener.queue.messages <= TOPICS
            assert listener.queue.waiting_bytes <= TOPICS * (LARGE + 100)
            connection.transport.resume_reading()
            last = {str(number) for number in range(FLOOD - TOPICS, FLOOD)}
            told = await ids(connection, last)
        # What comes before them was on its way when nothing was taken any more.
        assert len(told) - TOPICS < ON_ITS_WAY_AT_MOST


async def test_a_slow_client_is_told_why_when_it_takes_again_and_others_lose_nothing() -> None:
    async with served() as place:
        ada, bo = await place.person("Ada"), await place.person("Bo")
        async with place.listening(ada) as stalled, place.listening(bo) as other:
            await stalled.recv()
            await other.recv()
            first, second = place.server.stream.listeners
            slow, quick = (first, second) if first.caller.name == "Ada" else (second, first)
            stalled.transport.pause_reading()
            for number in range(400):  # until nothing goes on any more
                slow.put("topic", Pong(str(number).ljust(LARGE)))
                await asyncio.sleep(0)
            for number in range(MESSAGES_AT_MOST + 1):
                slow.put(f"pong {number}", Pong(str(number)))
                if number % 100 == 0:
                    quick.put(f"pong {number}", Pong(str(number)))
            assert slow.queue.overflowed
            assert slow.queue.waiting_bytes == 0
            await ids(other, {str(number) for number in range(0, MESSAGES_AT_MOST, 100)})
            stalled.transport.resume_reading()
            with pytest.raises(ConnectionClosed) as closed:
                await everything(stalled)
            assert closed.value.rcvd is not None
            assert (closed.value.rcvd.code, closed.value.rcvd.reason) == (SLOW, TOO_SLOW)
