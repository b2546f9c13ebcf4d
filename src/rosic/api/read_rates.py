"""How often each caller may read; orders and stops are the rooms' business, and none is a read.

What is left is told with every answer, as RateLimit and RateLimit-Policy of the IETF draft.
"""

from __future__ import annotations

import ipaddress
from collections import OrderedDict
from math import ceil
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.i18n import said
from rosic.core.rate_limit import Bucket
from rosic.errors import TooManyRequests

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.rate_limit import RateLimit

CALLERS_AT_MOST: Final = 4_096
NETWORK_BITS: Final = 64
"""Of an IPv6 address: whoever has one has all of them."""
TOO_OFTEN: Final = said("You ask too often. Wait a moment, then ask again. Nothing was done.")


class ReadQuota(NamedTuple):
    """What a caller has left.

    Attributes:
        left: Reads at once.
        full_s: Seconds until as many are left as ever are.
    """

    left: int
    full_s: int


class ReadRates:
    """A bucket for each caller, and for each place from which nobody who is known asks.

    Attributes:
        policy: As the header says it.
    """

    def __init__(self, clock: Clock, limit: RateLimit) -> None:
        self._clock, self._limit = clock, limit
        self._buckets: OrderedDict[str, Bucket] = OrderedDict()
        window_s = ceil(limit.burst / limit.per_s)
        self.policy = f'"reads";q={int(limit.burst)};w={window_s}'.encode()

    def take(self, who: str) -> tuple[ReadQuota, TooManyRequests | None]:
        """Count one read of somebody. Return what they have left, and why they may not read now.

        Args:
            who: A principal, or where somebody asks from; see `asking_from`.
        """
        now_ns = self._clock.monotonic_ns()
        bucket = self._buckets.get(who)
        if bucket is None:
            bucket = self._buckets[who] = Bucket(self._limit, now_ns)
            if len(self._buckets) > CALLERS_AT_MOST:
                self._buckets.popitem(last=False)
        self._buckets.move_to_end(who)
        wait_s = bucket.take(now_ns)
        missing = bucket.missing(now_ns)
        left = ReadQuota(
            int(self._limit.burst - missing), max(1, ceil(missing / self._limit.per_s))
        )
        if wait_s:
            return left, TooManyRequests(TOO_OFTEN, retry_after_s=wait_s)
        return left, None


def headers_of(allowance: ReadQuota, policy: bytes) -> tuple[tuple[bytes, bytes], ...]:
    """Return what tells a caller how often they may ask."""
    left = f'"reads";r={allowance.left};t={allowance.full_s}'.encode()
    return ((b"ratelimit-policy", policy), (b"ratelimit", left))


def asking_from(host: str) -> str:
    """Return the place of an address: itself, or the network of an IPv6 address."""
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        return host
    if address.version == 4:  # noqa: PLR2004
        return host
    return str(ipaddress.ip_network((address, NETWORK_BITS), strict=False))
