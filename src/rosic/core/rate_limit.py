"""Requests per duration: a token bucket whose state is two numbers."""

from __future__ import annotations

import re
from typing import Final

import msgspec

from rosic.core.i18n import said
from rosic.core.time_units import DAY_S, HOUR_S

_RATE = re.compile(
    r"(?P<count>\d{1,6}) ?/ ?(?P<unit>s|min|h|day)(?:,? +burst +(?P<burst>\d{1,6}))?\Z"
)
_UNITS: Final = {"s": 1.0, "min": 60.0, "h": float(HOUR_S), "day": float(DAY_S)}


class RateLimit(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """At most ``burst`` at once, refilled at ``per_s`` a second."""

    burst: float = 20.0
    per_s: float = 2.0

    def __post_init__(self) -> None:
        if not (self.burst >= 1 and self.per_s > 0):
            raise ValueError("a rate needs burst of at least 1 and per_s above 0")


def parse_rate(text: str) -> RateLimit:
    """Read a rate: ``30/min``, ``1/s``, ``100/day burst 10``. Without a burst it is the number.

    Raises:
        ValueError: It is none; one clear sentence.
    """
    found = _RATE.match(" ".join(text.split()))
    if found is None or not int(found["count"]) or found["burst"] in {"0", "00"}:
        raise _no_rate(text)
    count = int(found["count"])
    burst = int(found["burst"] or count)
    if burst < 1:
        raise _no_rate(text)
    return RateLimit(burst=float(burst), per_s=count / _UNITS[found["unit"]])


def _no_rate(text: str) -> ValueError:
    return ValueError(
        said(
            '{text!r} is not a rate: write for example "30/min" or "30/min burst 5"', text=text[:60]
        )
    )


class Bucket:
    """One bucket: somebody's, a robot's or a role's.

    Args:
        limit: What it holds and how fast it fills.
        now_ns: Monotonic clock.
        tokens: What is in it now; None: it is full.
    """

    __slots__ = ("_filled_ns", "_tokens", "limit")

    def __init__(self, limit: RateLimit, now_ns: int, tokens: float | None = None) -> None:
        self.limit = limit
        self._tokens = limit.burst if tokens is None else min(limit.burst, max(0.0, tokens))
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

    def wait_s(self, now_ns: int, cost: float) -> float:
        """Return 0.0 if ``cost`` could be taken, or the seconds until then. Takes nothing."""
        missing = cost - (self.limit.burst - self.missing(now_ns))
        return missing / self.limit.per_s if missing > 0 else 0.0

    def missing(self, now_ns: int) -> float:
        """Return how many tokens it lacks to be full."""
        self.take(now_ns, 0.0)
        return self.limit.burst - self._tokens
