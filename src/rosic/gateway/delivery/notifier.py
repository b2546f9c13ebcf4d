"""Speaking to somebody who has not just asked: an admin, whoever's time is ending."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.authoriser.button_tokens import is_lasting
from rosic.contracts.chats import FindsPrivateChat, private_chat_of
from rosic.contracts.messenger import Messenger, handle_of
from rosic.contracts.traffic import is_connected
from rosic.core.i18n import said
from rosic.core.identity import PAGE
from rosic.core.message import AnswerState, Button, Chat, ChatKind, Outbound, SendPriority
from rosic.core.signal import Deferred
from rosic.errors import ChatNotBegun
from rosic.gateway.delivery.last_accounts import HeardAccount
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage
from rosic.gateway.delivery.translation import translated
from rosic.gateway.order_status import OrderMessage

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.authoriser.authoriser import Authoriser
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import Address, PrincipalId
    from rosic.errors import ChatGone
    from rosic.gateway.delivery.chat_queue import Item
    from rosic.gateway.delivery.last_accounts import LastAccounts
    from rosic.gateway.delivery.outbox import Outbox


# ---- speaking to somebody who has not asked ----


class AccountChat(NamedTuple):
    """Where one account of somebody can be told something in private."""

    messenger: Messenger
    chat: Chat
    address: Address

    @property
    def account(self) -> HeardAccount:
        """Return by which of ours it is heard."""
        return HeardAccount(self.messenger.name, self.address)


class Notification(msgspec.Struct, frozen=True, kw_only=True):
    """What somebody is told who did not ask.

    Attributes:
        buttons: Under it; bound to each person and chat, good once.
        urgent: It overtakes what is not.
        lifetime_s: How long the buttons are good.
        still: Nothing moves by any of them, so a gap in listening does not void them.
        instead_of: By messenger and chat, the message whose place it takes where it can be edited.
        landed: Hears through which messenger, in which chat, which message says it.
        matter: What it is about, so that a later run that says it again can offer the same anew;
            ids and numbers only. Without one, what offers a button is lost in a crash.
        cause: Id of the message of theirs because of which they are told; empty for none.
        state: What it comes to, for a program.
    """

    text: str
    buttons: tuple[tuple[Button, ...], ...] = ()
    urgent: bool = False
    lifetime_s: float = 60.0
    still: bool = False
    instead_of: Mapping[tuple[str, str], str] = msgspec.field(default_factory=dict)
    landed: Callable[[Messenger, Chat, str], None] | None = None
    matter: bytes = b""
    cause: str = ""
    state: AnswerState = AnswerState.FINAL


class Notifier:
    """Finds people's private chats, and speaks where each of them was last.

    Somebody with several accounts is told by the one they used last, if its messenger is connected;
    else by the one before it. Who was never heard is told by each of them. What a chat does not
    take is told by the others; see `UndeliverableHandler`.

    Attributes:
        messengers: Through which people are reached.
        last_accounts: By which accounts people spoke last.
        again: Returns what somebody is offered anew under what a later run says of a matter;
            nothing is offered until it is bound.

    Args:
        outbox: Keeps what is said over a crash.
    """

    def __init__(
        self,
        authoriser: Authoriser,
        chat_sender: ChatSender,
        messengers: Iterable[Messenger],
        outbox: Outbox,
        last_accounts: LastAccounts,
    ) -> None:
        self.last_accounts = last_accounts
        self._authoriser = authoriser
        self._chat_sender = chat_sender
        self.messengers = tuple(messengers)
        self._outbox = outbox
        self.again: Deferred[[PrincipalId, bytes], Notification | None] = Deferred(_nothing)

    def tell(
        self,
        people: Iterable[PrincipalId],
        text: str,
        buttons: tuple[tuple[Button, ...], ...] = (),
        *,
        urgent: bool = False,
        lifetime_s: float = 60.0,
        still: bool = False,
    ) -> int:
        """Tell each of them in private, where they were last. Return how many places.

        Buttons are bound to each person and chat, good once. An alarm, and whatever offers no
        button, is told over a crash too; an offer is not, as nobody could take it any more.

        Args:
            people: Whom; each once.
            text: What.
            buttons: Under it.
            urgent: It overtakes what is not.
            lifetime_s: How long the buttons are good.
            still: Nothing moves by any of them, so a gap in listening does not void them.
        """
        notice = Notification(
            text=text, buttons=buttons, urgent=urgent, lifetime_s=lifetime_s, still=still
        )
        return self.give(people, notice)

    def give(self, people: Iterable[PrincipalId], notice: Notification) -> int:
        """Tell each of them a notice in private. Return how many places that were."""
        return sum(
            self.give_at(principal, self._newest(principal, notice), notice)
            for principal in dict.fromkeys(people)
        )

    def give_at(
        self, principal: PrincipalId, places: Iterable[AccountChat], notice: Notification
    ) -> int:
        """Tell somebody a notice in these chats of theirs. Return how many that were."""
        count = 0
        weight = SendPriority.ALARM if notice.urgent else SendPriority.QUESTION
        offers = any(not is_lasting(button) for row in notice.buttons for button in row)
        lasts = notice.urgent or not offers or bool(notice.matter)
        for messenger, chat, _ in places:
            outbound = Outbound(
                chat=chat, text=notice.text, weight=weight, cause=notice.cause, state=notice.state
            )
            edit_of = notice.instead_of.get((messenger.name, chat.id), "")
            note = OutgoingMessage(messenger, outbound, edit_of=edit_of)
            self._offer(principal, note, notice)
            if lasts:
                self._outbox.say(principal, note, notice.matter)
            else:
                self._chat_sender.say(note)
            count += 1
        return count

    def dress(self, note: OutgoingMessage, matter: bytes) -> None:
        """Put under what is said again what can still be done about its matter."""
        notice = self.again(note.to, matter)
        if notice is not None:
            self._offer(note.to, note, notice)

    def is_program(self, principal: PrincipalId) -> bool:
        """Whether nobody reads what somebody is told: it is a program."""
        known = self._authoriser.directory.person(principal)
        return known is not None and known.is_program

    def read_by(self, who: PrincipalId) -> Catalogue | None:
        """Return what somebody reads; None: English."""
        return self._chat_sender.languages.of(who)

    def _offer(self, who: PrincipalId, note: OutgoingMessage, notice: Notification) -> None:
        """Put the buttons of a notice under a note, bound to its reader and chat."""
        messenger, chat = note.messenger_and_chat
        lifetime_ns = int(notice.lifetime_s * 1e9)
        issue = partial(self._authoriser.buttons.issue, lifetime_ns=lifetime_ns, still=notice.still)
        bound = tuple(
            tuple(b if is_lasting(b) else issue(b, who, chat.id) for b in row)
            for row in notice.buttons
        )
        offering = msgspec.structs.replace(note.outbound, buttons=bound)
        landed = None if notice.landed is None else partial(notice.landed, messenger, chat)
        note.offer(translated(offering, self._chat_sender.languages.of(who)), landed)

    def pass_on(
        self, people: Iterable[PrincipalId], text: str, besides: tuple[str, str], *, hops: int
    ) -> int:
        """Tell each of them what another chat could be told no more. Return how many places.

        Args:
            people: Whom; each once.
            text: What.
            besides: Messenger and chat that did not take it.
            hops: How often it was passed on, with this.
        """
        places = 0
        for principal in dict.fromkeys(people):
            catalogue = self._chat_sender.languages.of(principal)
            for messenger, chat, _ in self.places(principal):
                if (messenger.name, chat.id) == besides:
                    continue
                outbound = Outbound(chat=chat, text=text, weight=SendPriority.OUTCOME)
                note = OutgoingMessage(
                    messenger, translated(outbound, catalogue), to=principal, hops=hops
                )
                self._outbox.say(principal, note)
                places += 1
        return places

    def chats(self, principal: PrincipalId) -> tuple[tuple[Messenger, Chat], ...]:
        """Return where somebody can be told something in private, where they were last first."""
        return tuple((messenger, chat) for messenger, chat, _ in self.places(principal))

    def places(self, principal: PrincipalId) -> tuple[AccountChat, ...]:
        """Return where each account of somebody can be told something in private.

        The newest first, and at the end where they were never heard.
        """
        person = self._authoriser.directory.person(principal)
        ranks = {account: rank for rank, account in enumerate(self.last_accounts.of(principal))}
        places = [
            place
            for address in (person.addresses if person is not None else ())
            for place in self.places_of(address)
        ]
        return tuple(sorted(places, key=lambda place: ranks.get(place.account, len(ranks))))

    def places_of(self, address: Address) -> tuple[AccountChat, ...]:
        """Return where an account is told something in private, whoever has it."""
        return tuple(
            AccountChat(messenger, private_chat_of(messenger, address), address)
            for messenger in self.messengers
            if messenger.platform == address.platform
        )

    def may_read(self, principal: PrincipalId, chat: Chat) -> bool:
        """Whether a chat where somebody wanted to read something is still theirs. A look-up.

        A private chat is theirs while its account is. Where private chats have ids of their own,
        while they have any account on that messenger.
        """
        if chat.kind is not ChatKind.PRIVATE or chat.platform == PAGE:
            return True
        person = self._authoriser.directory.person(principal)
        there = [
            one.account
            for one in (person.addresses if person is not None else ())
            if one.platform == chat.platform
        ]
        return chat.id in there or (bool(there) and self._names_chats(chat.platform))

    def _names_chats(self, platform: str) -> bool:
        here = (each for each in self.messengers if each.platform == platform)
        return any(isinstance(each, FindsPrivateChat) for each in here)

    def _newest(self, principal: PrincipalId, notice: Notification) -> Iterable[AccountChat]:
        """Return where somebody is told: where they were last, and where it changes a message."""
        places = self.places(principal)
        if len(places) < 2 or places[0].account not in self.last_accounts.of(principal):  # noqa: PLR2004 - nothing to choose
            return places
        changed = [p for p in places if (p.messenger.name, p.chat.id) in notice.instead_of]
        there = [place for place in places if is_connected(place.messenger) is not False]
        return dict.fromkeys((*changed, *(there or places)[:1]))


def _nothing(_who: PrincipalId, _matter: bytes) -> None:
    """Nobody offers anything anew."""


TO_ADMINS: Final = 2
"""How often a text that has come to the admins has been passed on."""

log = logging.getLogger("rosic.delivery")


def nobody_to_tell(_item: Item, _why: ChatGone) -> None:
    """Log what a chat did not take before it was known who hears of it instead."""
    log.error("nobody can be told any more what a chat did not take")


class UndeliverableHandler:
    """Passes on what a chat did not take."""

    def __init__(
        self,
        reach: Notifier,
        admins: Callable[[], Iterable[PrincipalId]],
        name: Callable[[PrincipalId], str],
    ) -> None:
        self._reach = reach
        self._admins = admins
        self._name = name
        self._not_begun: set[tuple[str, str]] = set()

    def gone(self, item: Item, why: ChatGone) -> None:
        """Tell it elsewhere; it counts as told where it was to be said."""
        not_begun = isinstance(why, ChatNotBegun)
        told = self._pass_on(item, not_begun=not_begun)
        if not_begun:
            self._log_not_begun(item, again=not told)
        elif not told:
            log.error("nobody can be told any more what a chat did not take")

    def _pass_on(self, item: Item, *, not_begun: bool) -> bool:
        """Return whether somebody is told, or nobody has to be."""
        text = _what_matters(item)
        if not text:
            return True
        to, hops = (item.principal, 0) if isinstance(item, OrderMessage) else (item.to, item.hops)
        besides = _where(item)
        if to and not hops:
            here = said("I cannot speak any more where you asked this, so here:\n{text}", text=text)
            if self._reach.pass_on((to,), text if not_begun else here, besides, hops=1):
                return True
        return hops < TO_ADMINS and self._tell_admins(to, text, besides, not_begun=not_begun) > 0

    def _log_not_begun(self, item: Item, *, again: bool) -> None:
        """Say what has to be done before anything is told there: once, and when it mattered."""
        messenger, where = item.messenger, _where(item)
        if where in self._not_begun and not again:
            return
        self._not_begun.add(where)
        us = handle_of(messenger) or messenger.name
        who = item.principal if isinstance(item, OrderMessage) else item.to
        name = self._name(who) if who else f"{messenger.platform}:{where[1]}"
        log.warning("%s has not written to %s yet: nothing is told there until then", name, us)

    def _tell_admins(
        self, to: PrincipalId, text: str, besides: tuple[str, str], *, not_begun: bool
    ) -> int:
        if to and not_begun:
            sentence = said(
                "{name} has not written to me yet, so I cannot reach them."
                " They were to be told:\n{text}",
                name=self._name(to),
                text=text,
            )
        elif to:
            sentence = said(
                "I cannot reach {name} any more. They were to be told:\n{text}",
                name=self._name(to),
                text=text,
            )
        else:
            sentence = said(
                "I cannot speak any more in a chat that was to be told:\n{text}", text=text
            )
        others = [admin for admin in self._admins() if admin != to]
        return self._reach.pass_on(others, sentence, besides, hops=TO_ADMINS)


def _what_matters(item: Item) -> str:
    """Return what somebody waits for; empty for what only shows how things go."""
    if isinstance(item, OrderMessage):
        return item.read(endings=True).text if item.untold else ""
    weighs = bool(item.to) or item.outbound.weight <= SendPriority.ALARM
    return item.outbound.text if weighs else ""


def _where(item: Item) -> tuple[str, str]:
    return item.where if isinstance(item, OrderMessage) else item.where_to
