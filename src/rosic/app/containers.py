"""What is kept in containers, put together: for a gateway that runs, and for the data alone."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rosic.config.plugins import LANGUAGES
from rosic.container.archive import NOBODY, Archive, MessageAuthor
from rosic.container.files import FileQuota, FileStore
from rosic.container.preferences import KIND as PREFERENCE
from rosic.container.preferences import PreferenceBook, SpeedLimits
from rosic.container.shared_data import SharedData, SharedDataRights
from rosic.core.language import skills_of
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.scope import FLEET, GRANT
from rosic.features.personal_data.archive_recorder import ArchivingMessenger
from rosic.features.personal_data.messages import YOU
from rosic.gateway.container_context import ContainerContext
from rosic.robots.file_folders import RobotFolders

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rosic.app.settings import GatewayParts
    from rosic.authoriser.authoriser import Authoriser
    from rosic.container.history import CommandHistory
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger
    from rosic.contracts.store import ContainerStore
    from rosic.core.identity import Address, PrincipalId
    from rosic.core.language import UnitTable, VocabularyHolder
    from rosic.core.records import Memory
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.gateway.access_registry import AccessRegistry
    from rosic.gateway.components import Components
    from rosic.organiser.organiser import Organiser


class ContainerFactory(Protocol):
    """What the books are made with."""

    @property
    def entropy(self) -> Entropy:
        """Return the source of chance."""


def folders_of(profiles: Mapping[RobotId, Profile]) -> RobotFolders:
    """Return the folders that robots' profiles name."""
    return RobotFolders({p.id: p.files for p in profiles.values() if p.files is not None})


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
    access: AccessRegistry
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
    rights = SharedDataRights(
        is_robot=profiles.__contains__,
        sees=lambda who, robot: robot in organiser.visible(who),
        works_with=lambda who, robot: organiser.holder(robot) == who,
        shown=lambda owner: profiles[owner].shown if owner in profiles else YOU,
    )
    shelf = SharedData(clock, parts.entropy, rights)
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
        zone_of=organiser.calendar.zone,
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
    found = directory.called(name)
    return tuple(person.id for person in found if directory.has_good_key(person.id))


def _author_of(authoriser: Authoriser, address: Address) -> MessageAuthor:
    """Return who is at an address, as archives name them; nobody for a stranger."""
    found = authoriser.directory.at(address)
    return NOBODY if found is None else MessageAuthor(found[0].id, found[0].name)


def recorded(
    parts: GatewayParts,
    archive: Archive,
    rooms: Components,
    codes_in: Callable[[str], tuple[str, ...]],
) -> tuple[Messenger, ...]:
    """Return messengers whose chats can be kept.

    Args:
        parts: The messengers, and the store that keeps.
        archive: Knows which chats are kept.
        rooms: Know who writes.
        codes_in: Returns the codes of invitations that stand in a text; they are not kept.
    """
    author_of = partial(_author_of, rooms.authoriser)
    commands = rooms.vocabulary.commands
    return tuple(
        ArchivingMessenger(each, archive, parts.store, author_of, codes_in, commands)
        for each in parts.messengers
    )
