"""``/archive``: whether the messages of this chat are kept, and how they are taken out."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from rosic.container import archive_records, export
from rosic.container.archive import DAYS
from rosic.container.messages import NOT_ON
from rosic.core.i18n import joined
from rosic.core.message import Attachment, Button
from rosic.core.records import Decided
from rosic.errors import (
    ConfigurationError,
    NotPermitted,
    NotUnderstood,
    RecordUnavailable,
    StoreFault,
)
from rosic.features.personal_data import messages as words
from rosic.gateway.commands import Reply, asks_first
from rosic.gateway.replies import LEAVE
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rosic.container.archive_records import ChatKey
    from rosic.contracts.store import ContainerStore
    from rosic.core.records import Fact
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext


# ---- sending an export ----

ROOM: Final = 3_400  # characters of an export that fit into a message, with what is said about it
MEDIA: Final[Mapping[str, str]] = {
    "ics": "text/calendar",
    "jsonl": "application/x-ndjson",
    "txt": "text/plain",
    "xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}


def handed_over(asked: CommandContext, name: str, content: str | bytes, command: str) -> Reply:
    """Return the file where the messenger sends files so large, else the newest lines of it.

    Args:
        asked: Who asked, through which messenger.
        name: Of the file.
        content: What is in it.
        command: How the operator gets it all.
    """
    if not content:
        return Reply(words.NOTHING_KEPT)
    whole = content.encode() if isinstance(content, str) else content
    if len(whole) <= asked.messenger.file_bytes:
        media = MEDIA.get(name.rpartition(".")[2], "application/octet-stream")
        attachment = Attachment(name, media, whole)
        return Reply(words.handed_over(name, len(whole)), attachment=attachment)
    if isinstance(content, bytes):
        return Reply(words.too_large_a_file(len(whole), command))
    return Reply(newest(content.splitlines(), ROOM, command))


def newest(lines: Sequence[str], room: int, command: str) -> str:
    """Return the newest lines that fit into a message, and what to do about the rest."""
    shown: list[str] = []
    for line in reversed(lines):
        room -= len(line) + 1
        if room < 0:
            shown.append(words.rest_left_out(len(lines) - len(shown), command))
            break
        shown.append(line)
    return joined("\n", [words.NO_FILES_HERE, *reversed(shown)])


# ---- ``/archive`` ----

SURE = b"erase this archive"
PAGE: Final = 500
TEXT = "text"
DAYS_TYPED: Final = frozenset({"", "day", "days", "tag", "tage", "tagen"})


class ArchiveCommands:
    """The handler of archives. Whoever is in a chat may ask; admins decide."""

    def __init__(self, data_context: ContainerContext) -> None:
        self._data_context = data_context
        self._archive = data_context.archive

    async def archive(self, asked: CommandContext) -> Reply:
        """Say whether this chat is kept, or change it, or show what is kept.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        said = asked.rest.casefold().split()
        if not said:
            return self._state(asked)
        if not self._data_context.may_archive(asked.caller.principal):
            raise NotPermitted(words.NOT_YOURS)
        verb = self._data_context.vocabulary.commands.verb("archive", said[0])
        if verb == "on":
            return await self._begin(asked, said[1:])
        if verb == "off" and len(said) == 1:
            return await self._end(asked)
        if verb == "erase" and len(said) == 1:
            return await self._erase(asked, sure=asked.act == SURE)
        if verb == "export" and len(said) <= 2:  # noqa: PLR2004 - the word and the form
            return await self._export(asked, said[1] if len(said) > 1 else TEXT)
        raise NotUnderstood(words.HOW_TO_ARCHIVE, offers=("/archive",))

    def _state(self, asked: CommandContext) -> Reply:
        known = self._archive.state(asked.inbound.chat)
        if known is None or not known.switch.on:
            return Reply(words.archive_off(0 if known is None else len(known.entries)))
        zone = self._data_context.zone_of(asked.caller.principal)
        since = moment(known.switch.at_ns, self._data_context.clock.wall_ns(), zone)
        name, count = self._data_context.name(known.switch.by), len(known.entries)
        return Reply(words.archive_on(name, since, known.switch.days, count, known.size))

    async def _begin(self, asked: CommandContext, said: Sequence[str]) -> Reply:
        days, by = _days(said), asked.caller.principal
        async with self._data_context.changes.turn() as turn:
            await turn.write(
                self._archive.begin(asked.messenger.name, asked.inbound.chat, by, days=days)
            )
        return Reply(words.begun(self._data_context.name(by), days))

    async def _end(self, asked: CommandContext) -> Reply:
        by = asked.caller.principal
        async with self._data_context.changes.turn() as turn:
            await turn.write(self._archive.end(asked.inbound.chat, by))
        known = self._archive.state(asked.inbound.chat)
        days = DAYS if known is None else known.switch.days
        return Reply(words.ended(self._data_context.name(by), days))

    async def _erase(self, asked: CommandContext, *, sure: bool) -> Reply:
        key = archive_records.chat_key(asked.inbound.chat)
        if self._archive.state(asked.inbound.chat) is None:
            raise NotUnderstood(NOT_ON)
        if not sure:
            yes = Button(words.YES_ERASE, "/archive erase", act=SURE)
            return asks_first(words.ERASE_SURE, ((yes, Button(words.LEAVE_IT, LEAVE)),))
        async with self._data_context.changes.turn() as turn:
            now_ns, by = self._data_context.clock.wall_ns(), asked.caller.principal
            decided = Decided(act="erase-archive", by=by, about=key, at_ns=now_ns)
            await turn.write((decided, *self._archive.drop(key)))
        return Reply(words.ARCHIVE_ERASED)

    async def _export(self, asked: CommandContext, form: str) -> Reply:
        if form not in export.ENDINGS:
            raise NotUnderstood(words.HOW_TO_ARCHIVE, offers=("/archive export text",))
        chat = asked.inbound.chat
        command = (
            f"{words.TO_EXPORT} {archive_records.container_of(archive_records.chat_key(chat))}"
        )
        if form == "xlsx" and not asked.messenger.file_bytes:
            return Reply(words.spreadsheet_later(command))
        try:
            found = await rows_of(
                self._data_context.container_store, archive_records.chat_key(chat)
            )
        except StoreFault as fault:
            raise RecordUnavailable(words.NOT_READABLE) from fault
        if not found:
            return Reply(words.NO_MESSAGES)
        try:
            made = await asyncio.to_thread(export.archive_as, form, found)
        except ConfigurationError as missing:
            raise NotUnderstood(str(missing)) from missing
        return handed_over(asked, f"messages.{export.ENDINGS[form]}", made, command)


