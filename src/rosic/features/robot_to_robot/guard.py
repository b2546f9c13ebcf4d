"""Keeps robots from answering each other for ever.

Two guards, because a robot may say why it speaks, or not. Whoever names what it answers makes a
chain, and a chain ends after `HOPS_AT_MOST`. Whoever does not is held by a budget for each pair.
Either cuts the pair for a while; people are told once.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.rate_limit import Bucket, RateLimit

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId

HOPS_AT_MOST: Final = 8
CONVERSATION: Final = RateLimit(burst=20.0, per_s=0.2)
CUT_NS: Final = 300_000_000_000
NEWS_AGAIN_NS: Final = 3_600_000_000_000
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
