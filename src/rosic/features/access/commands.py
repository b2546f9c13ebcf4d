"""Says who does which command about people."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import joined, said
from rosic.core.language.command import (
    Command,
    HelpEntry,
    HelpNeed,
    HelpPage,
    MenuAudience,
    MenuEntry,
)
from rosic.errors import NotUnderstood
from rosic.features.access import messages, request_messages
from rosic.features.access.access_request import AccessRequestCommands
from rosic.features.access.approval_reminders import MOST
from rosic.features.access.approve import ApprovalCommands
from rosic.features.access.grant import GrantCommands
from rosic.features.access.invite import InviteCommands
from rosic.features.access.link_commands import AccountLinkCommands
from rosic.features.access.profile_commands import AccountCommands
from rosic.features.access.program_keys import ProgramKeyCommands
from rosic.features.access.revoke_lock import RevokeLockCommands
from rosic.features.access.roles import RoleCommands
from rosic.features.access.second_factor import SecondFactorCommands
from rosic.gateway.commands import Reply
from rosic.gateway.person_argument import several_in_group

if TYPE_CHECKING:
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.confirmation import Confirmation

COMMANDS: Final = (
    Command(
        name="me",
        observes=True,
        aliases=("ich",),
        typed=said("/me"),
        summary=said("What you may do, and until when"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 70),
        menu=MenuEntry(140),
    ),
    Command(
        name="people",
        aliases=("leute",),
        typed=said("/people"),
        summary=said("Who is known here"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 150, "people"),
        menu=MenuEntry(210, MenuAudience.ADMINS),
    ),
    Command(
        name="security",
        aliases=("sicherheit",),
        typed=said("/security"),
        summary=said("What was turned away"),
        help=HelpEntry(HelpPage.SHARE, 170, "people"),
        menu=MenuEntry(280, MenuAudience.ADMINS),
    ),
    Command(
        name="approve",
        summary="say yes to who asks for a right, or wants to come in",
        aliases=("erlauben",),
    ),
    Command(name="decline", summary="say no to them", aliases=("ablehnen",)),
    Command(
        name="revoke",
        aliases=("entziehen",),
        typed=said("/revoke"),
        summary=said("Take somebody's key back"),
        help=HelpEntry(HelpPage.SHARE, 160, "people"),
        menu=MenuEntry(250, MenuAudience.ADMINS),
    ),
    Command(
        name="lock",
        aliases=("sperren",),
        typed=said("/lock"),
        summary=said("Shut somebody out at once"),
        help=HelpEntry(HelpPage.SHARE, 180, "lock"),
        menu=MenuEntry(260, MenuAudience.ADMINS),
    ),
    Command(
        name="unlock", summary="let somebody in again who was locked out", aliases=("entsperren",)
    ),
    Command(
        name="invite",
        aliases=("einladen",),
        typed=said("/invite"),
        summary=said("Let somebody in"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 140, "invite"),
        menu=MenuEntry(220, MenuAudience.ADMINS),
    ),
    Command(name="authenticator", summary="set up a second factor", redacted_unless="reset"),
    Command(name="code", summary="show the second factor", redacted_unless=""),
    Command(
        name="grant",
        aliases=("geben",),
        typed=said("/grant"),
        summary=said("Give somebody a right for a while"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 130, HelpNeed.GRANT),
        menu=MenuEntry(240, MenuAudience.ADMINS),
    ),
    Command(
        name="ask",
        aliases=("bitten",),
        typed=said("/ask"),
        summary=said("Ask for a right that you lack"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 80),
        menu=MenuEntry(130),
    ),
    Command(
        name="role",
        aliases=("rolle",),
        typed=said("/role"),
        summary=said("What the roles here give"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 120, HelpNeed.GRANT),
        menu=MenuEntry(230, MenuAudience.ADMINS),
    ),
    Command(
        name="key",
        aliases=("schluessel", "schlüssel"),
        typed=said("/key"),
        summary=said("Keys for programs that ask over the API"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 145, HelpNeed.GRANT),
    ),
    Command(
        name="link",
        aliases=("verbinden",),
        typed=said("/link"),
        summary=said("One more account of mine, on another messenger"),
        redacted_unless="",
        help=HelpEntry(HelpPage.SHARE, 106),
    ),
    Command(
        name="unlink",
        aliases=("trennen",),
        typed=said("/unlink"),
        summary=said("Take an account away that is mine no more"),
        page=HelpPage.SHARE,
    ),
    Command(name="join", redacted_unless="", spoken=False),
)


class AccessCommands(msgspec.Struct, frozen=True):
    """Everybody who does commands about people."""

    about: AccountCommands
    admitting: ApprovalCommands
    revocation: RevokeLockCommands
    inviting: InviteCommands
    proving: SecondFactorCommands
    linking: AccountLinkCommands
    granting: GrantCommands | None = None
    request_commands: AccessRequestCommands | None = None
    rolemaking: RoleCommands | None = None
    program_keys: ProgramKeyCommands | None = None


class AnswerRouter:
    """Brings a yes or a no to whoever asked.

    A second person is wanted, somebody wants in, or somebody asks for a right.
    """

    def __init__(
        self,
        admitting: ApprovalCommands,
        confirmation: Confirmation | None,
        request_commands: AccessRequestCommands | None,
    ) -> None:
        self._admitting = admitting
        self._confirmation = confirmation
        self._request_commands = request_commands

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
        if asked.rest.strip() or not asked.private or self._request_commands is None:
            return None
        found = self._request_commands.questions(asked.caller.principal)[:MOST]
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
        typed, by = asked.rest.strip(), asked.caller.principal
        if self._confirmation is not None and self._confirmation.is_one(typed):
            return None
        found = self._admitting.questions(by, typed)
        if self._request_commands is not None:
            found += self._request_commands.questions(by, typed)
        if len(found) < 2:  # noqa: PLR2004 - it is clear who is meant
            return None
        if not asked.private:
            raise NotUnderstood(several_in_group(len(found), typed))
        lines = [line for _, line, _ in found[:MOST]]
        text = joined("\n", (request_messages.these_wait(), *lines))
        return Reply(text, tuple(row for *_, row in found[:MOST]))

    def _asker(
        self, asked: CommandContext
    ) -> ApprovalCommands | Confirmation | AccessRequestCommands:
        confirmation, request_commands, typed = (
            self._confirmation,
            self._request_commands,
            asked.rest.strip(),
        )
        if confirmation is not None and confirmation.is_one(typed):
            return confirmation
        by = asked.caller.principal
        if request_commands is None or self._admitting.questions(by, typed):
            return self._admitting
        return request_commands if request_commands.knows(by, typed) else self._admitting


def register_access_commands(
    commands: CommandRegistry, handlers: AccessCommands, confirmation: Confirmation | None = None
) -> None:
    """Give each handler their commands; yes and no are shared with whoever asks for consent."""
    answers = AnswerRouter(handlers.admitting, confirmation, handlers.request_commands)
    commands.register("me", handlers.about.me)
    commands.register("people", handlers.about.people)
    commands.register("security", handlers.about.security)
    commands.register("approve", answers.approve)
    commands.register("decline", answers.decline)
    commands.register("revoke", handlers.revocation.revoke)
    commands.register("lock", handlers.revocation.lock)
    commands.register("unlock", handlers.revocation.unlock)
    commands.register("invite", handlers.inviting.invite)
    commands.register("authenticator", handlers.proving.authenticator)
    commands.register("code", handlers.proving.code)
    commands.register("link", handlers.linking.link)
    commands.register("unlink", handlers.linking.unlink)
    if handlers.granting is not None:
        commands.register("grant", handlers.granting.grant)
    if handlers.request_commands is not None:
        commands.register("ask", handlers.request_commands.ask)
    if handlers.rolemaking is not None:
        commands.register("role", handlers.rolemaking.role)
    if handlers.program_keys is not None:
        commands.register("key", handlers.program_keys.key)