def _days(said: Sequence[str]) -> int:
    """Return for how long messages are to be kept: ``30``, ``30 days``; nothing is the default.

    Raises:
        NotUnderstood: It is no number of days.
    """
    if not said:
        return DAYS
    unit = " ".join(said[1:])
    if not (said[0].isascii() and said[0].isdecimal()) or unit not in DAYS_TYPED:
        raise NotUnderstood(words.HOW_TO_ARCHIVE, offers=("/archive on",))
    return int(said[0][:6])


async def all_facts(container_store: ContainerStore, kind: str, prefix: str) -> tuple[Fact, ...]:
    """Return every fact of a kind whose key begins so; in pages, so that writes pass between.

    Raises:
        StoreFault: They cannot be read now.
    """
    found: list[Fact] = []
    after = prefix
    while True:
        page = await container_store.facts(kind, after, PAGE)
        ours = [fact for fact in page if fact.key.startswith(prefix)]
        found += ours
        if len(ours) < PAGE:
            return tuple(found)
        after = page[-1].key


async def rows_of(container_store: ContainerStore, key: ChatKey) -> list[export.ArchiveRow]:
    """Return every entry of an archive, in order.

    Raises:
        StoreFault: They cannot be read now.
    """
    found = await all_facts(container_store, archive_records.ENTRY, f"{key}.")
    return await asyncio.to_thread(export.rows, found)  # many of them: a stop does not wait
