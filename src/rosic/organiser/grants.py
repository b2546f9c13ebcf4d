"""Who was given what besides their own roles: grants, each with an end of its own."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, TypeAlias

import msgspec

from rosic.core.i18n import said
from rosic.core.identity import PrincipalId
from rosic.core.policy.roles import Grant
from rosic.core.records import Decided, Fact
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.contracts.clock import Clock
    from rosic.core.records import Record

OwnLimits: TypeAlias = "Callable[[PrincipalId], tuple[str, ...]]"

GRANT = "grant"
MOST = 64  # for one person; more are a role that nobody has named yet

log = logging.getLogger("rosic.organiser")


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
