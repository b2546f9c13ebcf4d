"""What an admin looks at: how long authentication takes, who was turned away, what ends soon."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser.link_messages import accounts_shown
from rosic.authoriser.messages import lasting
from rosic.core.i18n import joined, said, said_n
from rosic.core.identity import KeyId, Principal, PrincipalId

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.authoriser.authoriser import Authoriser
    from rosic.authoriser.counters import Counters
    from rosic.authoriser.enrolment import Enrolment
    from rosic.authoriser.keys import KeyRing
    from rosic.authoriser.locks import AccountLocks
    from rosic.authoriser.monotonic_clock import MonotonicWallClock


# ---- security report messages ----

# The security report in words, for admins.

CLOCK_BEHIND_S: Final = 2.0
SEVERAL_SHOWN: Final = 20
# What is counted, as people read it; another kind is shown as it is.
KINDS: Final = {
    "button-late": said("taps on a button that was too old"),
    "button-other": said("taps on a button that was shown to somebody else"),
    "button-used": said("taps on a button that was used before"),
    "code-again": said("own code sent again"),
    "code-breaker": said("times that many wrong codes left each account fewer tries"),
    "code-burnt": said("codes that were shown in a group before"),
    "code-expired": said("codes that had expired"),
    "code-in-group": said("good codes shown in a group"),
    "code-locked": said("codes from somebody who is locked"),
    "code-own": said("own invitations sent back"),
    "code-paused": said("codes during a pause of one account"),
    "code-unknown": said("codes that never were"),
    "code-used": said("codes that were used before"),
    "code-while-waiting": said("codes from somebody who waits for an admin"),
    "code-withdrawn": said("codes that were taken back"),
    "confirm-late": said("taps on a question that was settled or too old"),
    "confirm-no-right": said("taps by somebody who may let nobody in"),
    "confirm-own": said("people who tried to let themselves in"),
    "declined": said("people whom an admin did not let in"),
    "key-expired": said("requests after access had ended"),
    "key-revoked": said("requests after access was taken back"),
    "key-unknown": said("requests under a key that never was"),
    "link-in-group": said("good codes for another account shown in a group"),
    "link-own": said("own codes for another account said in the same account"),
    "link-taken": said("codes for another account from one that is known already"),
    "locked": said("requests by somebody who is locked"),
    "no-right": said("requests by somebody without the right"),
    "stranger": said("messages from strangers"),
    "too-many": said("requests that came too fast"),
    "totp-in-group": said("phones to be set up in a group"),
    "totp-paused": said("phone codes during a pause"),
    "totp-replayed": said("phone codes that were used before"),
    "totp-wrong": said("phone codes that were wrong"),
}


def times(measured: int, p50_s: float | None, p99_s: float | None) -> str:
    """Return how long it takes to recognise somebody."""
    if p50_s is None or p99_s is None:
        return said("Authentication: nothing measured yet.")
    return said(
        "Authentication: p50 {p50_s:.3f} ms, p99 {p99_s:.3f} ms, over the last {measured}.",
        p50_s=p50_s * 1000.0,
        p99_s=p99_s * 1000.0,
        measured=measured,
    )


def attempts(counts: Mapping[str, int]) -> list[str]:
    """Return the unauthorised attempts by kind."""
    if not counts:
        return [said("Unauthorised attempts: none.")]
    shown = [
        joined("", ("  ", KINDS.get(kind, kind), ": ", count)) for kind, count in counts.items()
    ]
    return [
        said("Unauthorised attempts since the first start: {sum}", sum=sum(counts.values())),
        *shown,
    ]


def locks(found: Sequence[tuple[str, str, float]]) -> list[str]:
    """Return who is locked: name, by whom, for how long."""
    if not found:
        return [said("Locked: nobody.")]
    return [
        "Locked:",
        *(
            said("  {who}, by {by}, for {lasting} now", who=who, by=by, lasting=lasting(s))
            for who, by, s in found
        ),
    ]


def endings(found: Sequence[tuple[str, str, float]]) -> list[str]:
    """Return which keys end soon: name, key, in how many seconds."""
    if not found:
        return [said("Keys near their end: none.")]
    shown = [
        said("  {who}, key {key}, in {lasting}", who=who, key=key, lasting=lasting(s))
        for who, key, s in found
    ]
    return [said("Keys near their end:"), *shown]


def invitations(found: Sequence[tuple[str, str, str, float]]) -> list[str]:
    """Return which invitations are open: what, by whom, id, for how long."""
    if not found:
        return [said("Open invitations: none.")]
    shown = [
        said(
            "  {what}, by {by}, {made}, good for {lasting}",
            what=what,
            by=by,
            made=made,
            lasting=lasting(s),
        )
        for what, by, made, s in found
    ]
    return [said("Open invitations:"), *shown]


def several_accounts(found: Sequence[tuple[str, str]]) -> list[str]:
    """Return who has more than one account: name, accounts."""
    if not found:
        return []
    shown = [
        said("  {who}: {accounts}", who=who, accounts=accounts)
        for who, accounts in found[:SEVERAL_SHOWN]
    ]
    title = said_n(
        "{n} person with several accounts:", "{n} people with several accounts:", len(found)
    )
    return [title, *shown]


def remarks(waiting: int, behind_s: float) -> list[str]:
    """Return what else an admin should see."""
    lines: list[str] = []
    if waiting:
        lines.append(
            said_n(
                "{n} person waits for an admin to let them in.",
                "{n} people wait for an admin to let them in.",
                waiting,
            )
        )
    if behind_s > CLOCK_BEHIND_S:
        lines.append(
            said(
                "The clock of this machine was set back by {lasting}. Times go on from the "
                "highest one seen, until its owner accepts the new one.",
                lasting=lasting(behind_s),
            )
        )
    return lines


# ---- security report ----


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
    """One look at the authoriser; ids and accounts only.

    Attributes:
        measured: How many authentications the two times come from; the newest ones.
        p50_s, p99_s: None when nothing was measured yet.
        attempts: Unauthorised attempts by kind.
        several: Who has access, and more than one account.
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
    several: tuple[Principal, ...]
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
            several=self._several(),
            waiting=len(self._enrolment.applicants.all()),
            behind_s=self._time.behind_s(),
        )

    def _several(self) -> tuple[Principal, ...]:
        directory = self._authoriser.directory
        good = directory.has_good_key
        return tuple(p for p in directory.people() if len(p.addresses) > 1 and good(p.id))

    def text(self) -> str:
        """Return the report with the names of people: for admins only."""
        return joined("\n", self.lines())

    def lines(self) -> list[str]:
        """Return the report line by line, with the names of people: for admins only."""
        name = self._authoriser.directory.name
        found = self.report()
        lines = [times(found.measured, found.p50_s, found.p99_s)]
        lines += attempts(found.attempts)
        lines += locks([(name(e.principal), name(e.by), e.for_s) for e in found.locks])
        lines += endings([(name(e.principal), e.key, e.in_s) for e in found.endings])
        invited = [(e.given, name(e.issuer), e.id, e.in_s) for e in found.invitations]
        lines += invitations(invited)
        lines += several_accounts([(p.name, accounts_shown(p.addresses)) for p in found.several])
        lines += remarks(found.waiting, found.behind_s)
        return lines


def percentile(ordered: Sequence[float], percent: float) -> float | None:
    """Return the nearest rank of sorted values: a value that was measured."""
    if not ordered:
        return None
    return ordered[max(0, ceil(len(ordered) * percent / 100) - 1)]
