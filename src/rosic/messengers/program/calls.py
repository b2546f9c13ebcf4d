"""What programs have said and not been answered yet: by the id of the message that said it."""

from __future__ import annotations

import asyncio
from collections import OrderedDict, deque
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.message import AnswerState

if TYPE_CHECKING:
    from rosic.core.identity import Address
    from rosic.core.message import Outbound

NEWS_AT_MOST: Final = 64
"""Of one call, while nobody takes it: the oldest, which only tells how things go, gives way."""


class Answer(NamedTuple):
    """What became of a call.

    Attributes:
        good: It is done, or answered.
        besides: What was said to the program meanwhile that answers no call: an alarm, what a
            robot says.
    """

    text: str
    good: bool = True
    besides: tuple[str, ...] = ()


class News(NamedTuple):
    """Something that was said because of a call, and the id of the message that says it."""

    message: str
    outbound: Outbound


class ToolCall:
    """One line that a program has said, and what is said to it since.

    Attributes:
        address: Which program.
        robot: Whose order it is; empty for what orders nothing.
        asked: Somebody else is asked, and has not answered.
        last: What was said last.
    """

    def __init__(self, address: Address, robot: str = "") -> None:
        self.address = address
        self.robot = robot
        self.asked = False
        self.last = ""
        self._news: asyncio.Queue[News] = asyncio.Queue()

    def told(self, message: str, outbound: Outbound) -> None:
        """Take in what is said because of it."""
        while self._news.qsize() >= NEWS_AT_MOST:
            self._news.get_nowait()
        self._news.put_nowait(News(message, outbound))

    async def news(self) -> News:
        """Return what was said next, waiting for it."""
        news = await self._news.get()
        self.asked = news.outbound.state is AnswerState.ASKED
        self.last = news.outbound.text
        return news


BESIDES_AT_MOST: Final = 20
PROGRAMS_AT_MOST: Final = 1_000


class UnsolicitedMessages:
    """What was said to programs and answers no call, until their next answer: the newest of it."""

    def __init__(self) -> None:
        self._texts: OrderedDict[str, deque[str]] = OrderedDict()

    def put(self, account: str, text: str) -> None:
        """Keep something for a program."""
        self._texts.setdefault(account, deque(maxlen=BESIDES_AT_MOST)).append(text)
        if len(self._texts) > PROGRAMS_AT_MOST:
            self._texts.popitem(last=False)

    def take(self, account: str) -> tuple[str, ...]:
        """Return what was kept for a program; it is kept no longer."""
        return tuple(self._texts.pop(account, ()))


class OpenCalls:
    """The calls under way, and how many each program has."""

    def __init__(self) -> None:
        self._calls: dict[str, ToolCall] = {}
        self._of: dict[Address, int] = {}

    def __getitem__(self, cause: str) -> ToolCall | None:
        return self._calls.get(cause)

    def count(self, address: Address) -> int:
        """Return how many messages of a program wait for an answer."""
        return self._of.get(address, 0)

    def open(self, message: str, call: ToolCall) -> None:
        """Have what is said because of a message told to a call."""
        self._calls[message] = call
        self._of[call.address] = self.count(call.address) + 1

    def close(self, call: ToolCall) -> None:
        """Tell a call nothing more."""
        for message in [m for m, one in self._calls.items() if one is call]:
            del self._calls[message]
            self._of[call.address] -= 1
        if not self.count(call.address):
            self._of.pop(call.address, None)
