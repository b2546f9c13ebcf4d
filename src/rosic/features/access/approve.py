"""An admin's tap: let them in, or not. Both sides see the same two words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.authoriser import messages
from rosic.authoriser.enrolment_records import PENDING_S
from rosic.core.i18n import joined
from rosic.core.message import Button
from rosic.errors import Expired, NotUnderstood
from rosic.features.access import messages as words
from rosic.features.access.admin_policy import INVITE
from rosic.gateway.commands import Reply
from rosic.gateway.pending_work import PendingRequest

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.authoriser.enrolment_records import Applicant, CodeRedeemed, EnrolmentDeclined
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Record
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.features.access.newcomer_chat import NewcomerChat
    from rosic.gateway.commands import CommandContext


class ApprovalCommands:
    """Asks the admins about whoever waits, and takes their answers.

    Args:
        registry: Who knows people.
        admin_policy: Who may let somebody in.
        newcomer_chat: Reaches whoever is nobody yet.
        menu: What somebody who has just come in is shown besides the welcome.
        forget: Erases what was kept of a newcomer who was not let in.
    """

    def __init__(
        self,
        registry: AccessContext,
        admin_policy: AdminPolicy,
        newcomer_chat: NewcomerChat,
        *,
        menu: Callable[[PrincipalId], Reply],
        forget: Callable[[PrincipalId], Awaitable[None]],
    ) -> None:
        self.menu = menu
        self._forget = forget
        self._registry = registry
        self._enrolment = registry.enrolment
        self._admin_policy = admin_policy
        self._newcomer_chat = newcomer_chat

    def records(self, redeemed: CodeRedeemed, by: PrincipalId) -> tuple[Record, ...]:
        """Return all that lets somebody in: the person, the key and what ends by itself.

        Raises:
            NotUnderstood: They have too many rights already; nothing changed.
        """
        if not redeemed.grants:
            return redeemed.records
        given = self._registry.grants_book.give(redeemed.person.id, redeemed.grants, by)
        return (*redeemed.records, *given)

    def ask(self, applicant: Applicant) -> int:
        """Ask everybody who may let them in. Return in how many places."""
        asked = self._admin_policy.admitters(applicant.pending.given)
        row = buttons_for(applicant)
        return self._registry.reach.tell(
            asked, applicant.question, (row,), urgent=True, lifetime_s=PENDING_S, still=True
        )

    async def approve(self, asked: CommandContext) -> Reply:
        """Let somebody in: ``/approve Cy``, or the button.

        Raises:
            Refusal: Not theirs to do, settled before, too late, or the person is locked.
        """
        by, applicant = asked.caller.principal, self._asked_about(asked)
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check(by, INVITE)
            redeemed = self._enrolment.confirm(
                applicant.pending.id,
                by,
                may_admit=self._admin_policy.may_admit(by, applicant.pending.given),
            )
            await turn.write(self.records(redeemed, by))
        self._welcome(redeemed)
        name, what = applicant.name, applicant.pending.given.words
        self._tell_others(applicant, by, words.was_let_in(self._registry.name(by), name, what))
        return Reply(words.let_in(name, what))

    async def decline(self, asked: CommandContext) -> Reply:
        """Turn somebody away: ``/decline Cy``, or the button.

        Raises:
            Refusal: Not theirs to do, settled before, or too late.
        """
        by, applicant = asked.caller.principal, self._asked_about(asked)
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check(by, INVITE)
            declined = self._enrolment.decline(
                applicant.pending.id,
                by,
                may_admit=self._admin_policy.may_admit(by, applicant.pending.given),
            )
            await turn.write(declined.records)
        await self._turned_away(declined)
        told = words.was_not_let_in(self._registry.name(by), applicant.name)
        self._tell_others(applicant, by, told)
        return Reply(words.not_let_in(applicant.name))

    async def lapse(self) -> tuple[EnrolmentDeclined, ...]:
        """Turn away everybody for whom no admin tapped in time; call it every minute or so.

        Returns:
            Who was turned away.

        Raises:
            RecordUnavailable: Nothing was written; it is tried again with the next call.
        """
        async with self._registry.changes.turn() as turn:
            late = self._enrolment.lapsed()
            for declined in late:
                await turn.write(declined.records)
        for declined in late:
            await self._turned_away(declined)
        return late

    async def _turned_away(self, declined: EnrolmentDeclined) -> None:
        self._newcomer_chat.tell(declined.address, declined.sentence)
        if declined.newcomer:
            await self._forget(declined.principal)

    def waiting(self, by: PrincipalId) -> tuple[Applicant, ...]:
        """Return everybody who waits and whom this person may let in."""
        return tuple(
            applicant
            for applicant in self._enrolment.applicants.all()
            if self._admin_policy.may_admit(by, applicant.pending.given)
        )

    def pending(self, by: PrincipalId) -> tuple[PendingRequest, ...]:
        """Return the same, for whoever shows it."""
        return tuple(
            PendingRequest(
                a.pending.id,
                "newcomer",
                a.name,
                a.pending.given.words,
                a.words,
                a.pending.expires_ns,
            )
            for a in self.waiting(by)
        )

    def questions(
        self, by: PrincipalId, said: str
    ) -> tuple[tuple[str, str, tuple[Button, ...]], ...]:
        """Return everybody called so whom this person may let in: name, line and buttons, each."""
        wanted = said.strip().casefold()
        return tuple(
            (a.name, words.waits(a.name, a.pending.given.words, a.words), buttons_for(a, a.name))
            for a in self.waiting(by)
            if wanted in {a.name.casefold(), a.words}
        )

    def _asked_about(self, asked: CommandContext) -> Applicant:
        """Return who is meant. Who waits is no business of those who may let nobody in."""
        self._admin_policy.check(asked.caller.principal, INVITE)
        if not asked.rest.strip():
            names = [applicant.name for applicant in self.waiting(asked.caller.principal)]
            raise NotUnderstood(words.who_waits(names))
        found = self._meant(asked.rest)
        if found is None:
            raise Expired(messages.SETTLED)
        return found

    def _meant(self, said: str) -> Applicant | None:
        said = said.strip()
        by_id = self._enrolment.applicants.get(said)
        if by_id is not None:
            return by_id
        wanted = said.casefold()
        found = [
            applicant
            for applicant in self._enrolment.applicants.all()
            if wanted in {applicant.name.casefold(), applicant.words}
        ]
        return found[0] if len(found) == 1 else None

    def _welcome(self, redeemed: CodeRedeemed) -> None:
        person = redeemed.person
        menu = self.menu(person.id)
        text = joined("\n", filter(None, (redeemed.sentence, menu.text)))
        self._registry.reach.tell((person.id,), text, menu.buttons)

    def _tell_others(self, applicant: Applicant, by: PrincipalId, text: str) -> None:
        asked = self._admin_policy.admitters(applicant.pending.given)
        self._registry.reach.tell((who for who in asked if who != by), text)


def buttons_for(applicant: Applicant, name: str = "") -> tuple[Button, ...]:
    """Return the two answers to whether somebody may come in."""
    yes, no = (words.let_in_label(name), words.decline_label(name))
    pending = applicant.pending.id
    return (Button(yes, f"/approve {pending}"), Button(no, f"/decline {pending}"))
