"""How much passes a link: counts that only grow, and what they come to in a second."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Mapping

STALE_NS: Final = 10 * SECOND_NS
"""Of a span longer than this nobody is told what passed in one second of it."""


class TrafficCount(NamedTuple):
    """What has passed a link since it was made.

    Attributes:
        received, sent: Messages.
        received_bytes, sent_bytes: What they held; 0 where a link counts messages alone.
    """

    received: int = 0
    sent: int = 0
    received_bytes: int = 0
    sent_bytes: int = 0


class TrafficCounter:
    """Counts for a link that is not asked for it in between: two additions for each message."""

    __slots__ = ("_received", "_received_bytes", "_sent", "_sent_bytes")

    def __init__(self) -> None:
        self._received = self._sent = self._received_bytes = self._sent_bytes = 0

    def came(self, size: int = 0, messages: int = 1) -> None:
        """Count what came in."""
        self._received += messages
        self._received_bytes += size

    def went(self, size: int = 0, messages: int = 1) -> None:
        """Count what went out."""
        self._sent += messages
        self._sent_bytes += size

    @property
    def count(self) -> TrafficCount:
        """Return what has passed so far."""
        return TrafficCount(self._received, self._sent, self._received_bytes, self._sent_bytes)


class TrafficRate(NamedTuple):
    """What passes a link in one second.

    Attributes:
        received_per_s, sent_per_s: Messages.
        received_bytes_s, sent_bytes_s: What they hold.
    """

    received_per_s: float
    sent_per_s: float
    received_bytes_s: float
    sent_bytes_s: float


class TrafficMeter:
    """Says what passed in the last second, from counts that are taken about once a second."""

    def __init__(self) -> None:
        self._before: Mapping[str, TrafficCount] = {}
        self._before_ns = 0

    def take(self, counts: Mapping[str, TrafficCount], now_ns: int) -> dict[str, TrafficRate]:
        """Take counts, by the names of their links; return the rates since those before.

        Args:
            counts: As they are now.
            now_ns: Monotonic clock.

        Returns:
            Nothing the first time and after a long pause; of a new link nothing yet.
        """
        past_ns = now_ns - self._before_ns if self._before else 0
        before, self._before, self._before_ns = self._before, counts, now_ns
        if not 0 < past_ns <= STALE_NS:
            return {}
        past_s = past_ns / SECOND_NS
        return {
            name: TrafficRate(
                *((new - old) / past_s for new, old in zip(now, before[name], strict=True))
            )
            for name, now in counts.items()
            if name in before
        }
