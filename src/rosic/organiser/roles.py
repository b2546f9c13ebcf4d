"""Roles of the place's own that were made in a chat, beside those of its file.

The file has the say: a role that it defines is never made, changed or taken back in a chat.
"""

from __future__ import annotations

import logging
from hashlib import blake2b
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.identity import DIGEST_BYTES
from rosic.core.policy.roles import Role, RoleRules
from rosic.core.records import Decided, Fact

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.core.identity import PrincipalId
    from rosic.core.records import Record

ROLE: Final = "role"
MOST_ROLES: Final = 64

log = logging.getLogger("rosic.organiser")


class CustomRoles:
    """The rules of the file, and the roles that chats have added to them.

    Attributes:
        file: What the file says, the default roles included.
        rulebook: Both together, as they are in force; replaced whole.
    """

    def __init__(self, file: RoleRules) -> None:
        self.file = file
        self.rulebook = file
        self._own: dict[str, Role] = {}
        self._told: set[str] = set()

    @property
    def own(self) -> Mapping[str, Role]:
        """Return the roles that were made in a chat and count."""
        return {name: role for name, role in self._own.items() if name not in self.file.roles}

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> None:
        """Let a fact be so. One that cannot be read gives nothing."""
        if fact.body:
            try:
                self._own[fact.key] = msgspec.msgpack.decode(fact.body, type=Role)
            except msgspec.MsgspecError:
                log.warning("a role cannot be read; it gives nothing")
                self._own.pop(fact.key, None)
        else:
            self._own.pop(fact.key, None)
        if fact.key in self.file.roles and fact.key not in self._told:
            self._told.add(fact.key)
            log.warning("the role %s was made in a chat; the file's counts now", fact.key)
        self.rulebook = self._with(self.own)

    def made(self, name: str, role: Role) -> RoleRules:
        """Return the rules as they would be with a role; nothing changes."""
        return self._with({**self.own, name: role})

    def taken(self, name: str) -> RoleRules:
        """Return the rules as they would be without a role; nothing changes."""
        return self._with({known: role for known, role in self.own.items() if known != name})

    def make(self, name: str, role: Role, by: PrincipalId, at_ns: int) -> tuple[Record, ...]:
        """Return the records that make a role, or replace one of that name."""
        return _records("role", Fact(kind=ROLE, key=name, body=_encode(role)), by, at_ns)

    def take(self, name: str, by: PrincipalId, at_ns: int) -> tuple[Record, ...]:
        """Return the records that take a role back."""
        return _records("unrole", Fact(kind=ROLE, key=name, body=b""), by, at_ns)

    def _with(self, own: Mapping[str, Role]) -> RoleRules:
        return msgspec.structs.replace(self.file, roles={**own, **self.file.roles})


_encode = msgspec.msgpack.Encoder().encode


def _records(act: str, fact: Fact, by: PrincipalId, at_ns: int) -> tuple[Record, ...]:
    digest = blake2b(fact.body, digest_size=DIGEST_BYTES).digest()
    return Decided(act=act, by=by, about=fact.key, at_ns=at_ns, digest=digest), fact
