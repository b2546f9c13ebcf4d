"""A code comes in: what it gives is shown, one tap, and somebody is in or waits for an admin."""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING

from rosic.authoriser import messages
from rosic.authoriser.enrolment_records import ApprovalPending, CodeRedeemed, EnrolmentRefused
from rosic.authoriser.invite_codes import code_said
from rosic.contracts.chats import assurance_of
from rosic.core.i18n import joined
from rosic.core.message import ChatKind, MessageValidity
from rosic.core.rate_limit import Bucket, RateLimit
from rosic.core.secret import Secret
from rosic.errors import Expired, RecordUnavailable, Refusal
from rosic.features.access import messages as words
from rosic.features.access.admin_policy import PEOPLE
from rosic.features.access.invite import INVITATION
from rosic.features.access.linking import AccountLinking
from rosic.features.access.newcomer_chat import OfferedInvitation
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.authoriser.enrolment import Enrolment
    from rosic.authoriser.enrolment_records import EnrolmentAlarm
    from rosic.contracts.messenger import Messenger
    from rosic.core.message import Inbound
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.approve import ApprovalCommands
    from rosic.features.access.context import AccessContext
    from rosic.features.access.newcomer_chat import NewcomerChat, TappedInvitation
    from rosic.gateway.transactions import UnitOfWork

LONG = 1_000
SILENT = Reply("")
# Whose device it came from need not be known: what they may do by what comes from it, it is asked.
MAY_JOIN = frozenset({MessageValidity.FRESH, MessageValidity.UNVERIFIED})
"""It was about joining, and is done; there is nothing to say."""
# Answers to what is no good code: all addresses share them.
ANSWERS = RateLimit(burst=10.0, per_s=0.5)

_may_hold_a_code = re.compile(
    "start|join|link|verbinden|[-\u2013\u2014\u2212]", re.IGNORECASE
).search


