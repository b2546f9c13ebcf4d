"""The handlers of people over real rooms, a messenger in memory and a clock that the test owns.

What stands for the way of a message is the shortest that can be: the doorstep, who is it, commands.
"""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from functools import partial
from typing import TYPE_CHECKING

import msgspec

from rosic.app.features import command_table
from rosic.app.people import remember
from rosic.authoriser.monotonic_clock import MonotonicWallClock
from rosic.config.profiles import known_units
from rosic.container.container import Containers
from rosic.core.identity import OPERATOR, Address, AuthorisationKey
from rosic.core.language import CommandLine, Do, LanguageReader, Vocabulary, VocabularyHolder
from rosic.core.message import Button, ChatKind, MessageValidity, Outbound
from rosic.core.policy.roles import DEFAULT_ROLES, Grant, Role, RoleRules
from rosic.core.rate_limit import RateLimit
from rosic.core.records import Enrolled, KeyIssued, Letter, PersonRecord
from rosic.core.stop_registry import StopRegistry, not_known_yet
from rosic.errors import Refusal, Unrecognised
from rosic.features.access.admin_policy import AdminPolicy
from rosic.features.access.approve import ApprovalCommands
from rosic.features.access.commands import AccessCommands, register_access_commands
from rosic.features.access.context import AccessContext
from rosic.features.access.invite import InviteCommands
from rosic.features.access.join import JoinHandler
from rosic.features.access.link_commands import AccountLinkCommands
from rosic.features.access.newcomer_chat import NewcomerChat
from rosic.features.access.profile_commands import AccountCommands, PendingRequests
from rosic.features.access.revoke_lock import AccessNotices, RevokeLockCommands
from rosic.features.access.second_factor import SecondFactorCommands
from rosic.gateway.access_registry import AccessRegistry, PlaceNames, authoriser_of, nothing_kept
from rosic.gateway.agreement import ActPart, ResolvedAct
from rosic.gateway.commands import CommandContext, CommandRegistry, Reply
from rosic.gateway.confirmation import Confirmation
from rosic.gateway.delivery.last_accounts import LastAccounts
from rosic.gateway.delivery.notifier import Notifier, nobody_to_tell
from rosic.gateway.delivery.outbox import Outbox
from rosic.gateway.delivery.redaction import SecretRedaction
from rosic.gateway.delivery.sender import ChatSender, OutgoingMessage
from rosic.gateway.policy_service import PolicyService
from rosic.gateway.replies import LEAVE
from rosic.messengers.memory import MemoryMessenger
from rosic.organiser.access_requests import AccessRequests
from rosic.organiser.grants import GRANT
from rosic.organiser.organiser import Organiser
from rosic.organiser.rate_limits import RateLimits
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, SeededEntropy, settle
from tests.gateway.place import FLEET, BrokenStore
from tests.organiser.booking import UNNAMED

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from rosic.core.message import Inbound
    from rosic.core.policy.permissions import Permissions
    from rosic.core.secret import Secret

ADA, BO, CY, DI, ED = "1", "2", "3", "4", "5"
ROLES = {
    **DEFAULT_ROLES,
    "junior": Role(scopes=("*:move", "*:read"), limits=("distance <= 1 m",)),
    "tutor": Role(scopes=("kuka1:*", "kuka1:grant", "fleet:invite"), priority=15),
    "guard": Role(scopes=("fleet:lock",)),
}


class Platform(MemoryMessenger):
    """A messenger with another name and another worth."""

    def __init__(self, clock: ManualClock, platform: str, assurance: str) -> None:
        super().__init__(platform, clock=clock)
        self.platform = platform
        self.assurance = assurance


class OneAct:
    """Resolves every line to the same act."""

    def of(self, line: Do, caller: object, *, live: bool = False) -> ResolvedAct:
        del caller, live
        return ResolvedAct(line.text, "Omni: wave", (ActPart("omni", "wave", {}, "wave"),), b"act")

    def is_current(self, act: ResolvedAct, line: Do, caller: object) -> bool:
        return self.of(line, caller) == act


