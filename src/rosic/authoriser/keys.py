"""Authorisation keys over time: which are good, replacing them, taking them back."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.authoriser import keys_messages as words
from rosic.core.i18n import said
from rosic.core.identity import RECORD_ID_BYTES, AuthorisationKey, KeyId, PrincipalId
from rosic.core.records import Decided, Fact, KeyIssued, KeyRevoked, Record
from rosic.core.time_units import DAY_S
from rosic.errors import NotUnderstood, OutOfBounds, Unrecognised

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.counters import Counters
    from rosic.authoriser.monotonic_clock import MonotonicWallClock
    from rosic.contracts.clock import Entropy

KIND: Final = "key-end"
GRACE_MAX_S: Final = 30.0 * DAY_S
NEAR_S: Final = 7.0 * DAY_S

_log = logging.getLogger(__name__)


class KeyEnd(msgspec.Struct, frozen=True):
    """The body of the fact; its key is the id of an authorisation key that was replaced.

    Attributes:
        by: Who replaced it.
        at_ns: Until when it is good; wall clock. Never later than its own expiry counts.
    """

    by: PrincipalId
    at_ns: int


class Rotation(msgspec.Struct, frozen=True):
    """A new key in place of another.

    Attributes:
        key: The new one, with the bounds and the expiry of the old one: no right grows.
        old: Id of the replaced one.
        records: To be written together, then applied.
    """

    key: AuthorisationKey
    old: KeyId
    grace_s: float
    records: tuple[Record, ...]


class Revocation(msgspec.Struct, frozen=True):
    """A key taken back.

    Attributes:
        records: To be written; applied even if they cannot be written.
    """

    key: KeyId
    principal: PrincipalId
    records: tuple[Record, ...]


_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.Decoder(KeyEnd).decode


class KeyRing:
    """Every key that was ever given, by id and by principal.

    Attributes:
        time: By which keys end; never goes back.
        counters: Counts whoever is turned away.
    """

    def __init__(self, time: MonotonicWallClock, entropy: Entropy, counters: Counters) -> None:
        self.time = time
        self._entropy = entropy
        self.counters = counters
        self._keys: dict[KeyId, AuthorisationKey] = {}
        self._of: dict[PrincipalId, list[KeyId]] = {}
        self._ends: dict[KeyId, int] = {}

    # ---- asking: look-ups only ----

    def ends_ns(self, key: AuthorisationKey) -> int | None:
        """Return when a key ends by itself; wall clock; None for never."""
        known = [at for at in (key.expires_ns, self._ends.get(key.id)) if at is not None]
        return min(known, default=None)

    def good(self, key_id: KeyId) -> bool:
        """Whether a key is known, not revoked and not at its end."""
        return self._fault(key_id) is None

    def check(self, key_id: KeyId) -> AuthorisationKey:
        """Return a key that is good; for every request, read or write.

        Raises:
            Unrecognised: Unknown, revoked or expired; counted by kind.
        """
        fault = self._fault(key_id)
        if fault is not None:
            raise self.counters.refuse(fault, Unrecognised(words.ENDED))
        return self._keys[key_id]

    def _fault(self, key_id: KeyId) -> str | None:
        key = self._keys.get(key_id)
        if key is None:
            return "key-unknown"
        if key.revoked_ns is not None:
            return "key-revoked"
        ends_ns = self.ends_ns(key)
        return "key-expired" if ends_ns is not None and self.time.wall_ns() >= ends_ns else None

    def of(self, principal: PrincipalId) -> tuple[AuthorisationKey, ...]:
        """Return somebody's keys, the newest first."""
        return tuple(self._keys[key] for key in reversed(self._of.get(principal, [])))

    def current(self, principal: PrincipalId) -> AuthorisationKey | None:
        """Return somebody's newest good key."""
        return next((key for key in self.of(principal) if self.good(key.id)), None)

    def issued_by(self, principal: PrincipalId) -> tuple[AuthorisationKey, ...]:
        """Return the keys that somebody has given to others and that nobody took back."""
        found = (key for key in self._keys.values() if key.issuer == principal)
        return tuple(k for k in found if k.principal != principal and k.revoked_ns is None)

    def all(self) -> tuple[AuthorisationKey, ...]:
        """Return every key."""
        return tuple(self._keys.values())

    def near_expiry(self, within_s: float = NEAR_S) -> tuple[tuple[AuthorisationKey, float], ...]:
        """Return good keys that end soon and in how many seconds, the next first."""
        now_ns = self.time.wall_ns()
        ending = [(key, self.ends_ns(key)) for key in self._keys.values() if self.good(key.id)]
        left = [(key, (ends - now_ns) / 1e9) for key, ends in ending if ends is not None]
        return tuple(sorted((e for e in left if e[1] <= within_s), key=lambda e: e[1]))

    def next_end_ns(self, after_ns: int) -> int | None:
        """Return when the next key ends by itself, wall clock; None if none does. Walks them."""
        keys = self._keys.values()
        ends = (self.ends_ns(key) for key in keys if key.revoked_ns is None)
        return min((end for end in ends if end is not None and end > after_ns), default=None)

    def state(self, key: AuthorisationKey) -> str:
        """Return a key's state in words, for a list."""
        if key.revoked_ns is not None:
            return said("taken back")
        ends_ns = self.ends_ns(key)
        if ends_ns is None:
            return words.ends_in(None)
        left_s = (ends_ns - self.time.wall_ns()) / 1e9
        if left_s <= 0:
            return said("ended")
        return words.replaced_for(left_s) if self.is_replaced(key.id) else words.ends_in(left_s)

    def is_replaced(self, key_id: KeyId) -> bool:
        """Whether a newer key took the place of this one, beside which it is good for a while."""
        return key_id in self._ends

    # ---- decisions: nothing changes until the records are applied ----

    def issue(
        self,
        principal: PrincipalId,
        by: PrincipalId,
        *,
        scopes: tuple[str, ...] = (),
        lasts_s: float | None = None,
    ) -> tuple[AuthorisationKey, tuple[Record, ...]]:
        """Return another key for somebody, and what makes it good.

        Args:
            principal: Whose.
            by: Who gives it.
            scopes: Narrow the roles; empty for no narrowing.
            lasts_s: Greater than 0; None until revoked.

        Raises:
            OutOfBounds: A time that is none. Nothing changed.
        """
        if lasts_s is not None and not 0 < lasts_s < float("inf"):
            raise OutOfBounds(said("A key lasts longer than no time. Nothing was done."))
        now_ns = self.time.wall_ns()
        ends_ns = None if lasts_s is None else now_ns + int(lasts_s * 1e9)
        key = self._new(principal, by, scopes, ends_ns)
        return key, (self._decided("issue-key", by, key.id), KeyIssued(key=key))

    def rotate(self, principal: PrincipalId, by: PrincipalId, *, grace_s: float = 0.0) -> Rotation:
        """Return a new key in place of the current one.

        Args:
            principal: Whose.
            by: Who replaces it.
            grace_s: How long the old one stays good beside the new one; 0 ends it at once.

        Raises:
            NotUnderstood: There is no good key. Nothing changed.
            OutOfBounds: A grace of more than 30 days, or less than none. Nothing changed.
        """
        if not 0 <= grace_s <= GRACE_MAX_S:
            raise OutOfBounds(said("An old key stays good for at most 30 days. Nothing was done."))
        old = self.current(principal)
        if old is None:
            raise NotUnderstood(words.NOTHING_TO_ROTATE)
        now_ns = self.time.wall_ns()
        new = self._new(principal, by, old.scopes, self.ends_ns(old))
        ended: Record = KeyRevoked(key=old.id, by=by, at_ns=now_ns)
        if grace_s > 0:
            end = KeyEnd(by, now_ns + int(grace_s * 1e9))
            ended = Fact(kind=KIND, key=old.id, body=_encode(end))
        records = (self._decided("rotate-key", by, old.id), KeyIssued(key=new), ended)
        return Rotation(new, old.id, grace_s, records)

    def revoke(self, key_id: KeyId, by: PrincipalId) -> Revocation:
        """Return what takes a key back, for ever.

        Raises:
            NotUnderstood: There is no such key, or it was taken back before. Nothing changed.
        """
        key = self._keys.get(key_id)
        if key is None:
            raise NotUnderstood(words.NO_KEY)
        if key.revoked_ns is not None:
            raise NotUnderstood(words.KEY_GONE)
        revoked = KeyRevoked(key=key_id, by=by, at_ns=self.time.wall_ns())
        records = (self._decided("revoke-key", by, key_id), revoked)
        return Revocation(key_id, key.principal, records)

    def _new(
        self, principal: PrincipalId, by: PrincipalId, scopes: tuple[str, ...], ends_ns: int | None
    ) -> AuthorisationKey:
        return AuthorisationKey(
            id=f"k{self._entropy.token(RECORD_ID_BYTES).hex()}",
            principal=principal,
            issuer=by,
            issued_ns=self.time.wall_ns(),
            scopes=scopes,
            expires_ns=ends_ns,
        )

    def _decided(self, act: str, by: PrincipalId, about: str) -> Decided:
        return Decided(act=act, by=by, about=about, at_ns=self.time.wall_ns())

    # ---- state ----

    def restore(self, keys: Iterable[AuthorisationKey], facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for key in keys:
            self._add(key)
        for fact in facts:
            self.apply(fact)

    def apply(self, record: Record) -> None:
        """Let a record be so; those that are not about keys change nothing."""
        if isinstance(record, KeyIssued):
            self._add(record.key)
        elif isinstance(record, KeyRevoked):
            key = self._keys.get(record.key)
            if key is not None and key.revoked_ns is None:
                self._keys[key.id] = msgspec.structs.replace(key, revoked_ns=record.at_ns)
        elif isinstance(record, Fact) and record.kind == KIND:
            self._end(record)

    def _add(self, key: AuthorisationKey) -> None:
        if key.id not in self._keys:
            self._keys[key.id] = key
            self._of.setdefault(key.principal, []).append(key.id)

    def _end(self, fact: Fact) -> None:
        """Take over until when a replaced key is good; one that cannot be read ends it now."""
        if not fact.body:
            self._ends.pop(fact.key, None)
            return
        try:
            self._ends[fact.key] = _decode(fact.body).at_ns
        except msgspec.MsgspecError:
            _log.warning("the end of a replaced key cannot be read; it has ended")
            self._ends[fact.key] = 0
