"""Who does which errand about what is kept; who keeps which facts; what the other rooms end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.container import archived, drawer, habits, lending, preferences, shelf
from rosic.pipeline.containers import erasing as erasing_of
from rosic.pipeline.containers.archiving import Archiving
from rosic.pipeline.containers.history import History
from rosic.pipeline.containers.keeping import Keeping
from rosic.pipeline.containers.mine import Mine
from rosic.pipeline.containers.settings import Settings
from rosic.pipeline.containers.sharing import Sharing
from rosic.pipeline.files.clerk import Filing

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.core.record import Fact
    from rosic.pipeline.containers.erasing import Erasing
    from rosic.pipeline.containers.parts import Holdings
    from rosic.pipeline.office import Office


def employ_clerks(office: Office, holdings: Holdings, erasing: Erasing) -> Filing:
    """Let what people ask about what is kept be done: settings, mydata, history, files, ..."""
    settings, mine = Settings(holdings), Mine(holdings, erasing)
    office.employ("settings", settings.settings)
    office.employ("language", settings.language)
    office.employ("mydata", mine.my_data)
    office.employ("forget", mine.forget)
    office.employ("history", History(holdings).history)
    office.employ("archive", Archiving(holdings).archive)
    office.employ("data", Keeping(holdings).data)
    sharing = Sharing(holdings)
    office.employ("share", sharing.share)
    office.employ("shelf", sharing.shelf)
    filing = Filing(holdings)
    office.employ("files", filing.files)
    return filing


def keepers(holdings: Holdings, erasing: Erasing) -> Mapping[str, Callable[[Fact], object]]:
    """Return who keeps which kind of fact."""
    return {**books_kept(holdings), erasing_of.KIND: erasing.apply}


def books_kept(holdings: Holdings) -> Mapping[str, Callable[[Fact], object]]:
    """Return which book keeps which kind. A switch comes before the entries of its chat."""
    return {
        preferences.KIND: holdings.preferences.apply,
        habits.KIND: holdings.habits.apply,
        shelf.KIND: holdings.shelf.apply,
        lending.LOAN: holdings.shelf.apply,
        shelf.QUOTA: holdings.shelf.apply,
        drawer.KIND: holdings.files.apply,
        drawer.PART: lambda _: None,  # content stays on the disk
        archived.SWITCH: holdings.archive.apply,
        archived.ENTRY: holdings.archive.apply,
    }


def take_over(facts: Mapping[str, tuple[Fact, ...]], holdings: Holdings, erasing: Erasing) -> None:
    """Take over what earlier runs wrote, and say who keeps it from now on."""
    for kind, apply in keepers(holdings, erasing).items():
        for fact in facts.get(kind, ()):
            apply(fact)
        holdings.changes.keep(kind, apply)