class Hall:
    """Ada and Bo are admins, Cy is an operator; more are enrolled by the test.

    Attributes:
        ended: Whose leases and motion were ended, in order, and whether they were locked then.
        slots: What `/me` says about slots.
    """

    def __init__(
        self,
        store: MemoryStore | None = None,
        *,
        clock: ManualClock | None = None,
        platform: str = "telegram",
        assurance: str = "provider-readable",
        seed: int = 0,
    ) -> None:
        self.clock = clock or ManualClock()
        self.store = store or MemoryStore()
        self.chat = Platform(self.clock, platform, assurance)
        self.ended: list[tuple[str, bool]] = []
        self.slots: Sequence[str] | None = None
        self._ends: Callable[[str], Awaitable[None]] | None = None
        entropy = SeededEntropy(seed)
        self.authoriser = authoriser_of(MonotonicWallClock(self.clock), self.clock, entropy)
        self.directory = self.authoriser.directory
        rulebook = RoleRules(roles=ROLES)
        self.authority = PolicyService(rulebook, FLEET, known_units(), self.clock, lambda _who: ())
        self.stops = StopRegistry([profile.id for profile in FLEET], {}, not_known_yet())
        self.access = AccessRegistry(
            self.authoriser,
            self.authority,
            self.store,
            entropy,
            self.stops,
            PlaceNames("lab", UNNAMED),
        )
        self.changes, self.time = self.access.changes, self.access.time
        self.counters, self.locks, self.keys = (
            self.access.counters,
            self.access.locks,
            self.access.keys,
        )
        self.enrolment, self.two_factor = self.access.enrolment, self.access.two_factor
        rights = self.authority.rights
        self.organiser = Organiser(
            self.authority.in_force,
            {profile.id: profile for profile in FLEET},
            self.stops,
            self.access.state,
            rates=RateLimits(self.clock, RateLimit(), {}, rights.rates, self.store.note, str),
            lease_idle_s=30.0,
        )
        vocabularies = VocabularyHolder(Vocabulary.build(FLEET, known_units(), command_table()))
        containers = Containers(vocabularies, self.store, self.clock, {}, usual={})
        self.chat_sender = ChatSender(containers, self.clock, nobody_to_tell)
        self.outbox = Outbox(self.store, self.clock, entropy, self.chat_sender)
        self.reader = LanguageReader(vocabularies)
        self.registry = self._registry()
        self.commands = CommandRegistry(command_table())
        self._employ(entropy)
        self._names = {CY: "Cy Young", DI: "Di", ED: "Ed"}

    @property
    def rights(self) -> Permissions:
        """Return the rights in force."""
        return self.authority.rights

    def _registry(self) -> AccessContext:
        return AccessContext(
            retracting=SecretRedaction(self.clock, SeededEntropy(), self.store.note, {}),
            authoriser=self.authoriser,
            enrolment=self.enrolment,
            links=self.access.links,
            keys=self.keys,
            locks=self.locks,
            two_factor=self.two_factor,
            security=self.access.security,
            grants_book=self.authority.grants_book,
            changes=self.changes,
            reach=Notifier(
                self.authoriser,
                self.chat_sender,
                (self.chat,),
                self.outbox,
                LastAccounts(self.directory, self.store.note),
            ),
            clock=self.clock,
            rights=lambda: self.rights,
            ahead=self.access.ahead,
            ended=self.end,
        )

    def _employ(self, entropy: SeededEntropy) -> None:
        registry = self.registry
        self.admin_policy = AdminPolicy(registry)
        self.access.may_invite.bind(self.admin_policy.may_admit)
        newcomer_chat = NewcomerChat(
            self.chat_sender, (self.chat,), self.clock, entropy, count=self.counters.count
        )
        self.admitting = ApprovalCommands(
            registry, self.admin_policy, newcomer_chat, menu=self.menu, forget=nothing_kept
        )
        self.joining = JoinHandler(
            registry,
            self.admin_policy,
            self.admitting,
            newcomer_chat,
            shown_as=lambda inbound: self._names.get(inbound.sender.account, ""),
            names_robot=lambda text: text == "kuka-left",
        )
        about = AccountCommands(
            registry,
            self.admin_policy,
            PendingRequests(self.admitting, None),
            slots=lambda _: self.slots,
            shown=lambda robot: robot.upper(),
        )
        notices = AccessNotices(registry, self.admin_policy)
        revocation = RevokeLockCommands(registry, self.admin_policy, notices)
        proving = SecondFactorCommands(registry, self.admin_policy)
        inviting = InviteCommands(registry, self.admin_policy, ("memory",), link=self.link)
        self.confirmation = Confirmation(
            self.organiser, registry.reach, OneAct(), self.clock, entropy, self.two_factor.is_set_up
        )
        wanted = AccessRequests(self.clock.wall_ns, entropy)
        linking = AccountLinkCommands(registry, self.admin_policy, wanted)
        handlers = AccessCommands(about, self.admitting, revocation, inviting, proving, linking)
        register_access_commands(self.commands, handlers, self.confirmation)

    def menu(self, principal: str) -> Reply:
        robots = sorted(self.rights.visible(principal, self.clock.wall_ns()))
        row = tuple(Button(robot, f"use {robot}") for robot in robots[:2])
        return Reply("Which robot?", (row,))

    def link(self, messenger: object, code: Secret) -> str:
        return f"https://t.me/lab_bot?start={code.reveal()}" if messenger is self.chat else ""

    def revocation_ends(self, begin: Callable[[str], Awaitable[None]]) -> None:
        """Let something else happen when somebody's access ends."""
        self._ends = begin

    async def end(self, principal: str) -> None:
        if self._ends is not None:
            await self._ends(principal)
            return
        await asyncio.sleep(0)
        locked = self.locks.locked(principal) or not self.directory.has_good_key(principal)
        self.ended.append((principal, locked))
        async with self.changes.turn():  # as whoever takes somebody's slots would
            pass

    # ---- the way of a message ----

    async def receive(self, inbound: Inbound) -> None:
        try:
            reply = await self.joining.take(self.chat, inbound, inbound.text)
            if reply is None:
                reply = await self._recognised(inbound)
        except Refusal as refusal:
            rows = tuple((Button(offer, offer),) for offer in refusal.offers)
            reply = self._bound(inbound, Reply(str(refusal), rows))
        if reply.text:
            outbound = Outbound(
                chat=inbound.chat,
                text=reply.text,
                buttons=reply.buttons,
                attachment=reply.attachment,
            )
            self.chat_sender.say(OutgoingMessage(self.chat, outbound, None, inbound.under))

    def _bound(self, inbound: Inbound, reply: Reply) -> Reply:
        known = self.directory.at(inbound.sender)
        if known is None:
            return Reply(reply.text)
        issue = partial(self.authoriser.buttons.issue, principal=known[0].id, chat=inbound.chat.id)
        rows = tuple(tuple(issue(b) for b in row) for row in reply.buttons)
        return Reply(reply.text, rows, reply.attachment)

    async def _recognised(self, inbound: Inbound) -> Reply:
        try:
            caller = self.authoriser.identify(inbound)
        except Unrecognised as stranger:
            return Reply(str(stranger) if inbound.chat.kind is ChatKind.PRIVATE else "")
        text, act = inbound.text, b""
        if inbound.nonce is not None:
            tapped = self.authoriser.buttons.redeem(inbound.nonce, caller.principal, inbound)
            text, act = tapped.command, tapped.act
            await self.chat.answer_tap(inbound, "")
        if text == LEAVE:
            return Reply("Nothing was done.")
        visible = self.rights.visible(caller.principal, self.clock.wall_ns())
        (line,) = self.reader.lines(text, "", visible)
        if not isinstance(line, CommandLine):
            return Reply(f"({type(line).__name__})")
        asked = CommandContext(self.chat, inbound, caller, line.rest, b"", act)
        return self._bound(inbound, await self.commands.do(line, asked))

    @asynccontextmanager
    async def open(self) -> AsyncIterator[Hall]:
        await self._restore()
        running = asyncio.create_task(self.chat.run(self.receive))
        await settle()
        try:
            yield self
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)
            flushing = asyncio.create_task(self.chat_sender.flush(0.1))
            while not flushing.done():
                await self.clock.advance(0.02)
            await self.store.close()

    async def _restore(self) -> None:
        memory = await self.store.open()
        for principal, roles in remember(self.authoriser, memory).items():
            self.authority.grants_book.set_roles(principal, roles)
        self.authority.grants_book.restore(memory.facts.get(GRANT, ()))
        self.authority.draw_up()
        self.access.restore(memory, self.organiser)

    # ---- what people do ----

    async def knows(
        self, account: str, name: str, *roles: str, grants: tuple[Grant, ...] = ()
    ) -> str:
        """Make somebody known; return their id."""
        principal = f"p-{account}"
        address = Address(self.chat.platform, account)
        card = Letter(principal, msgspec.msgpack.encode(PersonRecord(name, (address,))))
        key = AuthorisationKey(
            id=f"k-{account}",
            principal=principal,
            issuer=OPERATOR,
            issued_ns=self.clock.wall_ns(),
        )
        async with self.changes.turn() as turn:
            await turn.write(
                (
                    Enrolled(principal=principal, roles=roles, at_ns=1, letter=card),
                    KeyIssued(key=key),
                    *(
                        self.authority.grants_book.give(principal, grants, OPERATOR)
                        if grants
                        else ()
                    ),
                )
            )
        return principal

    async def say(
        self,
        account: str,
        text: str,
        *,
        chat: str = "",
        kind: ChatKind = ChatKind.PRIVATE,
        standing: MessageValidity = MessageValidity.FRESH,
    ) -> str:
        """Say something; return what was told in that chat because of it."""
        before = len(self.chat.told)
        self.chat.say(text, account=account, chat=chat or account, kind=kind, standing=standing)
        await self.quiet()
        return self.told(chat or account, before)

    async def in_group(
        self, account: str, text: str, *, standing: MessageValidity = MessageValidity.FRESH
    ) -> str:
        return await self.say(account, text, chat="g", kind=ChatKind.GROUP, standing=standing)

    def told(self, chat: str, before: int = 0) -> str:
        """Return what a chat was told, without the oldest ``before`` things told anywhere."""
        return "\n".join(
            told.outbound.text
            for told in list(self.chat.told)[before:]
            if told.outbound.chat.id == chat
        )

    def last(self, chat: str) -> Outbound:
        """Return the newest thing told in a chat."""
        return next(t.outbound for t in reversed(self.chat.told) if t.outbound.chat.id == chat)

    def labels(self, chat: str) -> list[str]:
        return [button.label for row in self.last(chat).buttons for button in row]

    async def tap(self, account: str, label: str, *, chat: str = "") -> str:
        """Tap the newest button of a label in a chat; return what was told there."""
        button, under = self.button(chat or account, label)
        return await self.tap_again(account, button, under)

    async def tap_again(self, account: str, button: Button, under: str) -> str:
        before = len(self.chat.told)
        self.chat.tap(button, under=under, account=account)
        await self.quiet()
        return self.told(self.chat.shown(under).chat.id, before)

    def button(self, chat: str, label: str) -> tuple[Button, str]:
        for told in reversed(self.chat.told):
            if told.outbound.chat.id == chat:
                for button in (b for row in told.outbound.buttons for b in row):
                    if button.label == label:
                        return button, told.message
        raise AssertionError(f"no button {label!r} in the chat {chat}")

    async def invited(self, line: str, account: str = ADA) -> str:
        """Invite; return the code."""
        said = await self.say(account, f"/invite {line}")
        _, found, rest = said.partition("Code ")
        assert found, said
        return rest[:9]

    async def quiet(self) -> None:
        for _ in range(5):
            await settle()


@asynccontextmanager
async def a_hall(
    store: MemoryStore | None = None,
    *,
    platform: str = "telegram",
    assurance: str = "provider-readable",
) -> AsyncIterator[Hall]:
    """Open a hall in which Ada and Bo are admins and Cy is an operator."""
    async with Hall(store, platform=platform, assurance=assurance).open() as hall:
        await hall.knows(ADA, "Ada", "admin")
        await hall.knows(BO, "Bo", "admin")
        await hall.knows(CY, "Cy Young", "operator")
        yield hall


__all__ = ["ADA", "BO", "CY", "DI", "ED", "BrokenStore", "Hall", "a_hall"]
