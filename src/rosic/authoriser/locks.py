"""Who is locked out, by an admin or by themselves: a lost phone, a stolen session."""

from __future__ import annotations

import logging
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import keys_messages as words
from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.records import Decided, Fact
from rosic.errors import NotPermitted, NotUnderstood

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable

    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.core.records import Record

KIND: Final = "lock"
UNKNOWN: Final = "somebody"

_log = logging.getLogger(__name__)


class AccountLock(msgspec.Struct, frozen=True):
    """The body of the fact; its key is the principal.

    Attributes:
        by: Who locked them.
        at_ns: Wall clock.
    """

    by: PrincipalId
    at_ns: int


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(AccountLock).decode


class AccountLocks:
    """Every lock, by principal.

    A lock that cannot be written is applied all the same: the caller applies the fact whether or
    not the store took it.
    """

    def __init__(self, time: MonotonicWallClock) -> None:
        self._time = time
        self._locks: dict[PrincipalId, AccountLock] = {}

    def locked(self, principal: PrincipalId) -> bool:
        """Whether somebody is locked; one look-up."""
        return principal in self._locks

    def everybody(self) -> Collection[PrincipalId]:
        """Return a live view of who is locked, for a decision."""
        return self._locks.keys()

    def all(self) -> dict[PrincipalId, AccountLock]:
        """Return every lock."""
        return dict(self._locks)

    def lock(self, principal: PrincipalId, by: PrincipalId) -> tuple[Record, ...]:
        """Return what makes somebody locked. Anybody may lock themselves; twice is no mistake."""
        now_ns = self._time.wall_ns()
        body = _encode(AccountLock(by, now_ns))
        decided = Decided(act="lock", by=by, about=principal, at_ns=now_ns, digest=_digest(body))
        return (decided, Fact(kind=KIND, key=principal, body=body))

    def unlock(self, principal: PrincipalId, by: PrincipalId, name: str) -> tuple[Record, ...]:
        """Return what ends a lock.

        Raises:
            NotPermitted: Nobody unlocks themselves. Nothing changed.
            NotUnderstood: They are not locked. Nothing changed.
        """
        if by == principal:
            raise NotPermitted(words.OWN_UNLOCK)
        if principal not in self._locks:
            raise NotUnderstood(words.not_locked(name))
        decided = Decided(act="unlock", by=by, about=principal, at_ns=self._time.wall_ns())
        return (decided, Fact(kind=KIND, key=principal, body=b""))

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over every lock that is written down."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. A lock that cannot be read is a lock."""
        if not fact.body:
            self._locks.pop(fact.key, None)
            return
        try:
            self._locks[fact.key] = _decode(fact.body)
        except msgspec.MsgspecError:
            _log.warning("a lock cannot be read; it holds")
            self._locks[fact.key] = AccountLock(UNKNOWN, 0)


def _digest(body: bytes) -> bytes:
    return blake2b(body, digest_size=DIGEST_BYTES).digest()
