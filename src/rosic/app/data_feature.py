"""Puts the containers in their place: settings, shelves, archives, and how they are erased."""

from __future__ import annotations

import re
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rosic.authoriser.directory import SOMEBODY
from rosic.config.translations import LANGUAGES
from rosic.container.archive import NOBODY, Archive, MessageAuthor
from rosic.container.files import FileQuota, FileStore
from rosic.container.preferences import IMPERIAL, PreferenceBook, SpeedLimits
from rosic.container.preferences import KIND as PREFERENCE
from rosic.container.shared_data import SharedData
from rosic.core.identity import Address, Principal
from rosic.core.language import skills_of
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.scope import FLEET, GRANT
from rosic.errors import Refusal
from rosic.features.access.admin_policy import everybody_called
from rosic.features.files.background import BackgroundTransfer
from rosic.features.files.commands import FileCommands
from rosic.features.files.transfer import FileTransfer, TransferWays
from rosic.features.files.upload import FileUpload
from rosic.features.personal_data.archive_recorder import ArchivingMessenger
from rosic.features.personal_data.commands import register_commands, take_over, tidy
from rosic.features.personal_data.erasure import ErasureCommands, ErasureQueries
from rosic.features.personal_data.messages import YOU
from rosic.gateway.container_context import ContainerContext
from rosic.robots.file_folders import RobotFolders

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence

    from rosic.app.access import AccessFeature
    from rosic.app.features import FeatureSetup
    from rosic.app.policy import PolicyEnforcer
    from rosic.authoriser.authoriser import Authoriser
    from rosic.container.history import CommandHistory
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import ContainerStore, Store
    from rosic.core.identity import PrincipalId
    from rosic.core.language import UnitTable, VocabularyHolder
    from rosic.core.message import Chat
    from rosic.core.records import Fact, Memory, Record
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.translation import ChatLanguages
    from rosic.gateway.robot_registry import AddedRobot
    from rosic.organiser.organiser import Organiser

PERSON = re.compile("p[0-9a-f]{16}")  # how ids of people look


class ContainerFactory(Protocol):
    """What the books are made with."""

    @property
    def units(self) -> UnitTable:
        """Return the units that people may say."""

    @property
    def entropy(self) -> Entropy:
        """Return the source of chance."""


class OwnDataQueries(NamedTuple):
    """What people have for themselves: what they set, and room for their files."""

    preferences: PreferenceBook
    room: FileQuota


