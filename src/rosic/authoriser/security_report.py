"""What an admin looks at: how long authentication takes, who was turned away, what ends soon."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

import msgspec

from rosic.authoriser import security_report_messages as words
from rosic.core.i18n import joined
from rosic.core.identity import KeyId, PrincipalId

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.authoriser.authoriser import Authoriser
    from rosic.authoriser.counters import Counters
    from rosic.authoriser.enrolment import Enrolment
    from rosic.authoriser.keys import KeyRing
    from rosic.authoriser.locks import AccountLocks
    from rosic.authoriser.monotonic_clock import MonotonicWallClock


class EndingAccess(msgspec.Struct, frozen=True):
    """A key that ends soon."""

    key: KeyId
    principal: PrincipalId
    in_s: float


class LockedAccess(msgspec.Struct, frozen=True):
    """Somebody who is locked, and for how long now."""

    principal: PrincipalId
    by: PrincipalId
    for_s: float


class OpenInvitation(msgspec.Struct, frozen=True):
    """An invitation whose code is good."""

    id: str
    given: str
    issuer: PrincipalId
    in_s: float


class SecurityReport(msgspec.Struct, frozen=True, kw_only=True):
    """One look at the authoriser; ids only.

    Attributes:
        measured: How many authentications the two times come from; the newest ones.
        p50_s, p99_s: None when nothing was measured yet.
        attempts: Unauthorised attempts by kind.
        waiting: How many wait for an admin's tap.
        behind_s: By how much the machine's clock is behind the highest time seen.
    """

    measured: int
    p50_s: float | None
    p99_s: float | None
    attempts: dict[str, int]
    locks: tuple[LockedAccess, ...]
    endings: tuple[EndingAccess, ...]
    invitations: tuple[OpenInvitation, ...]
    waiting: int
    behind_s: float


class SecurityReports:
    """Looks at what the others keep."""

    def __init__(
        self,
        authoriser: Authoriser,
        enrolment: Enrolment,
        keys: KeyRing,
        locks: AccountLocks,
        counters: Counters,
        time: MonotonicWallClock,
    ) -> None:
        self._authoriser = authoriser
        self._enrolment = enrolment
        self._keys = keys
        self._locks = locks
        self._counters = counters
        self._time = time

    def report(self) -> SecurityReport:
        """Return how things stand now; looks at every key, lock and invitation."""
        now_ns = self._time.wall_ns()
        times_s = sorted(self._authoriser.times_to_authenticate_s())
        return SecurityReport(
            measured=len(times_s),
            p50_s=percentile(times_s, 50),
            p99_s=percentile(times_s, 99),
            attempts=self._counters.by_kind(),
            locks=tuple(
                LockedAccess(who, lock.by, max(0, now_ns - lock.at_ns) / 1e9)
                for who, lock in self._locks.all().items()
            ),
            endings=tuple(
                EndingAccess(key.id, key.principal, left_s)
                for key, left_s in self._keys.near_expiry()
            ),
            invitations=tuple(
                OpenInvitation(i.id, i.given.words, i.issuer, (i.expires_ns - now_ns) / 1e9)
                for i in self._enrolment.invitations.open()
            ),
            waiting=len(self._enrolment.applicants.all()),
            behind_s=self._time.behind_s(),
        )

    def text(self) -> str:
        """Return the report with the names of people: for admins only."""
        return joined("\n", self.lines())

    def lines(self) -> list[str]:
        """Return the report line by line, with the names of people: for admins only."""
        name = self._authoriser.directory.name
        found = self.report()
        lines = [words.times(found.measured, found.p50_s, found.p99_s)]
        lines += words.attempts(found.attempts)
        lines += words.locks([(name(e.principal), name(e.by), e.for_s) for e in found.locks])
        lines += words.endings([(name(e.principal), e.key, e.in_s) for e in found.endings])
        invited = [(e.given, name(e.issuer), e.id, e.in_s) for e in found.invitations]
        lines += words.invitations(invited)
        lines += words.remarks(found.waiting, found.behind_s)
        return lines


def percentile(ordered: Sequence[float], percent: float) -> float | None:
    """Return the nearest rank of sorted values: a value that was measured."""
    if not ordered:
        return None
    return ordered[max(0, ceil(len(ordered) * percent / 100) - 1)]
