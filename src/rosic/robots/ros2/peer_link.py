"""A robot's own nodes among other robots: what they say and what they hear, over two topics."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

from rosic.contracts.among import UTTERANCE_BYTES
from rosic.errors import RosicError
from rosic.robots.ros2.client.rate_limited_topic import WAITING_AT_MOST, RateLimitedTopic
from rosic.robots.ros2.client.topics import TopicQos

if TYPE_CHECKING:
    from rosic.contracts.among import Speak
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import Publisher

_log = logging.getLogger(__name__)

SAY: Final = "among/say"
HEAR: Final = "among/hear"
TYPE: Final = "std_msgs/msg/String"
DEPTH: Final = 50


class PeerLink:
    """``<namespace>/among/say`` and ``<namespace>/among/hear``, JSON in a ``std_msgs/msg/String``.

    Who speaks is the robot whose namespace it is; nothing in the words can say otherwise.
    """

    def __init__(self, namespace: str) -> None:
        self._namespace = namespace
        self._speak: Speak | None = None
        self._publisher: Publisher | None = None
        self._words: RateLimitedTopic | None = None

    def types(self) -> set[str]:
        """Return the type of both topics."""
        return {TYPE}

    def meet(self, speak: Speak) -> None:
        """Say who takes what the nodes say."""
        self._speak = speak

    async def open(self, runtime: RosRuntime) -> None:
        """Begin to listen; what is said before anybody was met is not taken."""
        if self._speak is not None:
            self._publisher = await runtime.publisher(
                f"{self._namespace}/{HEAR}", TYPE, TopicQos(depth=DEPTH)
            )
            self._words = await runtime.paced_words(
                f"{self._namespace}/{SAY}", self._speak, UTTERANCE_BYTES,
                TopicQos(depth=WAITING_AT_MOST),
            )  # fmt: skip

    async def close(self) -> None:
        """Leave both topics."""
        publisher, self._publisher = self._publisher, None
        words, self._words = self._words, None
        if publisher is not None:
            await publisher.close()
        if words is not None:
            await words.close()

    def hear(self, words: bytes) -> bool:
        """Publish to the robot's nodes. Return whether somebody listens."""
        if self._publisher is None or not self._publisher.listeners:
            return False
        try:
            self._publisher.publish({"data": words.decode()})
        except RosicError as fault:
            _log.warning("the nodes under %s were not told: %s", self._namespace, fault)
            return False
        return True