class DataFeature:
    """The container room's books of one gateway.

    Attributes:
        archive: Which chats are kept.
        preferences: What people set for themselves.
        erasing: Erases somebody; None while the record cannot look into containers.
        data_context: What is kept in containers; likewise.
        receiving: Takes in files that people send; likewise.
        also_ends, also_ended: What else `ErasureQueries.ends` and `ErasureQueries.ended` ask of
            other rooms.
    """

    def __init__(
        self,
        rooms: Components,
        access: AccessFeature,
        enforcer: PolicyEnforcer,
        clock: Clock,
        languages: ChatLanguages,
        own: OwnDataQueries,
    ) -> None:
        self._room = own.room
        self.preferences = own.preferences
        self._languages = languages
        self._rooms = rooms
        self._access = access
        self._authority, self._enforcer = enforcer.policy, enforcer
        self._clock = clock
        self.data_context: ContainerContext | None = None
        self.receiving: FileUpload | None = None
        self.erasing: ErasureCommands | None = None
        self._aside: BackgroundTransfer | None = None
        self._folders = folders_of(rooms)
        self.also_ends: list[Callable[[PrincipalId], Iterable[Record]]] = []
        self.also_ended: list[Callable[[PrincipalId], Awaitable[object]]] = []

    def record(self, messengers: Sequence[Messenger], store: Store) -> tuple[Messenger, ...]:
        """Return messengers whose chats can be kept."""
        self.archive = Archive(self._clock)
        author_of = partial(_author_of, self._rooms.authoriser)
        codes_in = self._access.enrolment.invitations.shown_in
        commands = self._rooms.vocabulary.commands
        return tuple(
            ArchivingMessenger(m, self.archive, store, author_of, codes_in, commands)
            for m in messengers
        )

    async def set_up(
        self,
        pipeline: Pipeline,
        features: FeatureSetup,
        container_store: ContainerStore,
        memory: Memory,
        parts: ContainerFactory,
    ) -> None:
        """Say who keeps what, take over what was, and finish what an erasure left."""
        rooms = self._rooms
        around = DataContext(
            self.preferences,
            self._access,
            rooms.authoriser,
            rooms.organiser,
            rooms.profiles,
            rooms.vocabularies,
            self._clock,
            features.reach.tell,
            pipeline.command_history,
        )
        data_context = data_context_of(around, container_store, self.archive, parts, self._room)
        self.data_context = data_context
        erasing = self.erasing = ErasureCommands(data_context, self._sides(pipeline, features))
        commands, filing = pipeline.hooks.commands, FileCommands(data_context)
        register_commands(commands, data_context, erasing)
        filing.register(commands)
        take_over(memory.facts, data_context, erasing)
        self._follow_settings()
        if memory.facts.get(PREFERENCE):
            rooms.container.usual = self._usual
        self._access.forget_newcomer.bind(erasing.stranger)
        self.receiving = FileUpload(data_context, pipeline.answer, pipeline.plain)
        pipeline.hooks.enclosed.bind(self.receiving.take)
        self._aside = BackgroundTransfer(pipeline.answer, pipeline.plain, self._clock)
        handing = handing_of(rooms, data_context, pipeline, self._aside, self._folders)
        filing.take_time(self._aside, pipeline.plain)
        filing.hand_over(handing)
        self.receiving.offer_too(handing.offer)
        await self.receiving.finish()
        await erasing.finish()

    async def finish(self) -> None:
        """Finish erasing whoever still had an order under way, and keep what people often ask.

        Meant for every minute or so, and for the end.

        Raises:
            RecordUnavailable: Not all could be written; the rest is tried the next time.
        """
        if self.data_context is not None and (
            command_history := self.data_context.command_history.unwritten()
        ):
            async with self.data_context.changes.turn() as turn:
                await turn.write(command_history)
        if self.erasing is not None and self.erasing.unfinished:
            await self.erasing.finish()

    async def leave(self) -> None:
        """Keep what people often ask; at the end, and as far as it can be."""
        if self.receiving is not None:
            await self.receiving.close()
        if self._aside is not None:
            await self._aside.close()
        with suppress(Refusal):
            await self.finish()

    async def tidy(self) -> None:
        """Forget what was kept as long as was said; meant for once a day.

        Raises:
            RecordUnavailable: Not all was forgotten; the rest is tried the next time.
        """
        if self.data_context is not None and self.erasing is not None:
            await tidy(self.data_context, self.erasing)

    def _usual(self, principal: PrincipalId) -> str:
        return self.preferences.of(principal).robot

    def _follow_settings(self) -> None:
        """Let what people set for themselves count: a cap on their speed, their usual robot."""
        authority, preferences = self._authority, self.preferences
        for principal in authority.grants_book.everybody():
            self._speak_to(principal)

        def changed(fact: Fact) -> None:
            preferences.apply(fact)
            self._speak_to(fact.key)
            self._rooms.container.usual = self._usual
            authority.renew(fact.key)

        self._access.changes.keep(PREFERENCE, changed)

    def robot_added(self, newcomer: AddedRobot) -> None:
        """Know the folders of one more robot, and let people's own speed hold for it.

        After the rights reach it.
        """
        profile = newcomer.profile
        if profile.files is not None:
            self._folders.add_robot(profile.id, profile.files)
        if self.data_context is not None:
            for principal in self.preferences.add_robot(profile.id, skills_of(profile)):
                self._authority.renew(principal)

    def _speak_to(self, principal: PrincipalId) -> None:
        kept = self.preferences.of(principal)
        imperial = kept.units == IMPERIAL
        self._languages.choose(principal, kept.language, imperial=imperial)

    async def _break_off(self, principal: PrincipalId) -> None:
        """Let no file of somebody come or go any more."""
        if self.receiving is not None:
            await self.receiving.end(principal)
        if self._aside is not None:
            await self._aside.end(principal)

    def _sides(self, pipeline: Pipeline, features: FeatureSetup) -> ErasureQueries:
        rooms, access, authority = self._rooms, self._access, self._authority
        directory = rooms.authoriser.directory

        def ends(principal: PrincipalId, by: PrincipalId) -> Iterable[Record]:
            good = (key for key in access.keys.of(principal) if key.revoked_ns is None)
            made = [i for i in access.enrolment.invitations.open() if i.issuer == principal]
            phone = (
                access.two_factor.reset(principal, by)
                if access.two_factor.is_set_up(principal)
                else ()
            )
            return (
                *(r for i in made for r in access.enrolment.invitations.withdraw(i.id, by)),
                *phone,
                *authority.grants_book.take(principal, by),
                *access.ahead(principal),
                *features.live_cards.end_all(principal),
                *features.fleet.end_all(principal),
                *(record for end in self.also_ends for record in end(principal)),
                *(r for key in good for r in access.keys.revoke(key.id, by).records),
            )

        def forget(principal: PrincipalId) -> None:
            directory.enrol(Principal(id=principal, name=SOMEBODY))
            rooms.authoriser.forget(principal)
            rooms.container.forget(principal)
            pipeline.command_history.forget(principal)

        async def ended(principal: PrincipalId) -> None:
            self._enforcer.enforce()
            await self._break_off(principal)
            for end in self.also_ended:
                await end(principal)

        def theirs(principal: PrincipalId, chat: Chat) -> bool:
            person = directory.person(principal)
            return person is not None and Address(chat.platform, chat.id) in person.addresses

        def in_use(robot: RobotId) -> str:
            holder = rooms.organiser.holder(robot)
            return directory.name(holder) if holder else rooms.linker.presence(robot).doing

        def stray(container: str) -> bool:
            asking = {a.pending.principal for a in access.enrolment.applicants.all()}
            newcomer = PERSON.fullmatch(container) is not None and container not in asking
            return newcomer and directory.person(container) is None

        return ErasureQueries(
            known=lambda who: directory.person(who) is not None,
            is_last_admin=access.is_only_admin,
            ends=ends,
            ended=ended,
            busy=pipeline.executor.busy,
            in_use=in_use,
            stray=stray,
            forget=forget,
            theirs=theirs,
        )


