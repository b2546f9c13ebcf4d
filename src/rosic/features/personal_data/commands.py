"""Who does which errand about what is kept; who keeps which facts; what the other rooms end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.container import (
    archive_records,
    files,
    history,
    preferences,
    shared_data,
    shared_data_access,
)
from rosic.features.files.commands import FileCommands
from rosic.features.personal_data import erasure as erasing_of
from rosic.features.personal_data.archive_commands import ArchiveCommands
from rosic.features.personal_data.keeping import SharedDataCommands
from rosic.features.personal_data.my_data import MyDataCommands
from rosic.features.personal_data.order_history import OrderHistory
from rosic.features.personal_data.settings import SettingsCommands
from rosic.features.personal_data.shared_data import ShareCommands

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.core.records import Fact
    from rosic.features.personal_data.context import ContainerContext
    from rosic.features.personal_data.erasure import ErasureCommands
    from rosic.gateway.office import CommandRegistry


def employ_clerks(
    office: CommandRegistry, holdings: ContainerContext, erasing: ErasureCommands
) -> FileCommands:
    """Let what people ask about what is kept be done: settings, mydata, history, files, ..."""
    settings, mine = SettingsCommands(holdings), MyDataCommands(holdings, erasing)
    office.employ("settings", settings.settings)
    office.employ("language", settings.language)
    office.employ("mydata", mine.my_data)
    office.employ("forget", mine.forget)
    office.employ("history", OrderHistory(holdings).history)
    office.employ("archive", ArchiveCommands(holdings).archive)
    office.employ("data", SharedDataCommands(holdings).data)
    sharing = ShareCommands(holdings)
    office.employ("share", sharing.share)
    office.employ("shelf", sharing.shelf)
    filing = FileCommands(holdings)
    office.employ("files", filing.files)
    return filing


def keepers(
    holdings: ContainerContext, erasing: ErasureCommands
) -> Mapping[str, Callable[[Fact], object]]:
    """Return who keeps which kind of fact."""
    return {**books_kept(holdings), erasing_of.KIND: erasing.apply}


def books_kept(holdings: ContainerContext) -> Mapping[str, Callable[[Fact], object]]:
    """Return which book keeps which kind. A switch comes before the entries of its chat."""
    return {
        preferences.KIND: holdings.preferences.apply,
        history.KIND: holdings.habits.apply,
        shared_data.KIND: holdings.shelf.apply,
        shared_data_access.LOAN: holdings.shelf.apply,
        shared_data.QUOTA: holdings.shelf.apply,
        files.KIND: holdings.files.apply,
        files.PART: lambda _: None,  # content stays on the disk
        archive_records.SWITCH: holdings.archive.apply,
        archive_records.ENTRY: holdings.archive.apply,
    }


def take_over(
    facts: Mapping[str, tuple[Fact, ...]], holdings: ContainerContext, erasing: ErasureCommands
) -> None:
    """Take over what earlier runs wrote, and say who keeps it from now on."""
    for kind, apply in keepers(holdings, erasing).items():
        for fact in facts.get(kind, ()):
            apply(fact)
        holdings.changes.keep(kind, apply)
