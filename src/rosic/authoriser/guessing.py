"""How many wrong codes are too many: from one address, and from everybody together.

Whoever has a good code gets in, whatever others do: no number of wrong codes of other addresses
shuts anybody out. It makes guessing dearer instead, which is hopeless anyway: see
``docs/rooms/authoriser.md`` for how long it would take.

Counted at once and in memory: a wrong code costs no disk. A restart forgets the count, which
nobody outside can cause.
"""

from __future__ import annotations

from collections import OrderedDict, deque
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.time_units import HOUR_S

if TYPE_CHECKING:
    from rosic.core.identity import Address

ADDRESSES_AT_MOST: Final = 10_000


class GuessLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How many wrong codes pause joining, and for how long.

    Attributes:
        tries: Wrong codes of one address before it has to wait.
        pause_s: How long it waits; as long after the last wrong code they are forgotten.
        breaker_tries: Wrong codes of all addresses within ``breaker_within_s`` that open the
            breaker: for ``breaker_pause_s`` each address has ``breaker_each`` tries, and waits as
            long after them. It shuts nobody out: ten strangers could do that to everybody.
    """

    tries: int = 5
    pause_s: float = 900.0
    breaker_tries: int = 50
    breaker_within_s: float = float(HOUR_S)
    breaker_pause_s: float = float(HOUR_S)
    breaker_each: int = 2

    def __post_init__(self) -> None:
        spans = (self.pause_s, self.breaker_within_s, self.breaker_pause_s)
        if min(self.tries, self.breaker_tries, self.breaker_each) < 1 or not all(
            span > 0 for span in spans
        ):
            raise ValueError("tries and times of joining are greater than 0")


class _Tries(msgspec.Struct):
    """One address: wrong codes in a row, the last one's time, and until when it waits."""

    wrong: int = 0
    last_ns: int = 0
    until_ns: int = 0


class BruteForceGuard:
    """Wrong codes on the monotonic clock. Bounded: the addresses seen longest ago go first."""

    def __init__(self, limits: GuessLimits) -> None:
        self.limits = limits
        self._tries: OrderedDict[tuple[str, str], _Tries] = OrderedDict()
        self._all: deque[int] = deque(maxlen=limits.breaker_tries)
        self._open_until_ns = 0

    def pause_s(self, address: Address, now_ns: int) -> float:
        """Return how long one address has to wait; 0.0 when it may try."""
        tries = self._tries.get((address.platform, address.account))
        return 0.0 if tries is None else max(0, tries.until_ns - now_ns) / 1e9

    def wrong(self, address: Address, now_ns: int) -> bool:
        """Count a wrong code of an address that may try. Return whether the breaker opens now."""
        where = (address.platform, address.account)
        tries = self._tries.setdefault(where, _Tries())
        self._tries.move_to_end(where)
        if len(self._tries) > ADDRESSES_AT_MOST:
            self._tries.popitem(last=False)
        allowed, pause_ns = self._allowed(now_ns)
        if now_ns - tries.last_ns >= pause_ns:
            tries.wrong = 0
        tries.wrong += 1
        tries.last_ns = now_ns
        if tries.wrong >= allowed:
            tries.until_ns = now_ns + pause_ns
        return self._counted_for_all(now_ns)

    def _allowed(self, now_ns: int) -> tuple[int, int]:
        """Return how many wrong codes an address may send before it waits, and for how long."""
        limits = self.limits
        if now_ns >= self._open_until_ns:
            return limits.tries, int(limits.pause_s * 1e9)
        longer_s = max(limits.pause_s, limits.breaker_pause_s)
        return min(limits.tries, limits.breaker_each), int(longer_s * 1e9)

    def _counted_for_all(self, now_ns: int) -> bool:
        """Count one for the breaker; while it is open more of them keep it so. Opens it now?"""
        limits, was_open = self.limits, now_ns < self._open_until_ns
        self._all.append(now_ns)
        full = len(self._all) == limits.breaker_tries
        if not full or now_ns - self._all[0] > limits.breaker_within_s * 1e9:
            return False
        self._all.clear()
        self._open_until_ns = now_ns + int(limits.breaker_pause_s * 1e9)
        return not was_open

    def right(self, address: Address) -> None:
        """Forget the wrong codes of somebody who then had a right one."""
        self._tries.pop((address.platform, address.account), None)

    def reopen(self) -> None:
        """Let everybody try again, because an admin says so."""
        self._open_until_ns = 0
        self._all.clear()
        self._tries.clear()
