"""A whole gateway with containers: on a real record, wired as the composition root does it."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

from rosic.app.containers import folders_of
from rosic.app.features import command_table
from rosic.app.gateway import Gateway
from rosic.config.profiles import known_units
from rosic.container.archive import NOBODY, Archive, MessageAuthor
from rosic.container.files import FileStore
from rosic.container.preferences import PreferenceBook, SpeedLimits
from rosic.container.shared_data import SharedData, SharedDataRights
from rosic.core.identity import Address, Caller, Principal
from rosic.core.language import CommandLine, skills_of
from rosic.core.message import Chat, ChatKind, Inbound
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.scope import FLEET
from rosic.core.signal import Deferred
from rosic.errors import Refusal
from rosic.features.files.background import BackgroundTransfer
from rosic.features.files.commands import FileCommands
from rosic.features.files.transfer import FileTransfer, TransferWays
from rosic.features.files.upload import FileUpload
from rosic.features.personal_data.archive_recorder import ArchivingMessenger
from rosic.features.personal_data.commands import register_commands, take_over
from rosic.features.personal_data.erasure import ErasureCommands, ErasureQueries
from rosic.gateway.commands import CommandContext, Reply
from rosic.gateway.container_context import ContainerContext
from rosic.organiser.timezones import zone_named
from rosic.stores.database import DatabaseStore
from rosic.stores.memory import MemoryStore
from rosic.stores.stop_latch import FileLatch
from rosic.testing.clock import ManualClock, SeededEntropy, settle
from tests.gateway.place import ADA, BO, Place
from tests.gateway.place import FLEET as ROBOTS

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterable
    from pathlib import Path

    from rosic.core.records import Memory, Record
    from rosic.core.robot.profile import Profile

LANGUAGES = {"en": ("English",), "de": ("Deutsch", "German")}


class KeepingStore(DatabaseStore):
    """Remembers what was there at opening, as the gateway is handed it."""

    memory: Memory

    async def open(self) -> Memory:
        self.memory = await super().open()
        return self.memory


class KeepingMemory(MemoryStore):
    memory: Memory

    async def open(self) -> Memory:
        self.memory = await super().open()
        return self.memory


class WardGateway(Gateway):
    """Puts containers in their place as soon as the rooms are there."""

    ward: Ward

    async def _compose(self, memory: Memory, vocabulary: Any) -> None:  # noqa: ANN401 - as handed
        await super()._compose(memory, vocabulary)
        await self.ward.set_up()


class Ward(Place):
    """Ada is admin, Bo operator, Vi viewer."""

    def __init__(
        self,
        folder: Path | None = None,
        *,
        clock: ManualClock | None = None,
        fleet: tuple[Profile, ...] = ROBOTS,
    ) -> None:
        clock = clock or ManualClock()
        self.kept: KeepingStore | KeepingMemory = (
            KeepingMemory() if folder is None else KeepingStore(folder, clock=clock)
        )
        super().__init__(self.kept, clock=clock, fleet=fleet)
        self.archive = Archive(clock)
        recorded = ArchivingMessenger(
            self.chat, self.archive, self.kept, self.author_of, lambda _: (), command_table()
        )
        parts = self.gateway._parts
        changed = {name: getattr(parts, name) for name in parts.__struct_fields__}
        changed["messengers"] = (recorded,)
        if folder is not None:
            changed["latch"] = FileLatch(folder / "latch")
        self.gateway = WardGateway(self._settings, type(parts)(**changed))
        self.gateway.ward = self
        self.serial = 0

    def author_of(self, address: Address) -> MessageAuthor:
        found = self.gateway.rooms.authoriser.directory.at(address)
        return NOBODY if found is None else MessageAuthor(found[0].id, found[0].name)

    async def set_up(self) -> None:
        """As the composition root: the books, what was so, the handlers."""
        gateway, clock = self.gateway, self.clock
        rooms, access, authority = gateway.rooms, gateway.access, gateway.authority
        directory, organiser = rooms.authoriser.directory, rooms.organiser
        skills = {p.id: skills_of(p) for p in rooms.profiles.values()}
        self.book = PreferenceBook(
            clock, SpeedLimits(skills, unit_converter(known_units())), LANGUAGES
        )
        rights = SharedDataRights(
            is_robot=rooms.profiles.__contains__,
            sees=lambda who, robot: robot in organiser.visible(who),
            works_with=lambda who, robot: organiser.holder(robot) == who,
            shown=str,
        )
        self.shelf = SharedData(clock, SeededEntropy(9), rights)
        self.data_context = ContainerContext(
            preferences=self.book,
            shelf=self.shelf,
            files=FileStore(clock),
            command_history=gateway.pipeline.command_history,
            archive=self.archive,
            container_store=self.kept,
            changes=access.changes,
            clock=clock,
            name=directory.name,
            vocabularies=rooms.vocabularies,
            shown=lambda robot: rooms.profiles[robot].shown if robot in rooms.profiles else robot,
            visible=organiser.visible,
            choices=organiser.visible,
            zone_of=lambda who: zone_named(self.book.of(who).zone or "UTC"),
            may_oversee=lambda who, _robot: who == ADA,
            may_archive=lambda who: authority.rights.holds(who, FLEET, "archive", clock.wall_ns()),
            robots=frozenset(rooms.profiles),
            find=lambda name: tuple(person.id for person in directory.named(name)),
            tell=gateway.kernel.reach.tell,
        )
        self.erasing = ErasureCommands(self.data_context, self.sides())
        commands, plain = gateway.pipeline.hooks.commands, gateway.pipeline.plain
        register_commands(commands, self.data_context, self.erasing)
        self.receiving = FileUpload(self.data_context, gateway.pipeline.answer, plain)
        gateway.pipeline.hooks.enclosed = Deferred(self.receiving.take)
        self.aside = BackgroundTransfer(gateway.pipeline.answer, plain, clock)
        ways = TransferWays(folders_of(rooms.profiles), rooms.linker.deliver, rooms.stops)
        handing = FileTransfer(
            self.data_context, organiser, rooms.profiles, ways, plain, self.aside
        )
        FileCommands(self.data_context, self.aside, handing, plain).register(commands)
        self.receiving.offer_too(handing.offer)
        take_over(self.kept.memory.facts, self.data_context, self.erasing)
        chosen = rooms.container.selected
        rooms.container.selected = lambda principal, chat: (  # type: ignore[method-assign]
            chosen(principal, chat) or self.book.of(principal).robot
        )
        await self.erasing.finish()
        await self.receiving.finish()

    def sides(self) -> ErasureQueries:
        gateway = self.gateway
        rooms, access, authority = gateway.rooms, gateway.access, gateway.authority
        directory = rooms.authoriser.directory

        def ends(principal: str, by: str) -> Iterable[Record]:
            keys = (k for k in access.keys.of(principal) if k.revoked_ns is None)
            revoked = [r for key in keys for r in access.keys.revoke(key.id, by).records]
            made = [i for i in access.enrolment.invitations.open() if i.issuer == principal]
            withdrawn = [r for i in made for r in access.enrolment.invitations.withdraw(i.id, by)]
            phone = (
                access.two_factor.reset(principal, by)
                if access.two_factor.is_set_up(principal)
                else ()
            )
            return (
                *withdrawn,
                *phone,
                *authority.grants_book.take(principal, by),
                *rooms.organiser.calendar.end_all(principal),
                *access.waiting.leave_all(principal),
                *revoked,
            )

        def forget(principal: str) -> None:
            directory.enrol(Principal(id=principal, name="somebody"))
            rooms.authoriser.forget(principal)
            rooms.container._people.pop(principal, None)

        async def ended(_: str) -> None:
            gateway.enforcer.enforce()

        def theirs(principal: str, chat: Chat) -> bool:
            person = directory.person(principal)
            return person is not None and Address(chat.platform, chat.id) in person.addresses

        return ErasureQueries(
            known=lambda who: directory.person(who) is not None,
            is_last_admin=access.is_only_admin,
            ends=ends,
            ended=ended,
            busy=gateway.pipeline.executor.busy,
            in_use=lambda robot: (
                directory.name(who) if (who := rooms.organiser.holder(robot)) else ""
            ),
            stray=lambda name: name.startswith("p-") and directory.person(name) is None,
            forget=forget,
            theirs=theirs,
        )

    def id_of(self, account: str) -> str:
        """Return the principal at an account."""
        return self.author_of(Address("memory", account)).principal

    async def quiet(self) -> None:
        """Wait until everything said is received and answered; the disk takes real time."""
        await self.chat.wait_until_received(timeout_s=30)
        for _ in range(50):
            await settle()
            if self.gateway.quiet:
                return
            await asyncio.sleep(0.002)

    async def ask(
        self,
        verb: str,
        rest: str = "",
        *,
        account: str = "1",
        kind: ChatKind = ChatKind.PRIVATE,
        act: bytes = b"",
    ) -> Reply:
        """Do a command; a refusal's sentence is a reply as well, with its offers as buttons."""
        self.serial += 1
        chat = Chat("memory", account if kind is ChatKind.PRIVATE else "g", kind)
        now_ns = self.clock.wall_ns()
        inbound = Inbound(
            sender=Address("memory", account),
            chat=chat,
            message=f"m{self.serial}",
            text=f"/{verb} {rest}",
            sent_ns=now_ns,
            received_ns=now_ns,
        )
        author = self.author_of(inbound.sender)
        caller = Caller(author.principal, author.name, inbound.sender, "k", "s")
        asked = CommandContext(self.chat, inbound, caller, rest, b"", act)
        try:
            return await self.gateway.pipeline.hooks.commands.do(CommandLine(verb, rest), asked)
        except Refusal as refusal:
            return Reply(str(refusal))

    async def file(self, verb: str, rest: str = "", **how: Any) -> str:  # noqa: ANN401 - as `ask`
        """Return what is in the file that a reply brings."""
        reply = await self.ask(verb, rest, **how)
        assert reply.attachment is not None, reply.text
        return reply.attachment.content.decode()

    async def sure(self, verb: str, rest: str, **how: Any) -> str:  # noqa: ANN401 - as `ask`
        """Do a command that asks first, and tap its first button."""
        reply = await self.ask(verb, rest, **how)
        [[yes, *_], *_] = reply.buttons or [[None]]
        if yes is None:
            return reply.text
        assert yes.command == f"/{verb} {rest}", yes
        return (await self.ask(verb, rest, act=yes.act, **how)).text

    async def said(self, verb: str, rest: str = "", **how: Any) -> str:  # noqa: ANN401 - as `ask`
        return (await self.ask(verb, rest, **how)).text


async def used(ward: Ward) -> str:
    """Let Bo use everything; return his id."""
    await ward.said("archive", "on", kind=ChatKind.GROUP)
    await ward.say("omni wave", account=BO, chat=BO)
    await ward.said("data", "omni offset = 0.3", account=BO)
    await ward.said("data", "home = bay four", account=BO)
    await ward.said("language", "de", account=BO)
    await ward.say("omni fly", account=BO, chat=BO)
    await ward.say("/book omni tomorrow 10:00 1h", account=BO, chat=BO)
    ward.chat.say("hello from the left", account=BO, chat="g", kind=ChatKind.GROUP)
    ward.chat.say("hello from the right", account=ADA, chat="g", kind=ChatKind.GROUP)
    await ward.quiet()
    return ward.id_of(BO)


@asynccontextmanager
async def a_ward(folder: Path | None = None, **how: Any) -> AsyncIterator[Ward]:  # noqa: ANN401
    """Open a gateway with containers."""
    async with Ward(folder, **how).open() as ward:
        assert isinstance(ward, Ward)
        yield ward
