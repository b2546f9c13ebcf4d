"""The sending side of the benchmark: people who take turns, each with several messages in flight.

It runs in the thread that it measures, so it does nothing that it could have done before, and keeps
no task for a message that is under way: as many as are ready are handed over one after another.
"""

from __future__ import annotations

import asyncio
from array import array
from collections import deque
from itertools import count, cycle
from time import perf_counter_ns
from typing import TYPE_CHECKING, Protocol

from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Iterator, Sequence

    from rosic.contracts.messenger import Receive
    from rosic.core.message import IncomingFile, Outbound
    from rosic.gateway.pipeline import Pipeline

TURN_MESSAGES = 4


class EndWaiter(Protocol):
    """Whoever waits for the end of an order; a future, say."""

    def set_result(self, result: None, /) -> None:
        """Hear that it is done, and was told."""

    def set_exception(self, exception: Exception, /) -> None:
        """Hear that it was refused, or ended otherwise."""


class BenchMessenger:
    """Hands messages over and notices when their author is told the end."""

    platform = "bench"
    name = "bench"
    assurance = "local"
    edits = True
    file_bytes = fetch_bytes = 0
    pins = False

    def __init__(self) -> None:
        self.ended: dict[str, EndWaiter] = {}

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

    def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Nobody sends a file."""
        raise NotImplementedError


class RobotLane:
    """The messages in flight at one robot, all of one person until that person's turn is over.

    Attributes:
        texts: What is asked for, one after another, without end.
        slots: One for each message.
        sender, chat: Whose turn it is.
    """

    __slots__ = ("_left", "chat", "sender", "slots", "texts")

    def __init__(self, width: int, texts: Iterator[str], sending: OrderSending) -> None:
        self.slots = [InFlightSlot(self, sending) for _ in range(width)]
        self.texts = texts
        self.sender, self.chat = address_of(0)
        self._left = width  # of the slots, those that have not had their share of this turn

    def begin_turn(self, sender: Address, chat: Chat) -> None:
        """Let somebody have the turn, with the whole share for each message."""
        self.sender, self.chat = sender, chat
        self._left = len(self.slots)
        for slot in self.slots:
            slot.begin_turn()

    def end_share(self) -> bool:
        """Count one message that has had its share; return whether all have."""
        self._left -= 1
        return not self._left


class InFlightSlot:
    """One message in flight after another.

    Args:
        lane: Where it is in flight.
        sending: Hears of the end.
    """

    __slots__ = ("_began_ns", "_left", "_sending", "lane")

    def __init__(self, lane: RobotLane, sending: OrderSending) -> None:
        self.lane = lane
        self._sending = sending
        self._left = 0  # of this turn, those that are still to end
        self._began_ns = 0

    def begin_turn(self) -> None:
        """Have a whole share before it."""
        self._left = TURN_MESSAGES

    def depart(self) -> None:
        """Note when it is sent."""
        self._began_ns = perf_counter_ns()

    def arrive(self) -> tuple[int, bool]:
        """Return how long it took, in ns, and whether it has had its share."""
        took_ns = perf_counter_ns() - self._began_ns
        self._left -= 1
        return took_ns, not self._left

    def set_result(self, _result: None) -> None:
        """Its author was told that the order is done."""
        self._sending.ended(self)

    def set_exception(self, exception: Exception) -> None:
        """There is no result."""
        self._sending.fail(exception)


class OrderSending:
    """Keeps messages under way until so many orders have ended.

    Args:
        pipeline: Receives them.
        messenger: Hears of the end of each.
        people: How many take turns.
        wall_ns: The place's clock.
        hands: How many messages may be handed over at the same time: more than one only where a
            hand waits for something else than its turn, as for a disk.
    """

    def __init__(
        self,
        pipeline: Pipeline,
        messenger: BenchMessenger,
        people: int,
        wall_ns: Callable[[], int],
        hands: int = 1,
    ) -> None:
        self._receive = pipeline.receive
        self._messenger = messenger
        self._hands = hands
        self._orders = self._under_way = 0
        self._people = cycle([address_of(person) for person in range(people)])
        self._numbers = count(1)
        self._wall_ns = wall_ns
        self._times = array("q")
        self._ready: deque[InFlightSlot] = deque()
        self._idle: list[asyncio.Future[None]] = []
        self._over: asyncio.Future[None] | None = None

    async def send(self, lanes: list[RobotLane], orders: int) -> tuple[list[int], float]:
        """Send until so many orders have ended, and those under way then, too.

        Args:
            lanes: Made for this sending.
            orders: So many.

        Returns:
            How long each order took, in ns, and how long all of them, in s.

        Raises:
            AssertionError: An order was not done: there is no result.
        """
        self._orders, self._times, self._under_way = orders, array("q"), len(lanes)
        self._over = asyncio.get_running_loop().create_future()
        began_ns = perf_counter_ns()
        for lane in lanes:
            self._begin(lane)
        hands = [asyncio.create_task(self._hand_over()) for _ in range(self._hands)]
        for hand in hands:
            hand.add_done_callback(self._see)
        try:
            await self._over
            return self._times.tolist(), (perf_counter_ns() - began_ns) / 1e9
        finally:
            for hand in hands:
                hand.cancel()
            await asyncio.gather(*hands, return_exceptions=True)
            self._idle.clear()

    def _see(self, hand: asyncio.Task[None]) -> None:
        """Let an error of a hand end everything."""
        if not hand.cancelled() and (error := hand.exception()) is not None:
            self.fail(error)

    def fail(self, error: BaseException) -> None:
        """End everything: there is no result."""
        if self._over is not None and not self._over.done():
            self._over.set_exception(error)

    def _begin(self, lane: RobotLane) -> None:
        """Let somebody else have the turn."""
        lane.begin_turn(*next(self._people))
        self._ready.extend(lane.slots)

    def _end_turn(self, lane: RobotLane) -> None:
        """Begin the next turn once everybody in a lane has had their share, if there is one."""
        if not lane.end_share():
            return
        if len(self._times) < self._orders:
            self._begin(lane)
            return
        self._under_way -= 1
        if not self._under_way and self._over is not None and not self._over.done():
            self._over.set_result(None)

    async def _hand_over(self) -> None:
        """Hand messages over as they are ready, one after another."""
        create_future = asyncio.get_running_loop().create_future
        receive, messenger, ends, ready = (
            self._receive,
            self._messenger,
            self._messenger.ended,
            self._ready,
        )
        numbers, wall_ns = self._numbers, self._wall_ns
        while True:
            while ready:
                slot = ready.popleft()
                lane = slot.lane
                message, now_ns = str(next(numbers)), wall_ns()
                inbound = Inbound(
                    sender=lane.sender,
                    chat=lane.chat,
                    message=message,
                    text=next(lane.texts),
                    sent_ns=now_ns,
                    received_ns=now_ns,
                )
                ends[message] = slot
                slot.depart()
                await receive(messenger, inbound)
            idle = create_future()
            self._idle.append(idle)
            await idle

    def ended(self, slot: InFlightSlot) -> None:
        """Count one order; whoever has had their share waits for the others of their lane."""
        took_ns, had_share = slot.arrive()
        self._times.append(took_ns)
        if had_share:
            self._end_turn(slot.lane)
        else:
            self._ready.append(slot)
        if self._ready and self._idle:
            self._idle.pop().set_result(None)


def lanes_of(
    in_flight: int, texts: Sequence[Iterator[str]], sending: OrderSending
) -> list[RobotLane]:
    """Share messages out among robots, each asked for what its texts say."""
    share, more = divmod(in_flight, len(texts))
    return [RobotLane(share + (robot < more), asked, sending) for robot, asked in enumerate(texts)]


def address_of(person: int) -> tuple[Address, Chat]:
    """Return who writes, and where."""
    return Address("bench", str(person)), Chat("bench", str(person))
