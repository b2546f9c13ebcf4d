"""Requests per duration: a token bucket whose state is two numbers."""

from __future__ import annotations

import msgspec


class RateLimit(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """At most ``burst`` at once, refilled at ``per_s`` a second."""

    burst: float = 20.0
    per_s: float = 2.0

    def __post_init__(self) -> None:
        if not (self.burst >= 1 and self.per_s > 0):
            raise ValueError("a rate needs burst of at least 1 and per_s above 0")


class Bucket:
    """One principal's bucket."""

    __slots__ = ("_filled_ns", "_tokens", "limit")

    def __init__(self, limit: RateLimit, now_ns: int) -> None:
        self.limit = limit
        self._tokens = limit.burst
        self._filled_ns = now_ns

    def take(self, now_ns: int, cost: float = 1.0) -> float:
        """Take ``cost`` tokens. Return 0.0, or the seconds until that would succeed.

        Args:
            now_ns: Monotonic clock; an earlier time than the last adds nothing.
            cost: At most the burst, or it can never succeed.
        """
        limit = self.limit
        elapsed_s = (now_ns - self._filled_ns) / 1e9
        if elapsed_s > 0:
            tokens = self._tokens + elapsed_s * limit.per_s
            self._tokens = tokens if tokens < limit.burst else limit.burst  # noqa: FURB136
            self._filled_ns = now_ns
        if self._tokens >= cost:
            self._tokens -= cost
            return 0.0
        return (cost - self._tokens) / limit.per_s
