"""What waits of one robot's words: few, the newest, and taken at a pace of its own.

A robot that says 10,000 things a second costs an append each; what is worked on is paced. Nothing
here is on the way of an order or of a stop.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from typing import TYPE_CHECKING, Final

from rosic.contracts.among import UTTERANCE_BYTES
from rosic.core.rate_limit import Bucket, RateLimit

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.contracts.clock import Clock

WAITING_AT_MOST: Final = 16
PACE: Final = RateLimit(burst=40.0, per_s=20.0)
FLOOD_DROPPED: Final = 100
# What is missing of a token by rounding alone is no time that a clock can wait for.
SHORTEST_S: Final = 0.001
CALM_NS: Final = 60_000_000_000

log = logging.getLogger("rosic.among")


class Inbox:
    """One robot's.

    Attributes:
        taken: How many utterances were worked on.
        dropped: How many were not, because they came too fast.
    """

    def __init__(
        self, clock: Clock, take: Callable[[bytes], Awaitable[None]], flooded: Callable[[], None]
    ) -> None:
        self.taken = 0
        self.dropped = 0
        self._clock = clock
        self._take = take
        self._flooded = flooded
        self._waiting: deque[bytes] = deque(maxlen=WAITING_AT_MOST)
        self._bucket = Bucket(PACE, clock.monotonic_ns())
        self._task: asyncio.Task[None] | None = None
        self._calm_dropped = 0
        self._dropped_ns = 0
        self._told = False

    def put(self, words: bytes, dropped: int = 0) -> None:
        """Let something wait; the oldest goes when too much does."""
        if len(self._waiting) == WAITING_AT_MOST:
            dropped += 1
        if dropped:
            self.dropped += dropped
            self._notice()
        self._waiting.append(words[: UTTERANCE_BYTES + 1])
        if self._task is None:
            self._task = asyncio.create_task(self._work())

    def _notice(self) -> None:
        """Say once that it is too much, and once more only after a minute in which it was not."""
        now_ns = self._clock.monotonic_ns()
        if now_ns - self._dropped_ns > CALM_NS:
            self._told, self._calm_dropped = False, self.dropped - 1
        self._dropped_ns = now_ns
        if not self._told and self.dropped - self._calm_dropped >= FLOOD_DROPPED:
            self._told = True
            self._flooded()

    async def _work(self) -> None:
        try:
            while self._waiting:
                wait_s = self._bucket.take(self._clock.monotonic_ns())
                if wait_s:
                    await self._clock.sleep(max(wait_s, SHORTEST_S))
                    continue
                self.taken += 1
                await self._one(self._waiting.popleft())
        finally:
            self._task = None

    async def _one(self, words: bytes) -> None:
        try:
            await self._take(words)
        except Exception:
            log.exception("what a robot said could not be taken")

    def close(self) -> None:
        """Take nothing more."""
        self._waiting.clear()
        if self._task is not None:
            self._task.cancel()
