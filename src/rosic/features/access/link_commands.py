"""``/link``: a code for another account. ``/unlink``: an account goes, one's own or another's."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.authoriser import link_messages as words
from rosic.authoriser.account_links import CODE_NS
from rosic.contracts.messenger import invite_link_of
from rosic.core.i18n import joined
from rosic.core.message import Button
from rosic.core.time_units import SECOND_NS
from rosic.errors import NotPermitted, NotUnderstood
from rosic.features.access import messages
from rosic.features.access.admin_policy import PEOPLE, PersonNames, asked_again
from rosic.features.access.linking import UNLINK, AccountNotices, agreed_to, take_away_button
from rosic.gateway.commands import Reply, asks_first, check_private
from rosic.gateway.replies import LEAVE
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.identity import Address, Principal, PrincipalId
    from rosic.core.records import Record
    from rosic.core.secret import Secret
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext
    from rosic.organiser.access_requests import AccessRequests


class AccountArgument(NamedTuple):
    """Whose account somebody speaks of, and which; None: they did not say."""

    person: Principal
    address: Address | None


class AccountLinkCommands:
    """Gives codes for another account, and takes accounts away.

    Args:
        wanted: Rights that are asked for; whoever has an account may have asked in its name.
    """

    def __init__(
        self, registry: AccessContext, admin_policy: AdminPolicy, wanted: AccessRequests
    ) -> None:
        self._registry, self._admin_policy, self._wanted = registry, admin_policy, wanted
        self._links = registry.links
        self._directory = registry.authoriser.directory
        self._names = PersonNames(registry)
        self._notices = AccountNotices(registry, admin_policy)

    # ---- linking ----

    async def link(self, asked: CommandContext) -> Reply:
        """Give a code to somebody who asks in their own chat.

        Raises:
            Refusal: Others read along, it was asked long ago, they are locked, a code of their
                phone has to come first, or they speak from no account of a messenger.
        """
        check_command_fresh(asked.inbound, "/link")
        if not asked.private:
            raise NotPermitted(words.IN_GROUP)
        caller, two_factor = asked.caller, self._registry.two_factor
        self._admin_policy.check_not_locked(caller.principal)
        if asked.rest.strip():
            return Reply(words.SAY_IT_THERE)
        if two_factor.is_set_up(caller.principal):
            two_factor.use(caller.principal, asked.inbound.chat)
        code = self._links.offer(caller)
        told = [words.code(code.reveal(), CODE_NS / SECOND_NS), *self._links_to_open(code)]
        return Reply(joined("\n", told))

    def _links_to_open(self, code: Secret) -> Iterator[str]:
        for messenger in self._registry.reach.messengers:
            if link := invite_link_of(messenger, code):
                yield words.link_to_open(messenger.platform, link)

    # ---- taking away ----

    async def unlink(self, asked: CommandContext) -> Reply:
        """Take an account away, after asking once: one's own, or, as an admin, somebody's.

        Raises:
            Refusal: Others read along, not theirs to do, no such account, or the last one.
        """
        check_private(asked)
        by = asked.caller.principal
        self._admin_policy.check_not_locked(by)
        meant = self._meant(asked, asked.rest.strip())
        if isinstance(meant, Reply):
            return meant
        person, address = meant
        if address is None:
            return self._which(asked, person)
        self._check(person.id, address, by)
        agreed = agreed_to(person.id, address)
        if asked.act != agreed:
            shown = words.account_shown(address)
            own = words.sure_of_own(shown)
            question = own if person.id == by else words.sure_of(person.name, shown)
            row = (take_away_button(person.id, address), Button(messages.LEAVE_IT, LEAVE))
            return asks_first(asked_again(asked.act, question), (row,))
        return await self._take_away(asked, person, address)

    async def _take_away(self, asked: CommandContext, person: Principal, address: Address) -> Reply:
        """Take it away at once, whoever holds the turn: somebody else's write may hang."""
        by, before = asked.caller.principal, self._notices.places(person.id)
        change = self._links.unlink(person.id, address, by)

        wanted = self._wanted

        def again() -> tuple[Record, ...]:
            there = self._links.has(person.id, address)
            records = self._links.unlink(person.id, address, by).records if there else ()
            return (*records, *wanted.lapse_all(person.id))

        records = (*change.records, *wanted.lapse_all(person.id))
        written = await self._registry.changes.take_away(records, again)
        asked_in = asked.messenger.name, asked.inbound.chat.id
        self._notices.unlinked(change, before, by, asked_in)
        shown = words.account_shown(address)
        return Reply(messages.noted(words.unlinked(shown), written=written))

    def _check(self, principal: PrincipalId, address: Address, by: PrincipalId) -> None:
        if principal != by:
            self._admin_policy.check(by, PEOPLE)
        self._links.check(principal, address)

    def _which(self, asked: CommandContext, person: Principal) -> Reply:
        """Ask which account is meant, with a button for each; or say that there is only one."""
        own, addresses = person.id == asked.caller.principal, person.addresses
        if own and len(addresses) == 1:
            return Reply(words.only_one(words.account_shown(addresses[0])))
        if len(addresses) < 2:  # noqa: PLR2004 - then none can be taken away
            raise NotPermitted(words.LAST)
        shown = words.accounts_shown(addresses, asked.caller.address)
        text = words.which_account(shown) if own else words.which_account_of(person.name, shown)
        rows = tuple(
            (Button(words.account_shown(one), f"/{UNLINK} {person.id} {one}"),) for one in addresses
        )
        return asks_first(text, rows)

    # ---- which is meant ----

    def _meant(self, asked: CommandContext, typed: str) -> AccountArgument | Reply:
        """Return whose account is meant, and which.

        One's own is named by its messenger, or as it is listed; somebody else's after their name.
        """
        own = self._directory.person(asked.caller.principal)
        if own is None:
            raise NotUnderstood(words.NOT_THEIRS)
        if not typed:
            return AccountArgument(own, None)
        if (address := _account_of(own, typed)) is not None:
            return AccountArgument(own, address)
        name, _, last = typed.rpartition(" ")
        if name == own.id:
            return self._in(own, last)
        self._admin_policy.check(asked.caller.principal, PEOPLE)
        return self._somebodys(asked, typed)

    def _somebodys(self, asked: CommandContext, typed: str) -> AccountArgument | Reply:
        whole = self._names.called(typed)
        if whole:
            found = self._names.find(asked, typed, UNLINK, _has_several)
            return found if isinstance(found, Reply) else AccountArgument(found, None)
        name, _, last = typed.rpartition(" ")
        named = self._directory.person(name)
        found = named or self._names.find(asked, name or typed, UNLINK, _has_several)
        return found if isinstance(found, Reply) else self._in(found, last)

    def _in(self, person: Principal, typed: str) -> AccountArgument:
        """Return an account of somebody by what was typed of it.

        Raises:
            NotUnderstood: They have none that is called so, or several.
        """
        address = _account_of(person, typed)
        if address is None:
            raise NotUnderstood(words.NOT_THEIRS)
        return AccountArgument(person, address)


def _account_of(person: Principal, typed: str) -> Address | None:
    """Return the one account of somebody that is called so: ``matrix``, ``matrix:@ada:lab``."""
    wanted = typed.casefold()
    whole = [one for one in person.addresses if str(one).casefold() == wanted]
    there = [one for one in person.addresses if one.platform == wanted]
    found = whole or there
    return found[0] if len(found) == 1 else None


def _has_several(person: Principal) -> bool:
    return len(person.addresses) > 1
