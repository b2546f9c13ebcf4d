"""Says who does which errand about people."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.i18n import joined
from rosic.errors import NotUnderstood
from rosic.features.access import messages, request_messages
from rosic.features.access.access_request import AccessRequestCommands
from rosic.features.access.approve import ApprovalCommands
from rosic.features.access.grant import GrantCommands
from rosic.features.access.invite import InviteCommands
from rosic.features.access.profile_commands import AccountCommands
from rosic.features.access.reminding import MOST
from rosic.features.access.revoke_lock import RevokeLockCommands
from rosic.features.access.roles import RoleCommands
from rosic.features.access.second_factor import SecondFactorCommands
from rosic.gateway.office import Reply

if TYPE_CHECKING:
    from rosic.gateway.confirmation import Confirmation
    from rosic.gateway.office import CommandContext, CommandRegistry


class AccessCommands(msgspec.Struct, frozen=True):
    """Everybody who does errands about people."""

    about: AccountCommands
    admitting: ApprovalCommands
    custody: RevokeLockCommands
    inviting: InviteCommands
    proving: SecondFactorCommands
    granting: GrantCommands | None = None
    petitioning: AccessRequestCommands | None = None
    rolemaking: RoleCommands | None = None


class Answers:
    """Brings a yes or a no to whoever asked.

    A second person is wanted, somebody wants in, or somebody asks for a right.
    """

    def __init__(
        self,
        admitting: ApprovalCommands,
        consent: Confirmation | None,
        petitioning: AccessRequestCommands | None,
    ) -> None:
        self._admitting = admitting
        self._consent = consent
        self._petitioning = petitioning

    async def approve(self, asked: CommandContext) -> Reply:
        """Take a yes; without saying to whom, show what may be answered."""
        if reply := self._open(asked) or self._several(asked):
            return reply
        return await self._asker(asked).approve(asked)

    async def decline(self, asked: CommandContext) -> Reply:
        """Take a no; likewise."""
        if reply := self._open(asked) or self._several(asked):
            return reply
        return await self._asker(asked).decline(asked)

    def _open(self, asked: CommandContext) -> Reply | None:
        """Return the rights that somebody is asked for, in private, where none was named."""
        if asked.rest.strip() or not asked.private or self._petitioning is None:
            return None
        found = self._petitioning.questions(asked.caller.principal)[:MOST]
        if not found:
            return None
        lines = [joined("\n", (line, request_messages.answer_so(name))) for name, line, _ in found]
        if names := [one.name for one in self._admitting.waiting(asked.caller.principal)]:
            lines.append(messages.who_waits(names))
        text = joined("\n", (request_messages.these_wait(), *lines))
        return Reply(text, tuple(row for *_, row in found))

    def _several(self, asked: CommandContext) -> Reply | None:
        """Return the question whom an answer means, if more than one waits for it.

        A name is its owner's to choose: who wants in may be called like somebody who asks for a
        right.

        Raises:
            NotUnderstood: Others read along.
        """
        said, by = asked.rest.strip(), asked.caller.principal
        if self._consent is not None and self._consent.is_one(said):
            return None
        found = self._admitting.questions(by, said)
        if self._petitioning is not None:
            found += self._petitioning.questions(by, said)
        if len(found) < 2:  # noqa: PLR2004 - it is clear who is meant
            return None
        if not asked.private:
            raise NotUnderstood(messages.several_in_group(len(found), said))
        lines = [line for _, line, _ in found[:MOST]]
        text = joined("\n", (request_messages.these_wait(), *lines))
        return Reply(text, tuple(row for *_, row in found[:MOST]))

    def _asker(
        self, asked: CommandContext
    ) -> ApprovalCommands | Confirmation | AccessRequestCommands:
        consent, petitioning, said = self._consent, self._petitioning, asked.rest.strip()
        if consent is not None and consent.is_one(said):
            return consent
        by = asked.caller.principal
        if petitioning is None or self._admitting.questions(by, said):
            return self._admitting
        return petitioning if petitioning.knows(by, said) else self._admitting


def hire(
    office: CommandRegistry, clerks: AccessCommands, consent: Confirmation | None = None
) -> None:
    """Give each clerk their errands; yes and no are shared with whoever asks for consent."""
    answers = Answers(clerks.admitting, consent, clerks.petitioning)
    office.employ("me", clerks.about.me)
    office.employ("people", clerks.about.people)
    office.employ("security", clerks.about.security)
    office.employ("approve", answers.approve)
    office.employ("decline", answers.decline)
    office.employ("revoke", clerks.custody.revoke)
    office.employ("lock", clerks.custody.lock)
    office.employ("unlock", clerks.custody.unlock)
    office.employ("invite", clerks.inviting.invite)
    office.employ("authenticator", clerks.proving.authenticator)
    office.employ("code", clerks.proving.code)
    if clerks.granting is not None:
        office.employ("grant", clerks.granting.grant)
    if clerks.petitioning is not None:
        office.employ("ask", clerks.petitioning.ask)
    if clerks.rolemaking is not None:
        office.employ("role", clerks.rolemaking.role)
