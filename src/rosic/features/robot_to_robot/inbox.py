"""What waits of one robot's words: few, the newest, and taken at a pace of its own.

A robot that says 10,000 things a second costs an append each; what is worked on is paced. Nothing
here is on the way of an order or of a stop.
"""

from __future__ import annotations

import asyncio
import logging
from collections import OrderedDict, deque
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.contracts.robot import UTTERANCE_BYTES
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.time_units import HOUR_NS, MINUTE_NS

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import RobotId


# ---- one robot's inbox ----

WAITING_AT_MOST: Final = 16
PACE: Final = RateLimit(burst=40.0, per_s=20.0)
FLOOD_DROPPED: Final = 100
# What is missing of a token by rounding alone is no time that a clock can wait for.
SHORTEST_S: Final = 0.001
CALM_NS: Final = MINUTE_NS

log = logging.getLogger("rosic.robot_to_robot")


class Inbox:
    """The messages of one robot that wait to be taken.

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


# ---- robots that answer each other for ever ----

HOPS_AT_MOST: Final = 8
CONVERSATION: Final = RateLimit(burst=20.0, per_s=0.2)
CUT_NS: Final = 5 * MINUTE_NS
NEWS_AGAIN_NS: Final = HOUR_NS
REMEMBERED: Final = 4_096
PAIRS_AT_MOST: Final = 4_096


class HeardMessage(NamedTuple):
    """Something that was said, for whoever answers it."""

    robot: RobotId
    hops: int


class LoopGuard:
    """Counts who answers whom. All of it bounded, none of it written down."""

    def __init__(self) -> None:
        self._said: OrderedDict[str, HeardMessage] = OrderedDict()
        self._pairs: OrderedDict[tuple[RobotId, RobotId], Bucket] = OrderedDict()
        self._cut_until_ns: dict[tuple[RobotId, RobotId], int] = {}
        self._last_cut_ns: dict[tuple[RobotId, RobotId], int] = {}

    def remember(self, ident: str, robot: RobotId, hops: int) -> None:
        """Know what was said, so that an answer to it is known as one."""
        self._said[ident] = HeardMessage(robot, hops)
        if len(self._said) > REMEMBERED:
            self._said.popitem(last=False)

    def cause(self, ident: str) -> HeardMessage | None:
        """Return what somebody answers; None if it is unknown, or long ago."""
        return self._said.get(ident) if ident else None

    def hops(self, ident: str) -> int:
        """Return how long the chain is with an answer to something."""
        cause = self.cause(ident)
        return 0 if cause is None else cause.hops + 1

    def is_cut(self, one: RobotId, other: RobotId, now_ns: int) -> bool:
        """Whether nothing passes between two robots now."""
        return now_ns < self._cut_until_ns.get(_pair(one, other), 0)

    def passes(self, one: RobotId, other: RobotId, hops: int, now_ns: int) -> bool:
        """Whether something may pass from one robot to another; if not, they are to be cut."""
        return hops <= HOPS_AT_MOST and self._bucket(one, other, now_ns).take(now_ns) == 0

    def cut(self, one: RobotId, other: RobotId, now_ns: int) -> bool:
        """Let nothing pass between two robots for a while. Return whether that is news.

        It is none if they were cut lately: whoever begins again at once is cut again, silently.
        """
        pair = _pair(one, other)
        for old in [p for p, at_ns in self._last_cut_ns.items() if now_ns - at_ns > NEWS_AGAIN_NS]:
            del self._last_cut_ns[old]
            self._cut_until_ns.pop(old, None)
        news = pair not in self._last_cut_ns
        self._last_cut_ns[pair] = now_ns
        self._cut_until_ns[pair] = now_ns + CUT_NS
        self._pairs.pop(pair, None)
        return news

    def _bucket(self, one: RobotId, other: RobotId, now_ns: int) -> Bucket:
        pair = _pair(one, other)
        bucket = self._pairs.get(pair)
        if bucket is None:
            bucket = self._pairs[pair] = Bucket(CONVERSATION, now_ns)
            if len(self._pairs) > PAIRS_AT_MOST:
                self._pairs.popitem(last=False)
        self._pairs.move_to_end(pair)
        return bucket


def _pair(one: RobotId, other: RobotId) -> tuple[RobotId, RobotId]:
    return (one, other) if one < other else (other, one)
