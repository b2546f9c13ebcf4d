"""A bare client of rosbridge: what it says and what it is told, message by message."""

from __future__ import annotations

import asyncio
import json
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from websockets.asyncio.client import ClientConnection

    from tests.api.served import ServedGateway


class BridgeClient:
    """One connection.

    Attributes:
        socket: The WebSocket itself.
        told: Everything that was told, oldest first.
    """

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket
        self.told: list[dict[str, Any]] = []

    async def say(self, op: str, **fields: Any) -> None:  # noqa: ANN401 - JSON
        await self.socket.send(json.dumps({"op": op, **fields}))

    async def until(self, wanted: Callable[[dict[str, Any]], object]) -> dict[str, Any]:
        """Return the first message from now on that is wanted."""
        async with asyncio.timeout(30 * pace()):
            while True:
                message: dict[str, Any] = json.loads(await self.socket.recv())
                self.told.append(message)
                if wanted(message):
                    return message

    async def status(self, level: str = "error") -> str:
        """Return the sentence of the next status of a level."""
        found = await self.until(lambda m: m["op"] == "status" and m["level"] == level)
        return str(found["msg"])

    async def op(self, op: str) -> dict[str, Any]:
        return await self.until(lambda m: m["op"] == op)


@asynccontextmanager
async def bridge(
    place: ServedGateway, key: str = "", path: str = "/rosbridge", **besides: str
) -> AsyncIterator[BridgeClient]:
    """Yield a client, with a key if there is one."""
    headers = {"Authorization": f"Bearer {key}"} if key else {}
    url = place.url.replace("http", "ws", 1) + path
    async with connect(url, additional_headers=headers | besides, compression=None) as socket:
        yield BridgeClient(socket)


def later(monkeypatch: pytest.MonkeyPatch, seconds: float) -> None:
    """Let so much time pass on the event loop at once; robots do not hear of it."""
    loop = asyncio.get_running_loop()
    now_s = loop.time
    monkeypatch.setattr(loop, "time", lambda: now_s() + seconds)


async def closed(client: BridgeClient) -> tuple[int, str]:
    """Return the code and the reason with which a connection was closed."""
    with pytest.raises(ConnectionClosed) as error:
        await client.until(lambda _: False)
    assert error.value.rcvd is not None
    return error.value.rcvd.code, error.value.rcvd.reason
