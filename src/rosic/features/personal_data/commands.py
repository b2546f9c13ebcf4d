"""Who does which command about what is kept; who keeps which facts; what the other rooms end."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from rosic.container import (
    archive_records,
    export,
    files,
    history,
    messages,
    preferences,
    shared_data,
    shared_data_access,
)
from rosic.container.files import PART
from rosic.core.i18n import said
from rosic.core.language.command import Command, HelpEntry, HelpPage
from rosic.core.message import Button
from rosic.core.messages import ago as age_in_words
from rosic.errors import ConfigurationError, NotUnderstood, RecordUnavailable, StoreFault
from rosic.features.personal_data import erasure as erasing_of
from rosic.features.personal_data import messages as words
from rosic.features.personal_data.archive_commands import ArchiveCommands, handed_over
from rosic.features.personal_data.order_history import OrderHistory
from rosic.features.personal_data.settings import SettingsCommands
from rosic.features.personal_data.shared_data import ShareCommands
from rosic.gateway.commands import Reply, asks_first, check_private
from rosic.gateway.replies import LEAVE

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rosic.container.shared_data import SharedValue
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.features.personal_data.erasure import ErasureCommands
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.container_context import ContainerContext

COMMANDS: Final = (
    Command(
        name="settings",
        aliases=("einstellungen",),
        typed=said("/settings"),
        summary=said("Your language, units, and how you hear of things"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 90),
    ),
    Command(name="language", summary="the language in which one is answered", aliases=("sprache",)),
    Command(
        name="mydata",
        verbs={"exportieren": "export"},
        aliases=("daten",),
        typed=said("/mydata"),
        summary=said("What is kept of you"),
        help=HelpEntry(HelpPage.SHARE, 110),
    ),
    Command(
        name="forget",
        aliases=("vergessen",),
        typed=said("/forget"),
        summary="have everything erased that is kept of oneself",
    ),
    Command(
        name="history",
        aliases=("protokoll",),
        typed=said("/history"),
        summary=said("What you asked for, and what came of it"),
        help=HelpEntry(HelpPage.SEE, 40),
    ),
    Command(
        name="archive",
        verbs={"an": "on", "ein": "on", "aus": "off", "löschen": "erase", "exportieren": "export"},
        aliases=("archiv",),
        typed=said("/archive"),
        summary="keep the messages of a chat, for who may",
    ),
    Command(
        name="data",
        aliases=("werte",),
        typed=said("/data"),
        summary="small data kept with a robot or oneself",
    ),
    Command(
        name="share",
        summary="let somebody read data of one's own",
        aliases=("teilen",),
        typed=said("/share"),
        explained=True,
    ),
    Command(
        name="shelf",
        summary="what others let one read",
        aliases=("ablage",),
        typed=said("/shelf"),
        explained=True,
    ),
)


# ---- ``/data`` (storeData, getSharedData) ----

MOST_LINES = 40


class SharedDataCommands:
    """The handler of shared data. Of one's own container is spoken in private alone."""

    def __init__(self, data_context: ContainerContext) -> None:
        self._data_context = data_context
        self._shelf = data_context.shelf

    async def data(self, asked: CommandContext) -> Reply:
        """Show what a container keeps, store a value, or remove one.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        typed, principal = asked.rest.strip(), asked.caller.principal
        owner, rest = self._owner(principal, typed)
        if owner == principal:
            check_private(asked)
        if "=" not in rest:
            return Reply(self._show(principal, owner, rest))
        name, _, value = (part.strip() for part in rest.partition("="))
        async with self._data_context.changes.turn() as turn:
            if value:
                await turn.write(self._shelf.store(principal, owner, name, value))
                return Reply(words.DATA_STORED)
            await turn.write(self._shelf.remove(principal, owner, name))
        return Reply(words.DATA_REMOVED)

    def _owner(self, principal: PrincipalId, typed: str) -> tuple[str, str]:
        """Return whose container is meant, and what else was said."""
        first, _, rest = typed.partition(" ")
        if first in self._data_context.visible(principal):
            return first, rest.strip()
        if typed and "=" not in typed and not self._mine(principal, typed):
            raise NotUnderstood(words.HOW_TO_KEEP, offers=("/data",))
        return principal, typed

    def _mine(self, principal: PrincipalId, name: str) -> bool:
        return bool(self._shelf.history(principal, principal, name))

    def _show(self, principal: PrincipalId, owner: str, name: str) -> str:
        shown = words.YOU if owner == principal else self._data_context.shown(owner)
        found = (
            self._shelf.history(principal, owner, name)
            if name
            else self._shelf.names(principal, owner)
        )
        if not found:
            return messages.nothing_kept(shown, name)
        return messages.kept_lines(shown, [*map(self._line, found[-MOST_LINES:])])

    def _line(self, kept: SharedValue) -> str:
        age_s = (self._data_context.clock.wall_ns() - kept.at_ns) / 1e9
        sender, ago = self._data_context.name(kept.sender), age_in_words(age_s)
        return messages.kept_line(kept.name, kept.value, sender, ago)


# ---- ``/mydata`` and ``/forget me`` ----

EXPORT = "export"
ME = frozenset({"me", "myself", "mich", "my data", "mydata"})
SURE = b"forget me"
FILE = "my-data"


class MyDataCommands:
    """The handler of everybody's own container; answers nobody about another's (I11)."""

    def __init__(self, data_context: ContainerContext, erasing: ErasureCommands) -> None:
        self._data_context = data_context
        self._erasing = erasing

    async def my_data(self, asked: CommandContext) -> Reply:
        """Say what is kept, or show it.

        Raises:
            Refusal: Others read along, or it cannot be read now.
        """
        check_private(asked)
        verb, *forms = asked.rest.casefold().split() or [""]
        verb = self._data_context.vocabulary.commands.verb("mydata", verb)
        form = forms[0] if forms else "jsonl"
        if verb not in {"", EXPORT} or len(forms) > 1 or form not in export.ENDINGS:
            raise NotUnderstood(words.HOW_TO_FORGET, offers=("/mydata", f"/mydata {EXPORT}"))
        if verb == EXPORT:
            return await self._export(asked, form)
        found = await self._container_facts(asked.caller.principal)
        row = (Button(words.EXPORT, f"/mydata {EXPORT}"), Button(words.FORGET, "/forget me"))
        count, size = self._data_context.files.used(asked.caller.principal)
        inside = (export.ContainerSummary(PART, count, size),) if count else ()
        return Reply(words.my_data((*export.summary(found), *inside)), (row,))

    async def _export(self, asked: CommandContext, form: str) -> Reply:
        command = f"{words.TO_EXPORT} {asked.caller.principal}"
        if form == "xlsx" and not asked.messenger.file_bytes:
            return Reply(words.spreadsheet_later(command))
        found = await self._container_facts(asked.caller.principal)
        try:
            things = map(export.thing_of, found)
            made = await asyncio.to_thread(export.container_as, form, things)
        except ConfigurationError as missing:
            raise NotUnderstood(str(missing)) from missing
        return handed_over(asked, f"{FILE}.{export.ENDINGS[form]}", made, command)

    async def _container_facts(self, principal: PrincipalId) -> tuple[Fact, ...]:
        try:
            return await self._data_context.container_store.container_facts(principal)
        except StoreFault as fault:
            raise RecordUnavailable(words.NOT_READABLE) from fault

    async def forget(self, asked: CommandContext) -> Reply:
        """Ask once, then erase whoever asks.

        Raises:
            Refusal: Others read along, somebody else is meant, the last admin, or it cannot be
                written.
        """
        check_private(asked)
        typed, principal = " ".join(asked.rest.casefold().split()), asked.caller.principal
        if typed in ME and asked.act == SURE:
            erased = await self._erasing.erase(principal, principal)
            return Reply(words.FORGOTTEN if erased.at_rest else words.FORGOTTEN_MOVING)
        if typed not in ME:
            raise NotUnderstood(words.ONLY_ME if typed else words.HOW_TO_FORGET)
        self._erasing.check(principal, principal)
        yes = Button(words.YES_FORGET, "/forget me", act=SURE)
        return asks_first(words.SURE, ((yes,), (Button(words.LEAVE_IT, LEAVE),)))


def register_commands(
    commands: CommandRegistry, data_context: ContainerContext, erasing: ErasureCommands
) -> OrderHistory:
    """Let what people ask about what is kept be done: settings, mydata, history, archive, ...

    Returns:
        Who reads what was asked before.
    """
    settings, mine = SettingsCommands(data_context), MyDataCommands(data_context, erasing)
    commands.register("settings", settings.settings)
    commands.register("language", settings.language)
    commands.register("mydata", mine.my_data)
    commands.register("forget", mine.forget)
    history = OrderHistory(data_context)
    commands.register("history", history.history)
    commands.register("archive", ArchiveCommands(data_context).archive)
    commands.register("data", SharedDataCommands(data_context).data)
    sharing = ShareCommands(data_context)
    commands.register("share", sharing.share)
    commands.register("shelf", sharing.shelf)
    return history


def keepers(
    data_context: ContainerContext, erasing: ErasureCommands
) -> Mapping[str, Callable[[Fact], object]]:
    """Return who keeps which kind of fact."""
    return {**books_kept(data_context), erasing_of.KIND: erasing.apply}


def books_kept(data_context: ContainerContext) -> Mapping[str, Callable[[Fact], object]]:
    """Return which book keeps which kind. A switch comes before the entries of its chat."""
    return {
        preferences.KIND: data_context.preferences.apply,
        history.KIND: data_context.command_history.apply,
        shared_data.KIND: data_context.shelf.apply,
        shared_data_access.LOAN: data_context.shelf.apply,
        shared_data.QUOTA: data_context.shelf.apply,
        files.KIND: data_context.files.apply,
        files.PART: lambda _: None,  # content stays on the disk
        archive_records.SWITCH: data_context.archive.apply,
        archive_records.ENTRY: data_context.archive.apply,
    }


def take_over(
    facts: Mapping[str, tuple[Fact, ...]], data_context: ContainerContext, erasing: ErasureCommands
) -> None:
    """Take over what earlier runs wrote, and say who keeps it from now on."""
    for kind, apply in keepers(data_context, erasing).items():
        for fact in facts.get(kind, ()):
            apply(fact)
        data_context.changes.keep(kind, apply)


# ---- once a day ----

log = logging.getLogger("rosic.personal_data")


async def tidy(data_context: ContainerContext, erasing: ErasureCommands) -> int:
    """Forget entries of archives that are too old, and finish erasing. Return how many entries.

    Goes in small steps, so that other changes pass between them.

    Raises:
        RecordUnavailable: Not all were forgotten; the rest is tried the next time.
    """
    await erasing.finish()
    try:
        await erasing.strays()
    except StoreFault:
        log.exception("not everything of people who were not let in could be erased")
    total = 0
    while True:
        async with data_context.changes.turn() as turn:
            facts = data_context.archive.outdated()
            await turn.write(facts)
        if not facts:
            return total
        total += len(facts)
