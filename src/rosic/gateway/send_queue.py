"""What one client is yet to be told: bounded in messages and in bytes, and never old.

One for everybody who is told what happens, each over a connection of their own:

- What is *said* counts in itself, as an answer does: all of it is told, in order, before the rest.
- What is *shown* stands under a key, as a topic does, and of each key the newest counts. Each key
  gives one message in its turn, so that none waits behind another.
- A client that takes what it is sent is told all of a burst. One that does not is shown the newest
  alone: once a message has waited for `FRESH_S`, the older ones of each key give way to the newest.
- Who lets more wait than is kept even so, or takes longer than `TAKEN_WITHIN_S` for one message, is
  slow: it is told `TOO_SLOW`, and dropped. Nobody else waits for it.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections import OrderedDict, deque
from operator import attrgetter
from time import monotonic
from typing import TYPE_CHECKING, Final, Generic, NamedTuple, TypeVar

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Hashable

MESSAGES_AT_MOST: Final = 4_096
"""That are said, or the newest under their key."""
BYTES_AT_MOST: Final = 32 << 20
"""Of those."""
OLDER_BYTES_AT_MOST: Final = 4 << 20
"""Of what waits besides: messages that there is a newer one of. The key with most gives way."""
FRESH_S: Final = 0.25
TAKEN_WITHIN_S: Final = 5.0
SLOW: Final = 1013
"""The code with which a WebSocket of a slow client is closed: try again later."""
TOO_SLOW: Final = (
    "You take too little of what you are sent, so you are told nothing more. Come again."
)

Content = TypeVar("Content")


class SlowConsumer(Exception):
    """A client takes too little of what it is sent. ``str()`` is what it is told."""

    def __init__(self) -> None:
        super().__init__(TOO_SLOW)


class Pacing(NamedTuple):
    """How what is shown under a key is told.

    Attributes:
        every_s: At most so often.
        keep: So many wait in any case, however old they become.
        burst: So many wait as long as the client takes what it is sent.
    """

    every_s: float = 0.0
    keep: int = 1
    burst: int = 1


class _Waiting(NamedTuple, Generic[Content]):
    content: Content
    size: int
    since_s: float


class _Key(Generic[Content]):
    """What waits under one key."""

    __slots__ = ("due_s", "older_bytes", "pacing", "waiting")

    def __init__(self) -> None:
        self.older_bytes = 0
        self.pacing = Pacing()
        self.waiting: deque[_Waiting[Content]] = deque()
        self.due_s = 0.0


class SendQueue(Generic[Content]):
    """What one client is yet to be told; see the module.

    Args:
        now_s: Tells the time, on a clock that only goes on.

    Attributes:
        news: Set whenever there is something to look at.
        replaced: How many messages gave way to newer ones.
        overflowed: More waits than is kept. From then on nothing is taken in, and nothing is kept.
    """

    def __init__(self, now_s: Callable[[], float] = monotonic) -> None:
        self.news = asyncio.Event()
        self.replaced = 0
        self.overflowed = False
        self._now_s = now_s
        self._said: deque[_Waiting[Content]] = deque()
        self._keys: dict[Hashable, _Key[Content]] = {}
        self._turns: OrderedDict[Hashable, _Key[Content]] = OrderedDict()
        self._bytes = self._older_bytes = self._messages = 0
        self._behind = False
        self._sending_s: float | None = None

    @property
    def messages(self) -> int:
        """How many wait."""
        return len(self._said) + sum(len(key.waiting) for key in self._turns.values())

    @property
    def waiting_bytes(self) -> int:
        """How many bytes wait."""
        return self._bytes + self._older_bytes

    # ---- what is to be told ----

    def say(self, content: Content, size: int) -> None:
        """Have it told, in order, before all that is shown."""
        if self._takes_in(size):
            self._said.append(_Waiting(content, size, self._now_s()))

    def show(
        self,
        name: Hashable,
        content: Content,
        size: int,
        pacing: Pacing = Pacing(),  # noqa: B008
    ) -> None:
        """Have it told in the turn of its key, in place of what is older there."""
        key = self._keys.get(name)
        if key is None:
            key = self._keys[name] = _Key()
        key.pacing = pacing
        if key.waiting:
            newest = key.waiting[-1]
            self._told(newest)
            self._count_older(key, newest.size)
        if not self._takes_in(size):
            return
        key.waiting.append(_Waiting(content, size, self._now_s()))
        self._make_room(key)
        self._turns.setdefault(name, key)

    def forget(self, name: Hashable) -> None:
        """Tell nothing more of a key."""
        key = self._keys.pop(name, None)
        if key is not None and self._turns.pop(name, None) is not None:
            while len(key.waiting) > 1:
                self._drop_oldest(key)
            self._told(key.waiting.pop())

    # ---- what is told ----

    async def tell(self, send: Callable[[Content], Awaitable[None]]) -> None:
        """Send what is to be told, one after the other, for ever.

        Args:
            send: Returns when the client has taken it; whatever it raises ends this.

        Raises:
            SlowConsumer: The client takes too little.
        """
        while True:
            content = await self.next()
            self._sending_s = self._now_s()
            await sent_in_time(send, content)
            self._sending_s = None

    async def next(self) -> Content:
        """Return what is told next, waiting for it.

        Raises:
            SlowConsumer: More waits than is kept.
        """
        while True:
            if self.overflowed:
                raise SlowConsumer
            if self._said:
                return self._told(self._said.popleft())
            due_s = self._next_turn()
            self.news.clear()
            wait_s = None if due_s is None else due_s - self._now_s()
            if wait_s is not None and wait_s <= 0:
                return self._taken()
            self._behind = False
            await _wait(self.news, wait_s)

    def take_all(self) -> list[Content]:
        """Return all that waits, and is due, at once.

        Raises:
            SlowConsumer: More waits than is kept.
        """
        if self.overflowed:
            raise SlowConsumer
        found = [self._told(self._said.popleft()) for _ in range(len(self._said))]
        while (due_s := self._next_turn()) is not None and due_s <= self._now_s():
            found.append(self._taken())
        return found

    def _next_turn(self) -> float | None:
        """Bring the key whose turn is next to the front. Return when it is due; None: none is."""
        soonest: tuple[float, Hashable] | None = None
        now_s = self._now_s()
        for name, key in self._turns.items():
            if soonest is None or key.due_s < soonest[0]:
                soonest = key.due_s, name
            if key.due_s <= now_s:
                break
        if soonest is None:
            return None
        self._turns.move_to_end(soonest[1], last=False)
        return soonest[0]

    def _taken(self) -> Content:
        """Return the next message of the key at the front, which goes to the end."""
        name, key = self._turns.popitem(last=False)
        self._make_room(key)
        told = key.waiting.popleft()
        key.due_s = self._now_s() + key.pacing.every_s if key.pacing.every_s > 0 else 0.0
        if key.waiting:
            self._turns[name] = key
            self._count_older(key, -told.size)
            return told.content
        if not key.due_s:
            del self._keys[name]
        return self._told(told)

    # ---- how much waits ----

    def _takes_in(self, size: int) -> bool:
        """Count one more that has to be kept; one too many is the last."""
        self.news.set()
        if self.overflowed:
            return False
        if self._messages >= MESSAGES_AT_MOST or (
            self._messages and self._bytes + size > BYTES_AT_MOST
        ):
            self.overflowed = True
            self._said.clear()
            self._keys.clear()
            self._turns.clear()
            self._bytes = self._older_bytes = self._messages = 0
            return False
        self._messages += 1
        self._bytes += size
        return True

    def _told(self, message: _Waiting[Content]) -> Content:
        """Count one less that has to be kept."""
        self._messages -= 1
        self._bytes -= message.size
        return message.content

    def _count_older(self, key: _Key[Content], size: int) -> None:
        key.older_bytes += size
        self._older_bytes += size

    def _make_room(self, key: _Key[Content]) -> None:
        """Let messages give way to newer ones of their key."""
        pacing, waiting, now_s = key.pacing, key.waiting, self._now_s()
        begun_s = now_s if self._sending_s is None else self._sending_s
        oldest_s = begun_s if pacing.every_s else min(begun_s, waiting[0].since_s)
        if now_s - oldest_s > FRESH_S:
            self._behind = True
        paced = self._behind or pacing.every_s > 0
        keep = pacing.keep if paced else max(pacing.keep, pacing.burst)
        while len(waiting) > keep:
            self._drop_oldest(key)
        while self._older_bytes > OLDER_BYTES_AT_MOST:
            self._drop_oldest(max(self._keys.values(), key=attrgetter("older_bytes")))

    def _drop_oldest(self, key: _Key[Content]) -> None:
        self._count_older(key, -key.waiting.popleft().size)
        self.replaced += 1


async def sent_in_time(send: Callable[[Content], Awaitable[None]], content: Content) -> None:
    """Send something.

    Args:
        send: Returns when the client has taken it.
        content: What is sent.

    Raises:
        SlowConsumer: It was not taken in time.
    """
    try:
        async with asyncio.timeout(TAKEN_WITHIN_S):
            await send(content)
    except TimeoutError:
        raise SlowConsumer from None


async def _wait(news: asyncio.Event, seconds: float | None) -> None:
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(seconds):
            await news.wait()
