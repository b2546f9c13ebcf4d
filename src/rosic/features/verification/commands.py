"""``/verify``: have one's devices verified. ``/match``, ``/differ``: what comparing came to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.contracts.chats import assurance_of
from rosic.core.i18n import said
from rosic.core.language.command import Command, HelpEntry, HelpPage
from rosic.core.language.sanitise import quote
from rosic.core.message import ChatKind, MessageValidity
from rosic.core.policy.roles import Assurance
from rosic.core.policy.scope import FLEET, GRANT
from rosic.errors import Expired, NotPermitted, NotUnderstood, Unverified
from rosic.features.verification import messages as words
from rosic.gateway.commands import Reply
from rosic.gateway.person_argument import which_person
from rosic.gateway.requests import check_command_fresh

if TYPE_CHECKING:
    from rosic.core.identity import Principal
    from rosic.features.verification.service import DeviceVerifications, PendingVerification
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.components import Components

COMMANDS: Final = (
    Command(
        name="verify",
        aliases=("verifizieren",),
        observes=True,
        typed=said("/verify"),
        summary=said("Have your devices verified, by comparing emoji"),
        help=HelpEntry(HelpPage.SHARE, 108),
    ),
    Command(
        name="match",
        pairs=(("they", "match"), ("sie", "stimmen"), ("stimmen", "überein")),
        summary=said("Say that emoji match"),
        page=HelpPage.SHARE,
    ),
    Command(
        name="differ",
        pairs=(("they", "differ"), ("stimmen", "nicht")),
        summary=said("Say that emoji differ"),
        page=HelpPage.SHARE,
    ),
)


class VerificationCommands:
    """The handler of verifying.

    Args:
        verifications: Those under way.
        rooms: Who knows people and their rights.
    """

    def __init__(self, verifications: DeviceVerifications, rooms: Components) -> None:
        self._verifications = verifications
        self._directory = rooms.authoriser.directory
        self._organiser = rooms.organiser

    def register(self, commands: CommandRegistry) -> None:
        """Take these commands."""
        served = self._verifications.serves
        commands.register("verify", self.verify, offered=served)
        commands.register("match", self.match, offered=served)
        commands.register("differ", self.differ, offered=served)

    async def verify(self, asked: CommandContext) -> Reply:
        """Begin: with whoever asks; or with somebody whom an admin names.

        Raises:
            NotPermitted, NotUnderstood: They may not, or nothing is verified there.
            Expired: Their client could not be asked, or it was said long ago.
        """
        check_command_fresh(asked.inbound, "/verify")
        if asked.caller.is_program:
            raise NotPermitted(words.PROGRAM)
        if asked.inbound.chat.kind is not ChatKind.PRIVATE:
            raise NotPermitted(words.IN_GROUP)
        if typed := asked.rest.strip():
            return await self._verify_other(asked, typed)
        messenger = asked.messenger
        if not self._verifications.can_verify(messenger):
            raise NotUnderstood(words.NOT_HERE)
        if assurance_of(messenger, asked.inbound) >= Assurance.E2EE_VERIFIED:
            return Reply(words.VERIFIED_ALREADY)
        await self._verifications.begin(messenger, asked.inbound.sender.account)
        return Reply(words.begun(self._verifications.comparers(messenger)))

    async def _verify_other(self, asked: CommandContext, typed: str) -> Reply:
        if asked.inbound.standing is not MessageValidity.FRESH:
            raise Unverified(words.ONLY_ADMINS)
        self._check_may_compare(asked)
        people = self._directory.called(typed)
        if not people:
            raise NotUnderstood(said("I know nobody called {typed}.", typed=quote(typed)))
        if len(people) > 1:
            return which_person(asked, typed, [(one, f"/verify {one.id}", "") for one in people])
        [person] = people
        return Reply(await self.begin_with(person))

    async def begin_with(self, person: Principal) -> str:
        """Begin with somebody, wherever their devices can be verified; return what is said.

        Raises:
            NotUnderstood: Nowhere.
            Expired: Their client could not be asked.
        """
        if not await self._verifications.begin_with(person):
            raise NotUnderstood(words.no_account(person.name))
        return words.begun_with(person.name)

    async def match(self, asked: CommandContext) -> Reply:
        """Somebody has compared: the same.

        Raises:
            NotPermitted, NotUnderstood, Expired: Why that does not count; nothing is verified.
            RecordUnavailable: It cannot be written down; nothing is verified.
        """
        pending = self._shown(asked)
        await self._verifications.confirm(pending, asked.caller.principal)
        return Reply(words.SAID_SAME)

    async def differ(self, asked: CommandContext) -> Reply:
        """Somebody has compared: not the same.

        Raises:
            NotPermitted, NotUnderstood, Expired: Why that does not count.
        """
        pending = self._shown(asked)
        await self._verifications.reject(pending)
        return Reply(words.SAID_DIFFERENT)

    def _check_may_compare(self, asked: CommandContext) -> None:
        principal = asked.caller.principal
        now_ns = self._organiser.wall_ns()
        if asked.caller.is_program or not self._organiser.rights.holds(
            principal, FLEET, GRANT, now_ns
        ):
            raise NotPermitted(words.ONLY_ADMINS)

    def _shown(self, asked: CommandContext) -> PendingVerification:
        """Return which one somebody has compared, who may, where it was shown to them.

        Raises:
            NotPermitted: They may not, or not in this chat.
            NotUnderstood, Expired: It is not clear which, or it has ended.
        """
        check_command_fresh(asked.inbound, "/match")
        self._check_may_compare(asked)
        where = (asked.messenger.name, asked.inbound.chat.id)
        pending = self._meant(asked.rest.strip(), where)
        if where not in pending.shown_in:
            raise NotPermitted(words.NOT_SHOWN_HERE)
        if asked.messenger.platform == pending.messenger.platform and (
            assurance_of(asked.messenger, asked.inbound) < Assurance.E2EE_VERIFIED
        ):
            raise NotPermitted(words.NOT_SURE)
        return pending

    def _meant(self, typed: str, where: tuple[str, str]) -> PendingVerification:
        if typed:
            found = self._verifications.find(typed)
            if found is None:
                raise Expired(words.ENDED)
            return found
        here = [one for one in self._verifications.pending() if where in one.shown_in]
        if not here:
            raise Expired(words.NONE_SHOWN)
        if len(here) > 1 or self._verifications.were_shown(where, but=here[0]):
            # Another's emoji stand there, too, and nobody says which they have compared.
            raise NotUnderstood(words.SEVERAL)
        return here[0]
