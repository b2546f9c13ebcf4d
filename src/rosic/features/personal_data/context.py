"""What the clerks of containers work with, as the composition root made it."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Set as AbstractSet
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import msgspec

from rosic.container.archive import Archive
from rosic.container.files import FileStore
from rosic.container.history import CommandHistory
from rosic.container.preferences import PreferenceBook
from rosic.container.shared_data import SharedData
from rosic.contracts.clock import Clock
from rosic.core.identity import PrincipalId
from rosic.core.language import Vocabulary
from rosic.core.robot.profile import RobotId
from rosic.gateway.transactions import Transactions
from rosic.organiser.timezones import Zone

if TYPE_CHECKING:
    from rosic.core.history import HistoryEntry, HistoryQuery
    from rosic.core.records import Fact

PAGE = 500


@runtime_checkable
class ContainerStore(Protocol):
    """What a record owes to whoever looks into containers; both stores keep it.

    Every method raises StoreFault when the record cannot be read now, or changed.
    """

    async def facts(self, kind: str, after: str, limit: int) -> tuple[Fact, ...]:
        """Return at most so many facts of a kind, by key, from behind a key on."""
        ...

    async def belongings(self, container: str) -> tuple[Fact, ...]:
        """Return everything in a container, unsealed."""
        ...

    async def history(self, query: HistoryQuery) -> tuple[HistoryEntry, ...]:
        """Return commands, the newest first."""
        ...

    async def containers(self) -> tuple[str, ...]:
        """Return whose containers there are."""
        ...

    async def shred(self, container: str) -> None:
        """Erase the key of a container; doing it again is safe."""
        ...


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
    habits: CommandHistory
    archive: Archive
    vault: ContainerStore
    changes: Transactions
    clock: Clock
    name: Callable[[PrincipalId], str]
    vocabulary: Vocabulary
    shown: Callable[[RobotId], str]
    visible: Callable[[PrincipalId], frozenset[RobotId]]
    choices: Callable[[PrincipalId], frozenset[str]]
    zone_of: Callable[[PrincipalId], Zone]
    may_archive: Callable[[PrincipalId], bool]
    may_oversee: Callable[[PrincipalId, RobotId], bool]
    robots: AbstractSet[RobotId]
    find: Callable[[str], tuple[PrincipalId, ...]] = _nobody
    tell: Callable[[tuple[PrincipalId, ...], str], object] = _silence


async def all_facts(vault: ContainerStore, kind: str, prefix: str) -> tuple[Fact, ...]:
    """Return every fact of a kind whose key begins so; in pages, so that writes pass between.

    Raises:
        StoreFault: They cannot be read now.
    """
    found: list[Fact] = []
    after = prefix
    while True:
        page = await vault.facts(kind, after, PAGE)
        ours = [fact for fact in page if fact.key.startswith(prefix)]
        found += ours
        if len(ours) < PAGE:
            return tuple(found)
        after = page[-1].key
