"""Who is known, at which address, under which key. In memory; the record is the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import OPERATOR, PAGE
from rosic.core.language import clean_name

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.identity import Address, AuthorisationKey, KeyId, Principal, PrincipalId


# Who acts without being anybody: the owner of the machine, and the rules about misuse.
NOT_PEOPLE = {OPERATOR: said("the operator"), "rule": said("a rule")}

SOMEBODY = said("somebody")


class Directory:
    """Everybody, by id, by address and by name.

    Each principal has one current key: the newest that is not revoked.

    Attributes:
        narrowed: Keys that reach less than their principal's rights do.
    """

    def __init__(self) -> None:
        self.narrowed: set[KeyId] = set()
        self._people: dict[PrincipalId, Principal] = {}
        self._keys: dict[KeyId, AuthorisationKey] = {}
        self._current: dict[PrincipalId, AuthorisationKey] = {}
        self._at: dict[tuple[str, str], PrincipalId] = {}
        # By the hash of a name, and most names are one person's: it is there for each of thousands.
        self._named: dict[int, PrincipalId | dict[PrincipalId, None]] = {}

    def enrol(self, person: Principal) -> None:
        """Add or replace a person."""
        before = self._people.get(person.id)
        for address in before.addresses if before else ():
            where = address.platform, address.account
            if self._at.get(where) == person.id:  # else it has become somebody else's
                del self._at[where]
        if before is not None:
            self._forget_name(before)
        self._remember_name(person)
        self._people[person.id] = person
        for address in person.addresses:
            self._at[address.platform, address.account] = person.id

    def add_key(self, key: AuthorisationKey) -> None:
        """Add a key; it becomes its principal's current one unless it is revoked."""
        self._keys[key.id] = key
        if key.scopes:
            self.narrowed.add(key.id)
        current = self._current.get(key.principal)
        if current is None or current.revoked_ns is not None or key.revoked_ns is None:
            self._current[key.principal] = key

    def revoke(self, key_id: KeyId, at_ns: int) -> AuthorisationKey | None:
        """Mark a key revoked, for ever; return it, or None if there is no such key."""
        key = self._keys.get(key_id)
        if key is None:
            return None
        revoked = msgspec.structs.replace(key, revoked_ns=at_ns)
        self._keys[key_id] = revoked
        if self._current.get(key.principal) == key:
            self._current[key.principal] = revoked
        return revoked

    def at(self, address: Address) -> tuple[Principal, AuthorisationKey] | None:
        """Return who is at an address, and their current key."""
        principal = self._at.get((address.platform, address.account))
        if principal is None and address.platform == PAGE and address.account in self._people:
            principal = address.account
        if principal is None:
            return None
        key = self._current.get(principal)
        return (self._people[principal], key) if key is not None else None

    def person(self, principal: PrincipalId) -> Principal | None:
        """Return a person by id."""
        return self._people.get(principal)

    def named(self, name: str) -> tuple[Principal, ...]:
        """Return everybody who is shown under a name; for commands of the operator only."""
        wanted = name.casefold()
        ids = self._named.get(hash(wanted), {})
        found = (self._people[i] for i in ((ids,) if isinstance(ids, str) else ids))
        return tuple(person for person in found if person.name.casefold() == wanted)

    def called(self, typed: str) -> tuple[Principal, ...]:
        """Return everybody who is called so, or has that id; each once.

        An id is nobody's secret, and a name is its owner's to choose: one that is another's id must
        not decide who is meant.
        """
        name, by_id = clean_name(typed), self.person(typed)
        found = (() if by_id is None else (by_id,), self.named(name) if name else ())
        return tuple({person.id: person for some in found for person in some}.values())

    def _remember_name(self, person: Principal) -> None:
        name = hash(person.name.casefold())
        there = self._named.get(name)
        if there is None:
            self._named[name] = person.id
        elif isinstance(there, dict):
            there[person.id] = None
        else:
            self._named[name] = {there: None, person.id: None}

    def _forget_name(self, person: Principal) -> None:
        name = hash(person.name.casefold())
        there = self._named[name]
        if isinstance(there, dict):
            del there[person.id]
        else:
            del self._named[name]

    def name(self, principal: PrincipalId) -> str:
        """Return how a person is shown."""
        person = self._people.get(principal)
        if person is not None:
            return person.name
        return NOT_PEOPLE.get(principal, SOMEBODY)

    def is_program(self, principal: PrincipalId) -> bool:
        """Whether somebody is a program that is known here."""
        person = self._people.get(principal)
        return person is not None and person.is_program

    def people(self) -> Iterable[Principal]:
        """Return everybody."""
        return self._people.values()

    def key(self, key_id: KeyId) -> AuthorisationKey | None:
        """Return a key by id."""
        return self._keys.get(key_id)

    def keys(self) -> Iterable[AuthorisationKey]:
        """Return every key that was ever given."""
        return self._keys.values()

    def has_good_key(self, principal: PrincipalId) -> bool:
        """Whether somebody's key is not revoked."""
        key = self._current.get(principal)
        return key is not None and key.revoked_ns is None

    def key_of(self, principal: PrincipalId) -> AuthorisationKey | None:
        """Return a principal's current key."""
        return self._current.get(principal)
