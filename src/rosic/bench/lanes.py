"""The sending side of the benchmark: people who take turns, each with several messages in flight.

It runs in the thread that it measures, so it does nothing that it could have done before.
"""

from __future__ import annotations

import asyncio
from itertools import count, cycle
from time import perf_counter_ns
from typing import TYPE_CHECKING

from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator, Sequence

    from rosic.contracts.messenger import Receive
    from rosic.core.message import Enclosure, Outbound
    from rosic.pipeline.way import Pipeline

TURN_MESSAGES = 4


class BenchMessenger:
    """Hands messages over and notices when their author is told the end."""

    platform = "bench"
    name = "bench"
    assurance = "local"
    edits = True
    file_bytes = fetch_bytes = 0
    pins = False

    def __init__(self) -> None:
        self.ended: dict[str, asyncio.Future[None]] = {}

    async def run(self, receive: Receive) -> None:
        """Nothing to listen to: the load calls ``receive`` itself."""

    async def send(self, outbound: Outbound) -> str:
        """Take the first message of a life; its id is that of the message it answers."""
        if "\n" not in outbound.text:
            self._fail(outbound.reply_to, outbound)
        return outbound.reply_to

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Take an edit; the one that says done ends the wait."""
        if "\ndone " in outbound.text:
            ended = self.ended.pop(message, None)
            if ended is not None:
                ended.set_result(None)
        elif not outbound.buttons:
            self._fail(message, outbound)

    def _fail(self, message: str, outbound: Outbound) -> None:
        """Let whoever waits for an order know that it was refused, or ended otherwise."""
        ended = self.ended.pop(message, None)
        if ended is not None:
            ended.set_exception(AssertionError(f"no result, as one was not done: {outbound.text}"))

    async def pin(self, chat: Chat, message: str, *, pinned: bool = True) -> None:
        """Nobody looks."""

    async def answer_tap(self, inbound: Inbound, text: str) -> None:
        """Nobody taps."""

    def fetch(self, enclosure: Enclosure) -> AsyncIterator[bytes]:
        """Nobody sends a file."""
        raise NotImplementedError


class Lane:
    """The messages in flight at one robot, all of one person until that person's turn is over.

    Attributes:
        texts: What is asked for, one after another, without end.
        left: How many of them have not had their share of this turn.
        over: Done when the turn is; it says whether there is another.
    """

    __slots__ = ("left", "over", "person", "texts", "width")

    def __init__(self, width: int, texts: Iterator[str]) -> None:
        self.width = self.left = width
        self.texts = texts
        self.person: tuple[Address, Chat] | None = None
        self.over: asyncio.Future[bool] | None = None


class Sending:
    """Keeps messages under way until so many orders have ended.

    Args:
        pipeline: Receives them.
        messenger: Hears of the end of each.
        people: How many take turns.
        wall_ns: The place's clock.
    """

    def __init__(
        self,
        pipeline: Pipeline,
        messenger: BenchMessenger,
        people: int,
        wall_ns: Callable[[], int],
    ) -> None:
        self._receive = pipeline.receive
        self._messenger = messenger
        self._orders = 0
        self._people = cycle([address_of(person) for person in range(people)])
        self._numbers = count(1)
        self._wall_ns = wall_ns
        self._times: list[int] = []

    async def send(self, lanes: list[Lane], orders: int) -> tuple[list[int], float]:
        """Send until so many orders have ended, and those under way then, too.

        Returns:
            How long each order took, in ns, and how long all of them, in s.
        """
        self._orders, self._times = orders, []
        for lane in lanes:
            self._begin(lane)
        began_ns = perf_counter_ns()
        await asyncio.gather(*(self._slot(lane) for lane in lanes for _ in range(lane.width)))
        return self._times, (perf_counter_ns() - began_ns) / 1e9

    def _begin(self, lane: Lane) -> None:
        lane.left, lane.person = lane.width, next(self._people)
        lane.over = asyncio.get_running_loop().create_future()

    async def _slot(self, lane: Lane) -> None:
        """Send one message after another, each once the one before has ended."""
        future = asyncio.get_running_loop().create_future
        receive, messenger, ends = self._receive, self._messenger, self._messenger.ended
        numbers, texts, wall_ns, times = self._numbers, lane.texts, self._wall_ns, self._times
        while True:
            assert lane.person is not None  # noqa: S101 - a turn has begun
            sender, chat = lane.person
            for _ in range(TURN_MESSAGES):
                message, now_ns = str(next(numbers)), wall_ns()
                inbound = Inbound(
                    sender=sender, chat=chat, message=message, text=next(texts),
                    sent_ns=now_ns, received_ns=now_ns,
                )  # fmt: skip
                ends[message] = ended = future()
                began_ns = perf_counter_ns()
                await receive(messenger, inbound)
                await ended
                times.append(perf_counter_ns() - began_ns)
            if not await self._turn_is_over(lane):
                return

    async def _turn_is_over(self, lane: Lane) -> bool:
        """Wait until everybody in a lane has had their share; the last begins the next turn.

        Returns:
            Whether there is one.
        """
        over = lane.over
        assert over is not None  # noqa: S101 - a turn has begun
        lane.left -= 1
        if lane.left:
            return await over
        more = len(self._times) < self._orders
        self._begin(lane)
        over.set_result(more)
        return more


def lanes_of(in_flight: int, texts: Sequence[Iterator[str]]) -> list[Lane]:
    """Share messages out among robots, each asked for what its texts say."""
    share, more = divmod(in_flight, len(texts))
    return [Lane(share + (robot < more), asked) for robot, asked in enumerate(texts)]


def address_of(person: int) -> tuple[Address, Chat]:
    """Return who writes, and where."""
    return Address("bench", str(person)), Chat("bench", str(person))
