"""Small data that is kept with a robot or with a person, and shared: the paper's storeData.

What is stored is added, never overwritten: the newest value of a name counts, and the ones before
it can be asked for. Names and values are sealed in the container of whoever keeps them.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import msgspec

from rosic.container import messages as words
from rosic.container.shared_data_access import LOAN, SharedDataAccess
from rosic.core.identity import RECORD_ID_BYTES, PrincipalId
from rosic.core.language.sanitise import clean, clean_name
from rosic.core.records import Fact, Letter
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, TooManyRequests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.contracts.clock import Clock, Entropy

KIND: Final = "shelf"
QUOTA: Final = "shelf-quota"
LONGEST_NAME: Final = 64
LONGEST_VALUE: Final = 1_000

Owner: TypeAlias = str
"""Whose container it is: a principal's or a robot's id."""

log = logging.getLogger("rosic.container")


class SharedDataQuota(msgspec.Struct, frozen=True):
    """What one container may keep.

    Attributes:
        names: Different names at once.
        history: Values of one name; the oldest goes when a further one comes.
        most_bytes: Of all values and names together.
    """

    names: int = 64
    history: int = 20
    most_bytes: int = 65_536


class SharedValue(msgspec.Struct, frozen=True, gc=False):
    """One value as it was stored.

    Attributes:
        sender: Who stored it.
        at_ns: Wall clock.
    """

    id: str
    owner: Owner
    name: str
    value: str
    sender: PrincipalId
    at_ns: int


class _Body(msgspec.Struct, frozen=True):
    owner: Owner
    sender: PrincipalId
    at_ns: int


class _Content(msgspec.Struct, frozen=True, array_like=True):
    name: str
    value: str


_encode = msgspec.msgpack.Encoder().encode
_read_body = msgspec.msgpack.Decoder(_Body).decode
_read_content = msgspec.msgpack.Decoder(_Content).decode
_read_quota = msgspec.msgpack.Decoder(SharedDataQuota).decode


class SharedDataRights(NamedTuple):
    """What the rest of the gateway says of owners; see I18: who decides is never absent.

    Attributes:
        is_robot: Whether an owner is a robot.
        sees: Whether somebody may read a robot. Asked of robots alone.
        works_with: Whether somebody has a robot now, and so may store data with it.
        shown: How an owner is called.
    """

    is_robot: Callable[[Owner], bool]
    sees: Callable[[PrincipalId, Owner], bool]
    works_with: Callable[[PrincipalId, Owner], bool]
    shown: Callable[[Owner], str]


class SharedData:
    """What is kept, container by container: no answer about one looks into another (I11).

    Args:
        clock: Says when something was stored.
        entropy: Makes ids: a name must not be guessable from what stands in the open.
        rights: Decides who reads and who stores.
        quota: What one container may keep, where nothing else is said of it.

    Attributes:
        is_robot, sees, works_with, shown: See `SharedDataRights`.
        lending: Who lets whom read what of their own.
    """

    def __init__(
        self,
        clock: Clock,
        entropy: Entropy,
        rights: SharedDataRights,
        quota: SharedDataQuota | None = None,
    ) -> None:
        self.is_robot, self.sees, self.works_with, self.shown = rights
        self._clock = clock
        self._entropy = entropy
        self._quota = quota or SharedDataQuota()
        self._quotas: dict[Owner, SharedDataQuota] = {}
        self._kept: dict[Owner, dict[str, list[SharedValue]]] = {}
        self._sizes: dict[Owner, int] = {}
        self._at: dict[str, SharedValue] = {}
        self.lending = SharedDataAccess(clock, entropy, self._sees_robot)

    # ---- reading ----

    def may_read(self, reader: PrincipalId, owner: Owner) -> bool:
        """Whether somebody may read everything that an owner keeps."""
        return reader == owner or self._sees_robot(reader, owner)

    def _sees_robot(self, reader: PrincipalId, owner: Owner) -> bool:
        return self.is_robot(owner) and self.sees(reader, owner)

    def names(self, reader: PrincipalId, owner: Owner) -> tuple[SharedValue, ...]:
        """Return the newest value of every name, by name.

        Raises:
            NotPermitted: Not theirs to read.
        """
        self._check_read(reader, owner)
        return tuple(values[-1] for _, values in sorted(self._kept.get(owner, {}).items()))

    def latest(self, reader: PrincipalId, owner: Owner, name: str) -> SharedValue | None:
        """Return the newest value of a name, or None: getSharedData of Algorithm 5.

        Raises:
            NotPermitted: Not theirs to read.
        """
        found = self.history(reader, owner, name)
        return found[-1] if found else None

    def history(self, reader: PrincipalId, owner: Owner, name: str) -> tuple[SharedValue, ...]:
        """Return every value of a name that is still kept, the oldest first.

        Raises:
            NotPermitted: Not theirs to read.
        """
        name = clean_name(name)
        if not self.lending.may_read(reader, owner, name):
            self._check_read(reader, owner)
        return tuple(self._kept.get(owner, {}).get(name, ()))

    def _check_read(self, reader: PrincipalId, owner: Owner) -> None:
        if not self.may_read(reader, owner):
            raise NotPermitted(words.NOT_YOURS)

    def used(self, owner: Owner) -> tuple[int, int]:
        """Return how many names a container keeps, and how many bytes."""
        return len(self._kept.get(owner, ())), self._sizes.get(owner, 0)

    def quota(self, owner: Owner) -> SharedDataQuota:
        """Return what a container may keep."""
        return self._quotas.get(owner, self._quota)

    # ---- deciding ----

    def store(self, sender: PrincipalId, owner: Owner, name: str, value: str) -> tuple[Fact, ...]:
        """Decide on storing a value; of too many of one name the oldest goes.

        Raises:
            NotPermitted: Somebody else's container, or a robot that they do not have now.
            NotUnderstood, OutOfBounds: No name, no value, or too long a one.
            TooManyRequests: There is no room. Nothing has changed in any of these cases.
        """
        if not self._may_store(sender, owner):
            mine = self.is_robot(owner) and self.sees(sender, owner)
            shown = words.not_yours_to_keep(self.shown(owner)) if mine else words.NOT_YOURS
            raise NotPermitted(shown)
        name, value = _checked(name, value)
        quota, before = self.quota(owner), self._kept.get(owner, {}).get(name, [])
        if not before and len(self._kept.get(owner, ())) >= quota.names:
            sentence = words.too_many_names(self.shown(owner), quota.names)
            raise TooManyRequests(sentence, retry_after_s=0.0)
        oldest = before[: max(0, len(before) + 1 - max(quota.history, 1))]
        freed = sum(map(_size, oldest))
        more = len(name.encode()) + len(value.encode())
        if self._sizes.get(owner, 0) - freed + more > quota.most_bytes:
            sentence = words.shelf_full(self.shown(owner), quota.most_bytes)
            raise TooManyRequests(sentence, retry_after_s=0.0)
        fresh = Fact(
            kind=KIND,
            key=self._entropy.token(RECORD_ID_BYTES).hex(),
            body=_encode(_Body(owner, sender, self._clock.wall_ns())),
            letter=Letter(owner, _encode(_Content(name, value))),
        )
        return (*map(_no_more, oldest), fresh)

    def _may_store(self, sender: PrincipalId, owner: Owner) -> bool:
        if self.is_robot(owner):
            return self.sees(sender, owner) and self.works_with(sender, owner)
        return sender == owner

    def remove(self, sender: PrincipalId, owner: Owner, name: str) -> tuple[Fact, ...]:
        """Decide on removing every value of a name.

        Raises:
            NotPermitted: As for storing.
            NotUnderstood: There is nothing of that name.
        """
        self._check_read(sender, owner)
        if not self._may_store(sender, owner):
            raise NotPermitted(words.not_yours_to_keep(self.shown(owner)))
        found = self._kept.get(owner, {}).get(clean_name(name))
        if not found:
            raise NotUnderstood(words.nothing_kept(self.shown(owner), name))
        return (*map(_no_more, found), *self.lending.end_name(owner, clean_name(name)))

    def limit(self, owner: Owner, quota: SharedDataQuota) -> tuple[Fact, ...]:
        """Decide on what one container may keep; the others are not touched."""
        return (Fact(kind=QUOTA, key=owner, body=_encode(quota)),)

    def end_all(self, principal: PrincipalId) -> tuple[Fact, ...]:
        """Return what removes everything of somebody: what they keep, stored, lent and borrowed."""
        gone = [kept for kept in self._at.values() if principal in {kept.owner, kept.sender}]
        loans = self.lending.end_all(principal)
        limits = [Fact(kind=QUOTA, key=principal, body=b"")] if principal in self._quotas else []
        return (*map(_no_more, gone), *loans, *limits)

    # ---- what is so ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read is left out."""
        try:
            if fact.kind == KIND:
                self._apply_kept(fact)
            elif fact.kind == LOAN:
                self.lending.apply(fact)
            elif fact.body:
                self._quotas[fact.key] = _read_quota(fact.body)
            else:
                self._quotas.pop(fact.key, None)
        except msgspec.MsgspecError:
            log.warning("a %s cannot be read; it is left out", fact.kind)

    def _apply_kept(self, fact: Fact) -> None:
        self._drop(fact.key)
        if not fact.body or fact.letter is None:
            return  # removed, or erased
        body, content = _read_body(fact.body), _read_content(fact.letter.content)
        kept = SharedValue(
            fact.key, body.owner, content.name, content.value, body.sender, body.at_ns
        )
        self._at[kept.id] = kept
        self._kept.setdefault(kept.owner, {}).setdefault(kept.name, []).append(kept)
        self._sizes[kept.owner] = self._sizes.get(kept.owner, 0) + _size(kept)

    def _drop(self, key: str) -> None:
        kept = self._at.pop(key, None)
        if kept is None:
            return
        names = self._kept[kept.owner]
        names[kept.name].remove(kept)
        if not names[kept.name]:
            del names[kept.name]
        self._sizes[kept.owner] -= _size(kept)
        if not names:
            del self._kept[kept.owner], self._sizes[kept.owner]


def _checked(name: str, value: str) -> tuple[str, str]:
    """Return a name and a value as they are kept.

    Raises:
        NotUnderstood, OutOfBounds: They cannot be.
    """
    if len(name.strip()) > LONGEST_NAME:
        raise OutOfBounds(words.too_long(words.NAME, LONGEST_NAME))
    name, value = clean_name(name), clean(value).strip()
    if not name:
        raise NotUnderstood(words.NAME_EMPTY)
    if not value:
        raise NotUnderstood(words.VALUE_EMPTY)
    if len(value) > LONGEST_VALUE:
        raise OutOfBounds(words.too_long(words.VALUE, LONGEST_VALUE))
    return name, value


def _size(kept: SharedValue) -> int:
    return len(kept.name.encode()) + len(kept.value.encode())


def _no_more(kept: SharedValue) -> Fact:
    return Fact(kind=KIND, key=kept.id, body=b"")
