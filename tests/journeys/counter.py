"""The other end of `CountingRobot`: counts what robots were really told, and outlives gateways."""

from __future__ import annotations

import asyncio
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Self

import msgspec

from tests.journeys.counting import Answer, Event

if TYPE_CHECKING:
    from random import Random
    from types import TracebackType


class Counted(msgspec.Struct, frozen=True):
    """An event and the wall clock at which it arrived."""

    event: Event
    at_s: float


class Counter:
    """A server in the test's own process. It appends first and answers after a short while.

    Args:
        chance: Decides how long an answer and the work take, and how it ends.
        failing: Share of orders that the robot says it failed.
        silent: Share of orders that are never answered.
        work_s: Longest time that an order takes, if nobody changes it.

    Attributes:
        events: Everything, in order of arrival.
    """

    def __init__(
        self,
        chance: Random,
        *,
        failing: float = 0.0,
        silent: float = 0.0,
        work_s: float = 0.05,
    ) -> None:
        self.events: list[Counted] = []
        self.port = 0
        self.work_s = work_s
        self._chance = chance
        self._failing = failing
        self._silent = silent
        self._more = asyncio.Event()
        self._tasks: set[asyncio.Task[None]] = set()
        self._writers: set[asyncio.StreamWriter] = set()
        self._server: asyncio.Server | None = None

    async def __aenter__(self) -> Self:
        self._server = await asyncio.start_server(self._serve, "127.0.0.1", 0)
        self.port = self._server.sockets[0].getsockname()[1]
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        assert self._server is not None
        self._server.close()
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        for writer in tuple(self._writers):
            writer.close()
        await self._server.wait_closed()

    @property
    def actuations(self) -> list[Event]:
        """Every order that reached a robot, in order."""
        return [counted.event for counted in self.events if counted.event.cid]

    def stops(self, robot: str) -> list[Counted]:
        """Every stop that reached a robot, in order."""
        return [c for c in self.events if not c.event.cid and c.event.robot == robot]

    async def wait_for(self, count: int, within_s: float) -> bool:
        """Wait until so many orders have acted in all. Return whether they have, in time."""
        with suppress(TimeoutError):
            async with asyncio.timeout(within_s):
                while len(self.actuations) < count:
                    await self._more.wait()
        return len(self.actuations) >= count

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._writers.add(writer)
        try:
            with suppress(ConnectionError):
                while line := await reader.readline():
                    if line.endswith(b"\n"):  # half a line was never a whole order
                        self._take(msgspec.json.decode(line, type=Event), writer)
        finally:
            self._writers.discard(writer)
            writer.close()

    def _take(self, event: Event, writer: asyncio.StreamWriter) -> None:
        self.events.append(Counted(event, time.time()))
        self._more.set()
        self._more = asyncio.Event()
        if event.cid and self._chance.random() >= self._silent:
            answering = asyncio.create_task(self._answer(event, writer))
            self._tasks.add(answering)
            answering.add_done_callback(self._tasks.discard)

    async def _answer(self, event: Event, writer: asyncio.StreamWriter) -> None:
        await asyncio.sleep(self._chance.uniform(0, 0.01))
        work_s = self._chance.uniform(0, self.work_s)
        ending = "failed" if self._chance.random() < self._failing else "done"
        if not writer.is_closing():
            answer = Answer(cid=event.cid, work_s=work_s, ending=ending)
            writer.write(msgspec.json.encode(answer) + b"\n")
