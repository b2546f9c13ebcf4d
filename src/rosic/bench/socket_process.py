"""The clients of `rosic bench api`, in a process of their own; and a bare echo to compare with.

They speak the protocol of rosbridge, with a WebSocket library and nothing else. Started by
`rosic.bench.api`; ``echo`` as its argument makes it the echo. Takes commands as lines:

    open JSON           connect: where, how many, and how many of them take nothing
    hello               publish what does not count
    publish SIZE RATE SECONDS COUNT    publish by all clients in turn, and say how many
    clear, report COUNT as the other side has them; of the first client
    close
"""

from __future__ import annotations

import asyncio
import contextlib
import re
import sys
import time
from typing import TYPE_CHECKING, Final

import msgspec
from websockets.asyncio.client import connect
from websockets.asyncio.server import serve

from rosic.bench.topic_process import (
    AT_MOST_S,
    HELLO,
    QUIET_S,
    TYPE,
    MessageTimes,
    Pace,
    content,
    pace_of,
    tell,
)

if TYPE_CHECKING:
    from websockets.asyncio.client import ClientConnection
    from websockets.asyncio.server import ServerConnection

    from rosic.bench.topic_process import StreamFigures

FRAME_BYTES: Final = 1 << 22
_HEAD: Final = re.compile(r'"data": ?"(-?\d+ \d+) ')
DONE_WITHIN_S: Final = 30.0


class ClientsWanted(msgspec.Struct, frozen=True, kw_only=True):
    """Which clients connect.

    Attributes:
        headers: That each of them shows.
        clients: How many; the first of them is looked at.
        stalled: How many more that take nothing of what they are sent.
        subscribes, publishes: Topics; empty: to none.
    """

    url: str
    headers: dict[str, str] = {}
    clients: int = 1
    stalled: int = 0
    subscribes: str = ""
    publishes: str = ""


class BenchClients:
    """Clients of one server."""

    def __init__(self) -> None:
        self.arrivals = MessageTimes()
        self._sockets: list[ClientConnection] = []
        self._reading: list[asyncio.Task[None]] = []
        self._wanted = ClientsWanted(url="")

    async def open(self, wanted: ClientsWanted) -> None:
        """Connect them, and say what they are for."""
        self._wanted = wanted
        for number in range(wanted.clients + wanted.stalled):
            socket = await connect(
                wanted.url,
                additional_headers=wanted.headers,
                compression=None,
                max_size=FRAME_BYTES,
                max_queue=None if number < wanted.clients else 1,
                ping_interval=None,
            )
            self._sockets.append(socket)
            if wanted.publishes:
                await self._say(socket, "advertise", topic=wanted.publishes, type=TYPE)
            if wanted.subscribes:
                await self._say(socket, "subscribe", topic=wanted.subscribes, type=TYPE)
            if number < wanted.clients:
                read = self._measured(socket) if number == 0 else self._drained(socket)
                self._reading.append(asyncio.create_task(read))
            else:
                socket.transport.pause_reading()

    @staticmethod
    async def _say(socket: ClientConnection, op: str, **fields: str) -> None:
        await socket.send(msgspec.json.encode({"op": op, **fields}).decode())

    async def _measured(self, socket: ClientConnection) -> None:
        async for told in socket:
            found = _HEAD.search(told[:200]) if isinstance(told, str) else None
            if found is not None:
                self.arrivals.note(found[1])

    @staticmethod
    async def _drained(socket: ClientConnection) -> None:
        async for _ in socket:
            pass

    async def publish(self, pace: Pace) -> int:
        """Publish at a pace, each client in its turn. Return how many."""
        sockets, topic = self._sockets[: self._wanted.clients], self._wanted.publishes
        begun_s = time.monotonic()
        for number in range(pace.most):
            due_s = begun_s + pace.due_s(number)
            if due_s > begun_s + pace.seconds or time.monotonic() > begun_s + pace.seconds:
                return number
            if (left_s := due_s - time.monotonic()) > 0:
                await asyncio.sleep(left_s)
            text = content(number, pace.size)
            if topic:
                text = f'{{"op":"publish","topic":"{topic}","msg":{{"data":"{text}"}}}}'
            else:
                text = f'{{"data":"{text}"}}'
            await sockets[number % len(sockets)].send(text)
            if number % 64 == 0:
                await asyncio.sleep(0)  # what comes back has its turn
        return pace.most

    async def hello(self) -> None:
        """Publish what does not count."""
        message = {"data": content(HELLO, 64)}
        told = {"op": "publish", "topic": self._wanted.publishes, "msg": message}
        await self._sockets[0].send(msgspec.json.encode(told).decode())

    async def report(self, count: int) -> StreamFigures:
        """Wait until so many came to the first client, or nothing comes any more."""
        end_s, seen, since_s = time.monotonic() + AT_MOST_S, -1, time.monotonic()
        while len(self.arrivals) < count and time.monotonic() < end_s:
            await asyncio.sleep(0.02)
            if len(self.arrivals) != seen:
                seen, since_s = len(self.arrivals), time.monotonic()
            elif time.monotonic() - since_s > QUIET_S:
                break
        return self.arrivals.figures()

    async def close(self) -> None:
        """Leave; without a word where nothing is taken."""
        for reading in self._reading:
            reading.cancel()
        await asyncio.gather(*self._reading, return_exceptions=True)
        for number, socket in enumerate(self._sockets):
            if number < self._wanted.clients:
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(1.0):
                        await socket.close()
            socket.transport.abort()
        self._sockets, self._reading = [], []


async def _echo() -> None:
    async def back(socket: ServerConnection) -> None:
        async for told in socket:
            await socket.send(told)

    async with serve(back, "127.0.0.1", 0, compression=None, max_size=FRAME_BYTES) as server:
        port = next(iter(server.sockets)).getsockname()[1]
        tell(f"ready {port}")
        while await asyncio.to_thread(sys.stdin.readline):
            pass


async def _clients() -> None:
    clients = BenchClients()
    tell("ready")
    while line := await asyncio.to_thread(sys.stdin.readline):
        word, _, rest = line.strip().partition(" ")
        if word == "publish":
            tell("published", await clients.publish(pace_of(rest.split())))
        elif word == "report":
            tell("seen", await clients.report(int(rest)))
        else:
            await _at_once(clients, word, rest)


async def _at_once(clients: BenchClients, word: str, rest: str) -> None:
    if word == "open":
        await clients.open(msgspec.json.decode(rest, type=ClientsWanted))
        tell("opened")
    elif word == "hello":
        await clients.hello()
    elif word == "clear":
        clients.arrivals.clear()
        tell("cleared")
    elif word == "heard":
        tell("heard", clients.arrivals.said_hello)
    elif word == "close":
        await clients.close()
        tell("closed")


def main() -> None:
    """Be clients, or the echo."""
    asyncio.run(_echo() if sys.argv[1:] == ["echo"] else _clients())


if __name__ == "__main__":
    main()
