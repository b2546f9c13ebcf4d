"""``/authenticator`` and ``/code 123456``: a phone as a second step."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosic.authoriser import keys_messages
from rosic.authoriser.invite_codes import TERMINAL, qr_text
from rosic.authoriser.two_factor import SETUP_NS
from rosic.core.i18n import joined
from rosic.errors import RecordUnavailable
from rosic.features.access import access_messages
from rosic.features.access.admin_policy import PEOPLE, PersonNames
from rosic.features.access.invite import qr_picture
from rosic.gateway.commands import Reply, check_private

if TYPE_CHECKING:
    from rosic.core.identity import Principal
    from rosic.features.access.admin_policy import AdminPolicy
    from rosic.features.access.context import AccessContext
    from rosic.gateway.commands import CommandContext

RESET = "reset"
AUTHENTICATOR = "authenticator"
"""What a message holds that goes once a phone is set up."""


class SecondFactorCommands:
    """Sets phones up and takes their codes."""

    def __init__(self, registry: AccessContext, admin_policy: AdminPolicy) -> None:
        self._registry = registry
        self._admin_policy = admin_policy
        self._two_factor = registry.two_factor
        self._names = PersonNames(registry)

    async def authenticator(self, asked: CommandContext) -> Reply:
        """Begin to set a phone up; ``/authenticator reset NAME`` forgets a lost one.

        Raises:
            Refusal: Others read along, or a phone is set up and has not been proven here.
        """
        first, _, rest = asked.rest.strip().partition(" ")
        if first.casefold() == RESET:
            return await self._reset(asked, rest.strip())
        caller = asked.caller
        self._admin_policy.check_not_locked(caller.principal)
        setup = self._two_factor.begin(caller.principal, caller.name, asked.inbound.chat)
        uri = setup.uri.reveal()
        lines = [access_messages.set_up(uri, setup.key.reveal())]
        if asked.messenger.platform == TERMINAL:
            lines.append(qr_text(uri))
            return Reply(joined("\n", lines))
        picture = await qr_picture(asked.messenger, "authenticator.png", uri)
        if picture is not None:
            lines.append(access_messages.SCAN)
        until_ns = self._registry.clock.wall_ns() + SETUP_NS
        keep = partial(
            self._registry.retracting.keep,
            f"{AUTHENTICATOR} {caller.principal}",
            caller.principal,
            until_ns,
        )
        return Reply(joined("\n", lines), attachment=picture, landed=keep)

    async def code(self, asked: CommandContext) -> Reply:
        """Finish setting up, or prove who holds the phone, for this chat.

        Raises:
            Refusal: Not six digits, wrong, used before, too many wrong ones, or no phone.
        """
        principal, chat, digits = asked.caller.principal, asked.inbound.chat, asked.rest
        finishes = asked.private and self._two_factor.is_setting_up(principal)
        if asked.inbound.nonce is None:  # it was typed: right or wrong, it is not left lying about
            self._registry.retracting.now(asked.messenger, chat, asked.inbound.message)
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check_not_locked(principal)
            take = self._two_factor.finish if finishes else self._two_factor.prove
            proof = take(principal, chat, digits)
            try:
                await turn.write(proof.records)
            except RecordUnavailable as fault:
                raise RecordUnavailable(keys_messages.CODE_NOT_WRITTEN) from fault
            self._two_factor.admit(proof)
        return Reply(proof.sentence)

    async def _reset(self, asked: CommandContext, said: str) -> Reply:
        by = asked.caller.principal
        self._admin_policy.check(by, PEOPLE)
        check_private(asked)
        if not said:
            return Reply(access_messages.HOW_TO_RESET)
        found = self._names.find(asked, said, f"authenticator {RESET}", self._has_phone)
        if isinstance(found, Reply):
            return found
        async with self._registry.changes.turn() as turn:
            self._admin_policy.check(by, PEOPLE)
            await turn.write(self._two_factor.reset(found.id, by))
        self._registry.reach.tell(
            (found.id,), access_messages.your_phone_was_reset(self._registry.name(by))
        )
        return Reply(access_messages.phone_reset(found.name))

    def _has_phone(self, person: Principal) -> bool:
        return self._two_factor.is_set_up(person.id)