class JoinHandler:
    """Takes what may be a code, and the taps that follow, from strangers and known people alike.

    It stands before recognising: whoever comes with a code is nobody yet, so the buttons are bound
    to their address.

    Args:
        registry: Who knows people.
        admin_policy: Who is to be told.
        admitting: Who asks the admins.
        newcomer_chat: Whose buttons these are.
        shown_as: How the messenger shows the sender; empty if it does not say.
        names_robot: Whether a text alone means a robot here, however much it looks like a code.
    """

    def __init__(
        self,
        registry: AccessContext,
        admin_policy: AdminPolicy,
        admitting: ApprovalCommands,
        newcomer_chat: NewcomerChat,
        *,
        shown_as: Callable[[Inbound], str] = lambda _: "",
        names_robot: Callable[[str], bool] = lambda _: False,
    ) -> None:
        self._registry = registry
        self._enrolment: Enrolment = registry.enrolment
        self._admin_policy = admin_policy
        self._admitting = admitting
        self._newcomer_chat = newcomer_chat
        self._shown_as = shown_as
        self._names_robot = names_robot
        self._linking = AccountLinking(registry, admin_policy)
        self._answers = Bucket(ANSWERS, registry.clock.monotonic_ns())
        self._greetings = Bucket(ANSWERS, registry.clock.monotonic_ns())

    async def take(self, messenger: Messenger, inbound: Inbound, text: str) -> Reply | None:
        """Take a message or tap before anybody is recognised; of one that is not fresh, what leaks.

        Returns:
            None: it is not about joining. Otherwise what to say, with buttons that are
            bound already; nothing, if the text is empty.

        Raises:
            Refusal: Why not; nothing has changed.
        """
        if inbound.nonce is not None:
            known = self._newcomer_chat.knows(inbound.nonce)
            return await self._tapped(messenger, inbound) if known else None
        private = inbound.chat.kind is ChatKind.PRIVATE
        if private and inbound.standing not in MAY_JOIN:
            return None
        if not private:
            return await self._in_group(messenger, inbound, text)
        if _may_hold_a_code(text) is not None:
            code = code_said(text)
            if code is not None and not self._is_robot(inbound, text):
                if self._linking.is_code(code):
                    return await self._linked(messenger, inbound, code)
                return self._shown(messenger, inbound, code, text)
        return self._still_waiting(inbound) or self._to_the_first(inbound)

    def _is_robot(self, inbound: Inbound, text: str) -> bool:
        """Whether somebody who is known has named a robot; strangers know none."""
        known = self._registry.authoriser.directory.at(inbound.sender)
        return known is not None and self._names_robot(text.strip())

    # ---- what was sent ----

    async def _linked(self, messenger: Messenger, inbound: Inbound, code: str) -> Reply:
        """Link an account, unless it has to wait after too many wrong codes."""
        refused = self._enrolment.not_now(inbound.sender)
        return (
            await self._linking.take(messenger, inbound, code)
            if refused is None
            else self._turned_away(refused)
        )

    def _shown(self, messenger: Messenger, inbound: Inbound, code: str, text: str) -> Reply:
        """Show what a code gives; it is not used up by that."""
        found = self._enrolment.look(code, inbound.sender, private=True)
        if isinstance(found, EnrolmentRefused):
            return self._turned_away(found)
        what = found.given.words
        good_for_ns = found.expires_ns - self._registry.clock.wall_ns()
        offered = OfferedInvitation(Secret(code), found.id, found.issuer, what, good_for_ns)
        if not text.lstrip().startswith("/"):  # a link's START shows nobody what it brings
            self._registry.retracting.keep(
                f"{INVITATION} {found.id}",
                "",
                found.expires_ns,
                messenger,
                inbound.chat,
                inbound.message,
            )
        shown = words.invited(what, messenger.platform, assurance_of(messenger, inbound).said)
        return Reply(shown, self._newcomer_chat.offer(inbound, offered))

    async def _in_group(self, messenger: Messenger, inbound: Inbound, text: str) -> Reply | None:
        """Burn every good code that a group was shown, and say the same about one that is none.

        However it came to be shown: forwarded, edited in, posted by nobody in particular.
        """
        read = "\n".join((inbound.written or text, *inbound.links))
        if len(read) > LONG:
            await asyncio.sleep(0)  # searching much is a step
        said = None
        if self._linking.burn(self._registry.links.shown_in(read)):
            said = EnrolmentRefused("link-in-group", messages.IN_GROUP)
        if codes := self._enrolment.shown_in(read):
            async with self._registry.changes.turn() as turn:
                said = await self._burnt(turn, inbound, codes) or said
        if said is not None:
            self._registry.retracting.now(messenger, inbound.chat, inbound.message)
        asks = inbound.standing is MessageValidity.FRESH and text.lstrip().startswith("/")
        code = code_said(text) if asks else None
        if said is None and code is not None:
            said = self._enrolment.look(code, inbound.sender, private=False)  # type: ignore[assignment]  # never an invitation
        if said is None:
            return None
        reply = self._turned_away(said)
        return SILENT if inbound.chat.kind is ChatKind.CHANNEL else reply  # nothing is said there

    async def _burnt(
        self, turn: UnitOfWork, inbound: Inbound, codes: tuple[str, ...]
    ) -> EnrolmentRefused | None:
        burnt = None
        for code in codes:
            if (found := self._enrolment.leaked(code, inbound.sender)) is None:
                continue
            if burnt is not None:
                self._raise_alarm(burnt.alarm)
            burnt = found
            await turn.act(found.records)
        return burnt

    def _turned_away(self, found: EnrolmentRefused) -> Reply:
        self._raise_alarm(found.alarm)
        if self._answers.take(self._registry.clock.monotonic_ns()):
            return SILENT
        if found.sentence == messages.NOT_GOOD and self._enrolment.nobody_is_admin():
            return Reply(messages.NOT_GOOD_FOR_THE_FIRST)  # there is nobody to be asked
        return Reply(found.sentence)

    def _raise_alarm(self, alarm: EnrolmentAlarm | None) -> None:
        if alarm is None:
            return
        buttons = (words.REOPEN_ROW,) if alarm.kind == "code-breaker" else ()
        admins = self._admin_policy.holders(PEOPLE)
        self._registry.reach.tell(admins, alarm.sentence, buttons, urgent=True)

    def _still_waiting(self, inbound: Inbound) -> Reply | None:
        """Tell whoever waits for an admin that they do; they would be a stranger otherwise."""
        applicant = self._enrolment.applicants.at(inbound.sender)
        if applicant is None or self._registry.authoriser.directory.at(inbound.sender) is not None:
            return None
        left_s = (applicant.pending.expires_ns - self._registry.clock.wall_ns()) / 1e9
        if left_s <= 0:
            return None
        if self._answers.take(self._registry.clock.monotonic_ns()):
            return SILENT
        return Reply(messages.waiting(applicant.words, left_s))

    def _to_the_first(self, inbound: Inbound) -> Reply | None:
        """Tell somebody unknown where the first admin's code is, while there is nobody to ask."""
        known = self._registry.authoriser.directory.at(inbound.sender) is not None
        if known or self._greetings.take(self._registry.clock.monotonic_ns()):
            return None
        return Reply(messages.FIRST_WANTED) if self._enrolment.nobody_is_admin() else None

    # ---- what was tapped ----

    async def _tapped(self, messenger: Messenger, inbound: Inbound) -> Reply:
        nonce = inbound.nonce or ""
        settled = self._newcomer_chat.is_settled(nonce)
        try:
            tapped = self._newcomer_chat.redeem(inbound)
        except Refusal as refusal:
            await messenger.answer_tap(inbound, words.ANSWERED if settled else refusal.sentence)
            if settled or not isinstance(refusal, Expired):
                return SILENT
            first = self._enrolment.nobody_is_admin()
            return Reply(words.OVER_FOR_THE_FIRST if first else words.INVITATION_OVER)
        await messenger.answer_tap(inbound, "")
        if not tapped.joins:
            return self._not_me(tapped)
        try:
            return await self._joins(inbound, tapped)
        except RecordUnavailable:
            return Reply(words.NOT_WRITTEN)

    def _not_me(self, tapped: TappedInvitation) -> Reply:
        offered = tapped.offered
        told = words.not_for_them(offered.what)
        row = (words.take_back_button(offered.invitation, words.TAKE_BACK_S),)
        self._registry.reach.tell((offered.issuer,), told, (row,))
        return Reply(words.NOT_ME_SAID)

    async def _joins(self, inbound: Inbound, tapped: TappedInvitation) -> Reply:
        """Redeem the code: all of it is written before somebody is in, or nothing changes."""
        name = self._shown_as(inbound)
        private = inbound.chat.kind is ChatKind.PRIVATE
        code = tapped.code.reveal()
        async with self._registry.changes.turn() as turn:
            answer = self._enrolment.redeem(code, inbound.sender, private=private, name=name)
            if isinstance(answer, EnrolmentRefused):
                await turn.act(answer.records)
            elif isinstance(answer, ApprovalPending):
                await turn.write(answer.records)
            else:
                await turn.write(self._admitting.records(answer, tapped.offered.issuer))
        if isinstance(answer, EnrolmentRefused):
            return self._turned_away(answer)
        if isinstance(answer, ApprovalPending):
            return self._waits(answer)
        return self._is_in(inbound, answer, tapped)

    def _waits(self, answer: ApprovalPending) -> Reply:
        asked = self._admitting.ask(answer.applicant)
        return Reply(
            answer.sentence if asked else joined(" ", (answer.sentence, words.NOBODY_TO_ASK))
        )

    def _is_in(self, inbound: Inbound, answer: CodeRedeemed, tapped: TappedInvitation) -> Reply:
        person, offered = answer.person, tapped.offered
        self._registry.reach.tell((offered.issuer,), words.is_in(person.name, offered.what))
        menu = self._admitting.menu(person.id)
        issue = self._registry.authoriser.buttons.issue
        bound = tuple(
            tuple(issue(button, person.id, inbound.chat.id) for button in row)
            for row in menu.buttons
        )
        return Reply(joined("\n", filter(None, (answer.sentence, menu.text))), bound)
