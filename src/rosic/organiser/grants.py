"""Who was given what besides their own roles: grants, each with an end of its own."""

from __future__ import annotations

import logging
from hashlib import blake2b
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import DIGEST_BYTES, PrincipalId
from rosic.core.policy.roles import Grant, Role, RoleRules
from rosic.core.records import Decided, Fact
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.records import Record


# ---- roles ----

# Roles of the place's own that were made in a chat, beside those of its file.
#
# The file has the say: a role that it defines is never made, changed or taken back in a chat.

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


# ---- grants ----

OwnLimits: TypeAlias = "Callable[[PrincipalId], tuple[str, ...]]"

GRANT = "grant"
MOST = 64  # for one person; more are a role that nobody has named yet


class GivenGrant(msgspec.Struct, frozen=True):
    """The body of the fact: whose grant it is."""

    principal: PrincipalId
    grant: Grant


class Grants:
    """Everybody's roles and grants, as they are written down.

    Roles without end or bounds are the person's own; whatever ends or is bounded is a grant.

    Args:
        clock: Says when something was given.
        own_limits: Returns what somebody has set for themselves: a cap on their speed.
    """

    def __init__(self, clock: Clock, own_limits: OwnLimits) -> None:
        self.own_limits: Final = own_limits
        self._clock = clock
        self._roles: dict[PrincipalId, tuple[str, ...]] = {}
        self._grants: dict[PrincipalId, dict[str, Grant]] = {}

    def restore(self, facts: Iterable[Fact]) -> None:
        """Take over what earlier runs wrote."""
        for fact in facts:
            self.apply(fact)

    def apply(self, fact: Fact) -> PrincipalId | None:
        """Let a fact be so. Return whose rights changed; None if it cannot be read."""
        if not fact.body:
            for principal, grants in self._grants.items():
                if grants.pop(fact.key, None) is not None:
                    return principal
            return None
        try:
            given = msgspec.msgpack.decode(fact.body, type=GivenGrant)
        except msgspec.MsgspecError:
            log.warning("a grant cannot be read; it gives nothing")
            return None
        self._grants.setdefault(given.principal, {})[fact.key] = given.grant
        return given.principal

    def set_roles(self, principal: PrincipalId, roles: tuple[str, ...]) -> None:
        """Say which roles are somebody's own; none: they are nobody any more."""
        if roles:
            self._roles[principal] = roles
        else:
            self._roles.pop(principal, None)

    def forget(self, principal: PrincipalId) -> None:
        """Take everything from somebody, in memory: their key has ended."""
        self._roles.pop(principal, None)
        self._grants.pop(principal, None)

    def grants_of(self, principal: PrincipalId) -> tuple[Grant, ...]:
        """Return everything somebody holds, their own roles first, under their own limits."""
        own = [Grant(role=role) for role in self._roles.get(principal, ())]
        found = (*own, *self._grants.get(principal, {}).values())
        limits = self.own_limits(principal)
        if not limits:
            return found
        return tuple(
            msgspec.structs.replace(grant, limits=(*grant.limits, *limits)) for grant in found
        )

    def everybody(self) -> Mapping[PrincipalId, tuple[Grant, ...]]:
        """Return everybody's grants; walks everybody."""
        people = dict.fromkeys((*self._roles, *self._grants))  # named in the same order each time
        return {who: self.grants_of(who) for who in people}

    def next_end_ns(self, after_ns: int) -> int | None:
        """Return when the next grant ends, wall clock; None if none does. Walks everybody."""
        ends = [
            grant.expires_ns
            for grants in self._grants.values()
            for grant in grants.values()
            if grant.expires_ns is not None and grant.expires_ns > after_ns
        ]
        return min(ends, default=None)

    def over(self, now_ns: int) -> tuple[tuple[PrincipalId, Grant], ...]:
        """Return the grants that have ended and are not forgotten yet, and whose they were."""
        return tuple(
            (principal, grant)
            for principal, grants in self._grants.items()
            for grant in grants.values()
            if grant.expires_ns is not None and grant.expires_ns <= now_ns
        )

    def ended(self, now_ns: int) -> tuple[Fact, ...]:
        """Return what is to be written so that ended grants take no room any more."""
        return tuple(Fact(kind=GRANT, key=grant.id, body=b"") for _, grant in self.over(now_ns))

    def holder(self, grant: str) -> tuple[PrincipalId, Grant] | None:
        """Return a grant, by its id, and whose it is; walks everybody who was given any."""
        for principal, grants in self._grants.items():
            if grant in grants:
                return principal, grants[grant]
        return None

    def give(
        self, principal: PrincipalId, grants: Iterable[Grant], by: PrincipalId
    ) -> tuple[Record, ...]:
        """Return the records that give somebody more.

        Raises:
            NotUnderstood: They have too many grants already; nothing changed.
        """
        grants = tuple(grants)
        if len(self._grants.get(principal, {})) + len(grants) > MOST:
            raise NotUnderstood(
                said(
                    "That would be more than {most} separate rights for one person. Make a role of "
                    "them.",
                    most=MOST,
                )
            )
        now_ns = self._clock.wall_ns()
        decided = tuple(
            Decided(act="grant", by=by, about=principal, at_ns=now_ns, digest=grant.id.encode())
            for grant in grants
        )
        return (*decided, *(fact_of(principal, grant) for grant in grants))

    def take(self, principal: PrincipalId, by: PrincipalId) -> tuple[Record, ...]:
        """Return the records that take every grant from somebody; their own roles stay."""
        now_ns = self._clock.wall_ns()
        gone = [Fact(kind=GRANT, key=key, body=b"") for key in self._grants.get(principal, {})]
        return (Decided(act="ungrant", by=by, about=principal, at_ns=now_ns), *gone)

    def take_one(self, principal: PrincipalId, grant: str, by: PrincipalId) -> tuple[Record, ...]:
        """Return the records that take one grant from somebody."""
        now_ns = self._clock.wall_ns()
        decided = Decided(
            act="ungrant", by=by, about=principal, at_ns=now_ns, digest=grant.encode()
        )
        return decided, Fact(kind=GRANT, key=grant, body=b"")


def fact_of(principal: PrincipalId, grant: Grant) -> Fact:
    """Return a grant as it is written down."""
    return Fact(kind=GRANT, key=grant.id, body=msgspec.msgpack.encode(GivenGrant(principal, grant)))
