"""What one client of rosbridge is yet to be told: answers in order, of each topic the newest.

No topic waits behind another: each gives one message in its turn. As long as the client takes what
it is sent, all of a burst is sent; once it does not, of each topic only the newest is kept.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict, deque
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.api.rosbridge.encodings import cbor, png
from rosic.api.rosbridge.messages import PngMessage, TopicPublish, written

if TYPE_CHECKING:
    from rosic.api.rosbridge.messages import Id
    from rosic.contracts.graph_topics import TopicMessage

BURST: Final = 256
"""Messages of one topic that may wait while the client takes what it is sent."""
ANSWERS_AT_MOST: Final = 1_024
STALLED_S: Final = 0.1
COMPRESSIONS: Final = ("none", "png", "cbor")


class TopicUpdate:
    """A message of a topic, written once for everybody who wants it in that form."""

    def __init__(self, topic: str, message: TopicMessage) -> None:
        self._topic, self._message = topic, message

    def written(self, compression: str) -> str | bytes:
        """Return it as it is sent.

        Raises:
            Fault: What came is of another type than was said.
        """
        if compression == "cbor":
            return self._cbor
        return self._png if compression == "png" else self._json

    @cached_property
    def _json(self) -> str:
        return written(TopicPublish(self._topic, self._message.fields))

    @cached_property
    def _png(self) -> str:
        return written(PngMessage(png(self._json)))

    @cached_property
    def _cbor(self) -> bytes:
        told = {"op": "publish", "topic": self._topic, "msg": self._message.fields}
        return cbor(told)


class SubscriptionSettings(NamedTuple):
    """What one subscription asks for."""

    every_s: float = 0.0
    queue_length: int = 0
    compression: str = "none"


class TopicQueue:
    """What one client is yet to be told of one topic.

    Attributes:
        topic: Absolute name.
        terms: Of all of its subscriptions together: the most often, the longest queue.
        dropped: How many messages gave way to newer ones.
    """

    def __init__(self, topic: str, outbox: ClientOutbox) -> None:
        self.topic = topic
        self.dropped = 0
        self.terms = SubscriptionSettings()
        self._outbox = outbox
        self._subscriptions: dict[Id, SubscriptionSettings] = {}
        self._waiting: deque[TopicUpdate] = deque()
        self._due_s = 0.0
        self._timer: asyncio.TimerHandle | None = None

    def subscribe(self, known: Id, terms: SubscriptionSettings) -> None:
        """Take one more subscription in, or another in its place."""
        self._subscriptions[known] = terms
        self._agree()

    def unsubscribe(self, known: Id) -> bool:
        """Let one go, or all without an id. Return whether none is left."""
        if known is None:
            self._subscriptions.clear()
        self._subscriptions.pop(known, None)
        if self._subscriptions:
            self._agree()
            return False
        self.close()
        return True

    def close(self) -> None:
        """Tell nothing more of this topic."""
        self._waiting.clear()
        if self._timer is not None:
            self._timer.cancel()

    def put(self, update: TopicUpdate) -> None:
        """Have a message told, in its turn."""
        terms = self.terms
        paced = terms.every_s > 0
        most = max(1, terms.queue_length) if paced or self._outbox.stalled else BURST
        while len(self._waiting) >= most:
            self._waiting.popleft()
            self.dropped += 1
        self._waiting.append(update)
        self._offer()

    def take(self) -> str | bytes:
        """Return what is told next; there is something.

        Raises:
            Fault: What came is of another type than was said.
        """
        update = self._waiting.popleft()
        if self.terms.every_s > 0:
            self._due_s = asyncio.get_running_loop().time() + self.terms.every_s
        if self._waiting:
            self._offer()
        return update.written(self.terms.compression)

    @property
    def empty(self) -> bool:
        """Whether nothing waits."""
        return not self._waiting

    def _agree(self) -> None:
        wanted = self._subscriptions.values()
        forms = {each.compression for each in wanted}
        self.terms = SubscriptionSettings(
            min(each.every_s for each in wanted),
            max(each.queue_length for each in wanted),
            next(form for form in reversed(COMPRESSIONS) if form in forms),
        )

    def _offer(self) -> None:
        if self.terms.every_s > 0:
            loop = asyncio.get_running_loop()
            wait_s = self._due_s - loop.time()
            if wait_s > 0:
                if self._timer is None:
                    self._timer = loop.call_later(wait_s, self._ring)
                return
        self._outbox.offer(self)

    def _ring(self) -> None:
        self._timer = None
        if self._waiting:
            self._outbox.offer(self)


class ClientOutbox:
    """Everything that one client is yet to be told.

    Attributes:
        overflowed: It takes so little that an answer had to be dropped.
    """

    def __init__(self) -> None:
        self.overflowed = False
        self._answers: deque[str] = deque()
        self._offered: OrderedDict[TopicQueue, None] = OrderedDict()
        self._news = asyncio.Event()
        self._sending_s: float | None = None

    def say(self, text: str) -> None:
        """Have an answer told, before whatever topics have."""
        if len(self._answers) >= ANSWERS_AT_MOST:
            self.overflowed = True
        else:
            self._answers.append(text)
        self._news.set()

    def offer(self, queue: TopicQueue) -> None:
        """A topic has something to tell."""
        self._offered[queue] = None
        self._news.set()

    async def next(self) -> str | bytes:
        """Return what is told next, waiting for it.

        Raises:
            Fault: What came of a topic is of another type than was said; the rest is told.
        """
        while True:
            if self._answers:
                return self._answers.popleft()
            while self._offered:
                queue, _ = self._offered.popitem(last=False)
                if not queue.empty:
                    return queue.take()
            self._news.clear()
            await self._news.wait()

    # ---- how well the client takes it ----

    def sending(self, at_s: float | None) -> None:
        """Something is being sent since then; None: it was taken."""
        self._sending_s = at_s

    def waits_s(self) -> float:
        """Return for how many seconds the client has taken nothing of what is being sent."""
        if self._sending_s is None:
            return 0.0
        return asyncio.get_running_loop().time() - self._sending_s

    @property
    def stalled(self) -> bool:
        """Whether the client does not take what it is sent."""
        return self._sending_s is not None and self.waits_s() > STALLED_S
