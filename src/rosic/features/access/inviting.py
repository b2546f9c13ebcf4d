"""``/invite operator kuka1 for 2h``: a link and a code, for one person, once."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import TYPE_CHECKING

from rosic.authoriser.invite_codes import join_text
from rosic.authoriser.qr import drawn, qr_code, qr_text
from rosic.core.i18n import joined
from rosic.core.message import Attachment
from rosic.features.access import messages
from rosic.features.access.admin_policy import INVITE, PEOPLE
from rosic.features.access.invite import read_invitation
from rosic.gateway.builtin_commands import Reply
from rosic.gateway.office import check_private

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.messenger import Messenger
    from rosic.core.secret import Secret
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.office import CommandContext

INVITATION = "invitation"
"""What a message holds that goes once nobody can be let in by it."""
TERMINAL = "terminal"
"""The one platform whose letters all have the same width."""


def _no_link(_messenger: Messenger, _code: Secret) -> str:
    return ""


async def qr_picture(messenger: Messenger, name: str, text: str) -> Attachment | None:
    """Return a picture to be scanned; nothing where no file can be sent. It shows a secret."""
    await asyncio.sleep(0)  # what came before, the code and the picture are a step each
    code = qr_code(text)
    await asyncio.sleep(0)
    picture = drawn(code)
    if len(picture) > messenger.file_bytes:
        return None
    return Attachment(name, "image/png", picture)


class InviteCommands:
    """Makes invitations and takes them back.

    Args:
        registry: Who knows people.
        powers: Who may.
        link: Returns the link that hands a code in on the messenger where it was asked for; empty
            where there is none. It shows a secret.
    """

    def __init__(
        self,
        registry: AccessContext,
        powers: AdminPolicy,
        *,
        link: Callable[[Messenger, Secret], str] = _no_link,
    ) -> None:
        self._registry = registry
        self._powers = powers
        self._link = link

    async def invite(self, asked: CommandContext) -> Reply:
        """Make an invitation, take one back, or open joining again.

        Raises:
            Refusal: Others read along, not theirs to give, or not understood.
        """
        by, rest = asked.caller.principal, asked.rest.strip()
        check_private(asked)
        self._powers.check(by, INVITE)
        if not rest:
            rights = self._registry.rights()
            return Reply(messages.how_to_invite(tuple(rights.rulebook.roles), rights.fleet.skills))
        first, _, other = rest.partition(" ")
        if first == messages.BACK:
            return await self._take_back(asked, other.strip())
        if rest == messages.REOPEN:
            return await self._reopen(asked)
        return await self._invite(asked, rest)

    async def _invite(self, asked: CommandContext, rest: str) -> Reply:
        by = asked.caller.principal
        wanted = read_invitation(rest, self._registry.rights())
        async with self._registry.changes.turn() as turn:
            self._powers.check(by, INVITE)
            self._powers.check_give(by, wanted.given, within_s=wanted.code_ttl_s)
            offer = self._registry.enrolment.invitations.invite(wanted, by)
            await turn.write(offer.records)
        link = self._link(asked.messenger, offer.code)
        text = join_text(offer.code)
        lines = [offer.sentence, messages.how_to_join(link, text)]
        picture = None
        if asked.messenger.platform == TERMINAL:
            lines.append(qr_text(link or text))
        else:
            picture = await qr_picture(asked.messenger, "invitation.png", link or text)
        made = offer.invitation
        keep = partial(
            self._registry.retracting.keep, f"{INVITATION} {made.id}", by, made.expires_ns
        )
        row = (messages.take_back_button(made.id, wanted.code_ttl_s),)
        return Reply(joined("\n", lines), (row,), picture, landed=keep)

    async def _take_back(self, asked: CommandContext, invitation: str) -> Reply:
        by, made = asked.caller.principal, self._registry.enrolment.invitations
        async with self._registry.changes.turn() as turn:
            self._powers.check(by, INVITE)
            records = made.withdraw(invitation, by)
            written = await turn.act(records)
        return Reply(messages.noted(messages.TAKEN_BACK, written=written), anew=True)

    async def _reopen(self, asked: CommandContext) -> Reply:
        """Let everybody have all their tries again after too many wrong codes."""
        by = asked.caller.principal
        async with self._registry.changes.turn() as turn:
            self._powers.check(by, PEOPLE)
            await turn.write(self._registry.enrolment.reopen(by))
        return Reply(messages.REOPENED)
