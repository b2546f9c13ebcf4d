"""``/grant Cy operator kuka1 for 2h``: a right for somebody who is in already, for a while."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rosic.core.i18n import joined
from rosic.core.identity import RECORD_ID_BYTES
from rosic.core.language.sanitise import LONGEST_NAME
from rosic.core.message import Button
from rosic.core.policy.roles import Grant
from rosic.core.time_units import SECOND_NS
from rosic.errors import Expired, NotPermitted, NotUnderstood
from rosic.features.access import messages, request_messages
from rosic.features.access.admin_policy import PersonNames, asked_again, sure
from rosic.features.access.invite import read_grant
from rosic.gateway.commands import Reply, asks_first, check_private
from rosic.gateway.person_argument import which_person
from rosic.gateway.replies import LEAVE
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.authoriser.invitations import InvitedRights
    from rosic.contracts.clock import Entropy
    from rosic.core.identity import Principal, PrincipalId
    from rosic.core.records import Record
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext
    from rosic.organiser.timezones import Zone

BACK = "back"
# Only ids of grants may follow: somebody may be called "Back".
_BACK = re.compile(rf"{BACK}(?: g[0-9a-f]{{16}})+")
_LONGEST_NAME = LONGEST_NAME // 2 + 1
"""In words: there is a sign at least between any two."""


class GrantCommands:
    """Gives rights, takes single ones back, and tells when one has ended.

    Args:
        registry: Who knows people.
        admin_policy: Who may give what.
        entropy: For ids.
        zone_of: Returns the zone whose clocks somebody reads.
    """

    def __init__(
        self,
        registry: AccessContext,
        admin_policy: AdminPolicy,
        entropy: Entropy,
        zone_of: Callable[[PrincipalId], Zone],
    ) -> None:
        self._registry = registry
        self._admin_policy = admin_policy
        self._entropy = entropy
        self._zone_of = zone_of
        self._names = PersonNames(registry)

    def granted(
        self, principal: PrincipalId, given: InvitedRights, until_ns: int | None, by: PrincipalId
    ) -> tuple[tuple[Grant, ...], tuple[Record, ...]]:
        """Return grants, and the records that give them.

        Raises:
            NotUnderstood: They have too many rights already; nothing changed.
        """
        ids = iter(lambda: f"g{self._entropy.token(RECORD_ID_BYTES).hex()}", "")
        grants = tuple(
            Grant(
                id=next(ids),
                role=role,
                robots=given.robots,
                limits=given.limits,
                expires_ns=until_ns,
            )
            for role in given.roles
        )
        if given.scopes:
            bare = Grant(
                id=next(ids), scopes=given.scopes, limits=given.limits, expires_ns=until_ns
            )
            grants = (*grants, bare)
        return grants, self._registry.grants_book.give(principal, grants, by)

    # ---- giving ----

    async def grant(self, asked: CommandContext) -> Reply:
        """Give somebody a right, or take a single one back.

        Raises:
            Refusal: Not theirs to give, not understood, or others read along.
        """
        check_private(asked)
        by, rest = asked.caller.principal, asked.rest.strip()
        self._check_gives(by)
        if not rest:
            return self._how()
        if _BACK.fullmatch(rest):
            return await self._take_back(by, rest.split()[1:])
        return await self._give(asked, rest)

    def _how(self) -> Reply:
        rights = self._registry.rights()
        roles = tuple(rights.rulebook.roles)
        role = "operator" if "operator" in roles else next(iter(roles), "viewer")
        return Reply(request_messages.how_to_grant(role, next(iter(rights.fleet.skills), "")))

    def _check_gives(self, by: PrincipalId) -> None:
        """See that somebody gives rights at all: nobody else learns who is who here.

        Raises:
            NotPermitted: They do not.
        """
        self._admin_policy.check_not_locked(by)
        if not self._admin_policy.gives(by):
            raise NotPermitted(request_messages.not_yours(self._admin_policy.helpers(by)))

    async def _give(self, asked: CommandContext, said: str) -> Reply:
        found, rest = self._whom(asked, said)
        if isinstance(found, Reply):
            return found
        by = asked.caller.principal
        given = read_grant(rest, self._registry.rights())
        if found.id == by:
            raise NotPermitted(request_messages.not_to_yourself())
        self._admin_policy.check_give(by, given)
        agreed = sure(self._registry.rights().policy, "grant", found.id, found.name, rest)
        if given.lasts_s is None and asked.act != agreed:
            yes = Button(request_messages.give_label(), f"/grant {found.id} {rest}", act=agreed)
            question = request_messages.give_question(found.name, given.words)
            return asks_first(
                asked_again(asked.act, question), ((yes, Button(messages.LEAVE_IT, LEAVE)),)
            )
        grants = await self._write(by, found, given)
        return self._told(by, found, grants)

    async def _write(
        self, by: PrincipalId, person: Principal, given: InvitedRights
    ) -> tuple[Grant, ...]:
        lasts_s, now_ns = given.lasts_s, self._registry.clock.wall_ns()
        until_ns = None if lasts_s is None else now_ns + int(lasts_s * SECOND_NS)
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check_give(by, given)
            if not self._admin_policy.acts(person.id):
                raise NotPermitted(request_messages.no_access(person.name))
            grants, records = self.granted(person.id, given, until_ns, by)
            await turn.write(records)
        return grants

    def _told(self, by: PrincipalId, person: Principal, grants: tuple[Grant, ...]) -> Reply:
        name, tell = self._registry.name(by), self._registry.reach.tell
        tell((person.id,), request_messages.was_given(name, self.said(grants, person.id)))
        for other in self._admin_policy.givers_of(grants, besides=person.id):
            if other != by:
                text = request_messages.was_given_to(name, person.name, self.said(grants, other))
                tell((other,), text)
        text = request_messages.gave(person.name, self.said(grants, by))
        return Reply(text, ((self.take_button(grants),),))

    def _whom(self, asked: CommandContext, said: str) -> tuple[Principal | Reply, str]:
        """Return who is meant by the first words, and the rest of the line.

        Where more than one beginning of the line is a name, it is asked which: somebody may be
        called "Bo operator", and another Bo.

        Raises:
            NotUnderstood: Nobody.
        """
        low = said.split()
        by_id = self._registry.authoriser.directory.person(low[0])
        if by_id is not None and asked.act:
            return by_id, " ".join(low[1:])
        found: list[tuple[Principal, str]] = []
        for count in range(min(len(low), _LONGEST_NAME), 0, -1):
            name, rest = " ".join(low[:count]), " ".join(low[count:])
            if len(name) > LONGEST_NAME:
                continue
            named = self._names.called(name)
            fitting = tuple(filter(self._has_access, named)) or named
            found += [(person, rest) for person in fitting]
        if not found:
            raise NotUnderstood(messages.nobody_called(low[0]))
        found = [one for one in found if one[1]] or found  # a name alone gives nothing
        if len(found) == 1:
            return found[0]
        rows = [(person, f"/grant {person.id} {rest}", rest) for person, rest in found]
        return which_person(asked, low[0], rows), ""

    def _has_access(self, person: Principal) -> bool:
        return self._admin_policy.acts(person.id)

    # ---- taking back ----

    def take_button(self, grants: tuple[Grant, ...]) -> Button:
        """Return the button that takes back what was just given."""
        ids = " ".join(grant.id for grant in grants)
        return Button(request_messages.take_label(), f"/grant {BACK} {ids}")

    async def _take_back(self, by: PrincipalId, ids: list[str]) -> Reply:
        book = self._registry.grants_book
        held = [one for one in map(book.holder, ids) if one is not None]
        if not held:
            raise Expired(request_messages.gone())
        principal, grants = held[0][0], tuple(grant for _, grant in held)
        if by not in self._admin_policy.givers_of(grants, besides=principal):
            raise NotPermitted(request_messages.not_yours(self._admin_policy.helpers(by)))
        taken = [book.take_one(principal, grant.id, by) for grant in grants]
        await self._registry.changes.take_away(record for some in taken for record in some)
        name, who = self._registry.name(by), self._registry.name(principal)
        told = request_messages.was_taken(name, self.said(grants, principal))
        self._registry.reach.tell((principal,), told)
        return Reply(request_messages.taken(who, self.said(grants, by)))

    # ---- the end ----

    def announce(self, ended: Iterable[tuple[PrincipalId, Grant]]) -> None:
        """Tell people what has ended by itself."""
        by_person: dict[PrincipalId, list[Grant]] = {}
        for principal, grant in ended:
            by_person.setdefault(principal, []).append(grant)
        for principal, grants in by_person.items():
            if self._admin_policy.acts(principal):
                what = self._what(grants)
                self._registry.reach.tell((principal,), request_messages.has_ended(what))

    def said(self, grants: Iterable[Grant], reader: PrincipalId) -> str:
        """Return what was given, and until when on the reader's clocks."""
        grants = tuple(grants)
        what, ends_ns = self._what(grants), grants[0].expires_ns
        if ends_ns is None:
            return what
        now_ns = self._registry.clock.wall_ns()
        return request_messages.until(what, moment(ends_ns, now_ns, self._zone_of(reader)))

    def _what(self, grants: Iterable[Grant]) -> str:
        return joined("; ", (messages.grant(grant, grant.limits, "") for grant in grants))
