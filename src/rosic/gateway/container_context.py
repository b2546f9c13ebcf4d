"""What is asked of containers is done with this, as the composition root made it."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Set as AbstractSet

import msgspec

from rosic.container.archive import Archive
from rosic.container.files import FileStore
from rosic.container.history import CommandHistory
from rosic.container.preferences import PreferenceBook
from rosic.container.shared_data import SharedData
from rosic.contracts.clock import Clock
from rosic.contracts.store import ContainerStore
from rosic.core.identity import PrincipalId
from rosic.core.language import Vocabulary, VocabularyHolder
from rosic.core.robot.profile import RobotId
from rosic.gateway.transactions import Transactions
from rosic.organiser.timezones import Zone


def _nobody(_name: str) -> tuple[PrincipalId, ...]:
    return ()


def _silence(_people: tuple[PrincipalId, ...], _text: str) -> None:
    return None


class ContainerContext(msgspec.Struct, frozen=True, kw_only=True):
    """The container room's books, and what the other rooms say about people and robots.

    Attributes:
        name: How a principal is shown.
        shown: How a robot is shown; any other name as it is.
        visible: The robots that somebody may see.
        choices: What may be meant when none is named: their robots and groups.
        zone_of: Where somebody reads times.
        may_archive: Whether somebody decides about archives.
        may_oversee: Whether somebody may read what others asked of a robot.
        robots: Every robot's id.
        find: Returns who is called so, or has that id.
        tell: Tells people something they have not just asked for.
    """

    preferences: PreferenceBook
    shelf: SharedData
    files: FileStore
    command_history: CommandHistory
    archive: Archive
    container_store: ContainerStore
    changes: Transactions
    clock: Clock
    name: Callable[[PrincipalId], str]
    vocabularies: VocabularyHolder
    shown: Callable[[RobotId], str]
    visible: Callable[[PrincipalId], frozenset[RobotId]]
    choices: Callable[[PrincipalId], frozenset[str]]
    zone_of: Callable[[PrincipalId], Zone]
    may_archive: Callable[[PrincipalId], bool]
    may_oversee: Callable[[PrincipalId, RobotId], bool]
    robots: AbstractSet[RobotId]
    find: Callable[[str], tuple[PrincipalId, ...]] = _nobody
    tell: Callable[[tuple[PrincipalId, ...], str], object] = _silence

    @property
    def vocabulary(self) -> Vocabulary:
        """What can be said now; not to be kept, as it may be replaced."""
        return self.vocabularies.current
