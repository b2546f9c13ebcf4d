"""A topic on which anybody may say anything at any rate: the newest are taken, at a pace."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import TYPE_CHECKING, Final

from rosic.robots.ros2.client.topics import Subscription
from rosic.robots.ros2.errors import BadValue

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.robots.ros2.client.connection import RosConnection
    from rosic.robots.ros2.client.rclpy_import import RosObject

WAITING_AT_MOST: Final = 16
PAUSE_S: Final = 0.05
# Before the text of a std_msgs/String on the wire: how it is encoded, and how long it is.
HEAD_BYTES: Final = 8


class RateLimitedTopic(Subscription):
    """Texts of one topic, taken in turns with a pause between them.

    The first of a calm topic is taken at once. Of a flood, what is turned into Python is bounded;
    what is too old by then is dropped and counted, and what is too long never becomes a text.

    Args:
        runtime, topic, cls: As `Subscription` has them; of type ``std_msgs/msg/String``.
        on_words: Takes UTF-8 on the event loop, and how many were dropped before it.
        at_most: So many bytes and one more are handed on of a longer text.
    """

    def __init__(
        self,
        runtime: RosConnection,
        topic: str,
        cls: RosObject,
        on_words: Callable[[bytes, int], None],
        at_most: int,
    ) -> None:
        super().__init__(runtime, topic, cls)
        self.dropped = 0
        self._on_words = on_words
        self._at_most = at_most
        self._reported = 0
        self._waiting: deque[tuple[bool, bytes]] = deque(maxlen=WAITING_AT_MOST)

    def arrived(self, content: bytes) -> None:
        """Take a message; on the ROS thread."""
        if len(self._waiting) == WAITING_AT_MOST:
            self.dropped += 1
        whole = len(content) <= HEAD_BYTES + self._at_most + 1
        kept = content if whole else bytes(content[HEAD_BYTES : HEAD_BYTES + self._at_most + 1])
        self._waiting.append((whole, kept))
        self._knock()

    def _answered(self) -> None:
        """Take a turn; the next knock is heard after a pause."""
        self._deliver()
        asyncio.get_running_loop().call_later(PAUSE_S, self._after_pause)

    def _after_pause(self) -> None:
        self._offered = False
        if self._waiting and self._runtime.alive:
            self._offered = True
            self._answered()

    def _deliver(self) -> None:
        for _ in range(len(self._waiting)):
            whole, content = self._waiting.popleft()
            dropped, self._reported = self.dropped - self._reported, self.dropped
            words = content
            if whole:
                try:
                    words = self._decode(content).data.encode(errors="replace")
                except BadValue:
                    words = b""
            self._on_words(words, dropped)
