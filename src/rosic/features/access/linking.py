"""A code for another account comes in: from then on that account is whoever was given the code."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser import link_messages as words
from rosic.core.identity import OPERATOR
from rosic.core.message import Button
from rosic.errors import NotPermitted, RecordUnavailable
from rosic.features.access.admin_policy import PEOPLE, sure
from rosic.features.access.messages import NOT_WRITTEN
from rosic.gateway.commands import Reply
from rosic.gateway.delivery.notifier import Notification

if TYPE_CHECKING:
    from rosic.authoriser.account_links import AccountChange
    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import Address, Principal, PrincipalId
    from rosic.core.message import Inbound
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.delivery.notifier import AccountChat

UNLINK: Final = "unlink"
TAKE_AWAY_S: Final = 600.0
"""For so long whoever reads that an account was linked can take it away by a tap."""


def agreed_to(principal: PrincipalId, address: Address) -> bytes:
    """Return what a button agrees to that takes an account away."""
    return sure(UNLINK, principal, str(address))


def take_away_button(principal: PrincipalId, address: Address) -> Button:
    """Return the button that takes an account of somebody away."""
    return Button(
        words.TAKE_AWAY,
        f"/{UNLINK} {principal} {address}",
        act=agreed_to(principal, address),
        good_for_ns=int(TAKE_AWAY_S * 1e9),
    )


class AccountNotices:
    """Tells a person in all of their chats, and the admins, what became of an account."""

    def __init__(self, registry: AccessContext, admin_policy: AdminPolicy) -> None:
        self._registry, self._admin_policy = registry, admin_policy

    def places(self, principal: PrincipalId) -> tuple[AccountChat, ...]:
        """Return where each account of somebody is reached now."""
        return self._registry.reach.places(principal)

    def linked(self, change: AccountChange, before: tuple[AccountChat, ...]) -> None:
        """An account was linked: said in every other one, with the way back, and to admins."""
        person, shown = change.person, words.account_shown(change.address)
        notice = Notification(
            text=words.linked_there(shown),
            buttons=((take_away_button(person.id, change.address),),),
            urgent=True,
            lifetime_s=TAKE_AWAY_S,
            still=True,
        )
        self._registry.reach.give_at(person.id, before, notice)
        self._admins(person, "", words.linked_of(person.name, shown))

    def unlinked(
        self,
        change: AccountChange,
        before: tuple[AccountChat, ...],
        by: PrincipalId,
        asked_in: tuple[str, str] | None,
    ) -> None:
        """An account was taken away: said in it, in every other one, and to admins.

        Args:
            change: What was done.
            before: Where each account was reached before it.
            by: Who did it.
            asked_in: Messenger and chat where they did it and read the answer.
        """
        person, shown = change.person, words.account_shown(change.address)
        own, by_name = by == person.id, self._name(by)
        there = words.unlinked_there(shown) if own else words.unlinked_by(shown, by_name)
        for place in before:
            if (place.messenger.name, place.chat.id) == asked_in:
                continue
            lost = place.address == change.address
            text = words.unlinked_here(person.name) if lost else there
            notice = Notification(text=text, urgent=True)
            self._registry.reach.give_at(person.id, (place,), notice)
        self._admins(person, by, words.unlinked_of(by_name, person.name, shown))

    def code_used(self, principal: PrincipalId, address: Address) -> None:
        """A code of somebody came from an account that is somebody's."""
        text = words.code_used(words.account_shown(address))
        self._registry.reach.tell((principal,), text, urgent=True)

    def code_shown(self, principal: PrincipalId) -> None:
        """A code of somebody was shown in a group."""
        self._registry.reach.tell((principal,), words.CODE_SHOWN, urgent=True)

    def _admins(self, person: Principal, by: PrincipalId, text: str) -> None:
        others = [who for who in self._admin_policy.holders(PEOPLE, besides=by) if who != person.id]
        self._registry.reach.tell(others, text, urgent=True)

    def _name(self, by: PrincipalId) -> str:
        return words.THE_OPERATOR if by == OPERATOR else self._registry.name(by)


class AccountLinking:
    """Takes codes for another account, before anybody is recognised."""

    def __init__(self, registry: AccessContext, admin_policy: AdminPolicy) -> None:
        self._registry = registry
        self._links = registry.links
        self._notices = AccountNotices(registry, admin_policy)

    def is_code(self, code: str) -> bool:
        """Whether a code links an account; looks at it, and does not use it up."""
        return self._links.find(code) is not None

    async def take(self, messenger: Messenger, inbound: Inbound, code: str) -> Reply:
        """Link the account that says a good code in a private chat.

        All of it is written before it is so, or nothing changes; the code is used up.

        Raises:
            Refusal: The account is somebody's already. Nothing changed.
        """
        whose = self._links.find(code)
        if whose is None:
            raise NotPermitted(words.NO_CODE)
        before = self._notices.places(whose.principal)
        try:
            async with self._registry.changes.turn() as turn:
                change = self._links.redeem(code, inbound.sender)
                await turn.write(change.records)
        except RecordUnavailable:
            return Reply(NOT_WRITTEN)
        except NotPermitted:
            if self._links.find(code) is None:
                self._notices.code_used(whose.principal, inbound.sender)
            raise
        self._registry.reach.last_accounts.heard(messenger, inbound, whose.principal)
        self._notices.linked(change, before)
        return self._linked_here(inbound, change)

    def _linked_here(self, inbound: Inbound, change: AccountChange) -> Reply:
        person, here = change.person, change.address
        button = take_away_button(person.id, here)
        bound = self._registry.authoriser.buttons.issue(
            button, person.id, inbound.chat.id, still=True
        )
        shown = words.accounts_shown(person.addresses, here)
        return Reply(words.linked_here(person.name, shown), ((bound,),))

    def burn(self, codes: tuple[str, ...]) -> bool:
        """Let codes be good no more that a group was shown; whether there was one."""
        burnt = [one for one in map(self._links.burn, codes) if one is not None]
        for one in burnt:
            self._notices.code_shown(one.principal)
        return bool(burnt)
