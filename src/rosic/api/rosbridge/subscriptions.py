"""What one client of rosbridge is told of topics: in which form, how often, and how much waits."""

from __future__ import annotations

from functools import cached_property, partial
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

from rosic.api.connections import frame_of
from rosic.api.rosbridge.encodings import cbor, png
from rosic.api.rosbridge.messages import PngMessage, TopicPublish, written
from rosic.gateway.send_queue import Pacing, SendQueue

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.api.rosbridge.messages import Id
    from rosic.contracts.graph_topics import TopicMessage

    ClientQueue: TypeAlias = SendQueue[Callable[[], bytes]]
    """What is told is made into a frame when it is sent: what gave way is never looked at."""

BURST: Final = 256
"""Messages of one topic that may wait while the client takes what it is sent."""
COMPRESSIONS: Final = ("none", "png", "cbor")


class TopicUpdate:
    """A message of a topic, made into a frame once for everybody who wants it in that form.

    Attributes:
        size: In bytes, as it came.
    """

    def __init__(self, topic: str, message: TopicMessage) -> None:
        self._topic, self._message = topic, message
        self.size = message.size

    def frame(self, compression: str) -> bytes:
        """Return it as it is sent.

        Raises:
            Fault: What came is of another type than was said.
        """
        if compression == "cbor":
            return self._cbor
        return self._png if compression == "png" else self._json

    @cached_property
    def _json(self) -> bytes:
        return frame_of(self._written, text=True)

    @cached_property
    def _png(self) -> bytes:
        return frame_of(written(PngMessage(png(self._written))), text=True)

    @cached_property
    def _cbor(self) -> bytes:
        told = {"op": "publish", "topic": self._topic, "msg": self._message.fields}
        return frame_of(cbor(told), text=False)

    @property
    def _written(self) -> bytes:
        return written(TopicPublish(self._topic, self._message.fields))


class SubscriptionSettings(NamedTuple):
    """What one subscription asks for."""

    every_s: float = 0.0
    queue_length: int = 0
    compression: str = "none"


class TopicSubscriptions:
    """All subscriptions of one client to one topic: it is told the most often, and keeps the most.

    Attributes:
        topic: Absolute name.
    """

    def __init__(self, topic: str, queue: ClientQueue) -> None:
        self.topic = topic
        self._queue = queue
        self._all: dict[Id, SubscriptionSettings] = {}
        self._compression, self._pacing = COMPRESSIONS[0], Pacing()

    def subscribe(self, known: Id, wanted: SubscriptionSettings) -> None:
        """Take one more in, or another in its place."""
        self._all[known] = wanted
        self._agree()

    def unsubscribe(self, known: Id) -> bool:
        """Let one go, or all without an id. Return whether none is left."""
        if known is None:
            self._all.clear()
        self._all.pop(known, None)
        if self._all:
            self._agree()
            return False
        self.close()
        return True

    def close(self) -> None:
        """Tell nothing more of this topic."""
        self._queue.forget(self.topic)

    def put(self, update: TopicUpdate) -> None:
        """Have a message told, in its turn."""
        frame = partial(update.frame, self._compression)
        self._queue.show(self.topic, frame, update.size, self._pacing)

    def _agree(self) -> None:
        wanted = self._all.values()
        forms = {each.compression for each in wanted}
        self._compression = next(form for form in reversed(COMPRESSIONS) if form in forms)
        keep = max(1, *(each.queue_length for each in wanted))
        self._pacing = Pacing(min(each.every_s for each in wanted), keep, BURST)