def folders_of(rooms: Components) -> RobotFolders:
    """Return the folders that robots' profiles name."""
    robots = {p.id: p.files for p in rooms.profiles.values() if p.files is not None}
    return RobotFolders(robots)


def handing_of(
    rooms: Components,
    data_context: ContainerContext,
    pipeline: Pipeline,
    aside: BackgroundTransfer,
    folders: RobotFolders,
) -> FileTransfer:
    """Return the handler who brings files to robots, and robots' files to people."""
    ways = TransferWays(folders, rooms.linker.deliver, rooms.board)
    return FileTransfer(data_context, rooms.organiser, rooms.profiles, ways, pipeline.plain, aside)


def preferences_of(
    profiles: Iterable[Profile], units: UnitTable, clock: Clock, memory: Memory
) -> PreferenceBook:
    """Return what people have set for themselves: their speed is a limit of all their rights."""
    skills = {profile.id: skills_of(profile) for profile in profiles}
    preferences = PreferenceBook(clock, SpeedLimits(skills, unit_converter(units)), LANGUAGES)
    preferences.restore(memory.facts.get(PREFERENCE, ()))
    return preferences


class DataContext(NamedTuple):
    """What stands around the books of containers."""

    preferences: PreferenceBook
    access: AccessFeature
    authoriser: Authoriser
    organiser: Organiser
    profiles: Mapping[RobotId, Profile]
    vocabularies: VocabularyHolder
    clock: Clock
    tell: Callable[[tuple[PrincipalId, ...], str], object]
    command_history: CommandHistory


def data_context_of(
    around: DataContext,
    container_store: ContainerStore,
    archive: Archive,
    parts: ContainerFactory,
    room: FileQuota,
) -> ContainerContext:
    """Return the books, empty still."""
    organiser, clock, profiles = around.organiser, around.clock, around.profiles
    preferences = around.preferences
    shelf = SharedData(clock, parts.entropy)
    shelf.is_robot = profiles.__contains__
    shelf.shown = lambda owner: profiles[owner].shown if owner in profiles else YOU
    shelf.sees = lambda who, robot: robot in organiser.visible(who)
    shelf.works_with = lambda who, robot: organiser.holder(robot) == who
    calendar, place = organiser.calendar, organiser.calendar.zone_of
    calendar.zone_of = lambda who: preferences.of(who).zone or place(who)
    return ContainerContext(
        preferences=preferences,
        shelf=shelf,
        files=FileStore(clock, room),
        command_history=around.command_history,
        archive=archive,
        container_store=container_store,
        changes=around.access.changes,
        clock=clock,
        name=around.authoriser.directory.name,
        vocabularies=around.vocabularies,
        shown=lambda robot: profiles[robot].shown if robot in profiles else robot,
        visible=organiser.visible,
        choices=organiser.visible,
        zone_of=calendar.zone,
        may_archive=lambda who: organiser.rights.holds(who, FLEET, "archive", clock.wall_ns()),
        may_oversee=partial(_may_oversee, organiser),
        robots=profiles.keys(),
        find=partial(_called, around.authoriser),
        tell=around.tell,
    )


def _may_oversee(organiser: Organiser, who: PrincipalId, robot: RobotId) -> bool:
    """Whether somebody looks after people here, or gives rights on a robot."""
    now_ns, rights = organiser.wall_ns(), organiser.rights
    return rights.holds(who, FLEET, "people", now_ns) or rights.holds(who, robot, GRANT, now_ns)


def _called(authoriser: Authoriser, name: str) -> tuple[PrincipalId, ...]:
    """Return everybody with a good key who is called so, or has that id."""
    directory = authoriser.directory
    found = everybody_called(directory, name)
    return tuple(person.id for person in found if directory.has_good_key(person.id))


def _author_of(authoriser: Authoriser, address: Address) -> MessageAuthor:
    found = authoriser.directory.at(address)
    return NOBODY if found is None else MessageAuthor(found[0].id, found[0].name)
