"""``/files``: what I keep of my own; getting it back, deleting it."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.container import file_messages as words
from rosic.container.files import attachment_of
from rosic.core.i18n import said
from rosic.core.language.command import Command, HelpEntry, HelpPage
from rosic.core.message import Button
from rosic.core.messages import ago as age_in_words
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.features.files.background import send_file
from rosic.gateway.button_rows import rows
from rosic.gateway.commands import Reply, check_private

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.container.files import StoredFile
    from rosic.features.files.background import BackgroundTransfer
    from rosic.features.files.transfer import FileTransfer
    from rosic.features.files.upload import Plain
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.container_context import ContainerContext

COMMANDS: Final = (
    Command(
        name="files",
        aliases=("dateien",),
        typed=said("/files"),
        summary=said("Files for robots and of robots"),
        help=HelpEntry(HelpPage.SHARE, 100),
    ),
)


Part: TypeAlias = "Callable[[CommandContext, str], Awaitable[Reply]]"

MOST_BUTTONS: Final = 8


class FileCommands:
    """The handler of everybody's own files; in private alone.

    Args:
        aside: Brings large files beside the chat.
        handing: Brings files to robots, and files of robots to people.
        plain: Returns a text as it is read where a message came from.

    Attributes:
        further: Who does what else may be said after ``/files``, by its first word.
    """

    def __init__(
        self,
        data_context: ContainerContext,
        aside: BackgroundTransfer,
        handing: FileTransfer,
        plain: Plain,
    ) -> None:
        self._data_context = data_context
        self._aside = aside
        self._plain = plain
        self.further: dict[str, Part] = {
            "get": self._get,
            "holen": self._get,
            "delete": self._delete,
            "löschen": self._delete,
            "send": handing.send,
            "senden": handing.send,
            "put": handing.put,
            "from": handing.fetch,
            "von": handing.fetch,
        }

    def register(self, commands: CommandRegistry) -> None:
        """Take the command."""
        commands.register("files", self.files)

    async def files(self, asked: CommandContext) -> Reply:
        """List, hand over, delete.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        check_private(asked)
        verb, _, rest = asked.rest.strip().partition(" ")
        if not verb:
            return self._list(asked)
        part = self.further.get(verb.casefold())
        if part is None or not rest.strip():
            raise NotUnderstood(words.HOW, offers=("/files",))
        return await part(asked, rest.strip())

    def _list(self, asked: CommandContext) -> Reply:
        files, owner = self._data_context.files, asked.caller.principal
        found = files.of(owner)
        limits = words.limits(asked.messenger.fetch_bytes, asked.messenger.file_bytes)
        if not found:
            return Reply(words.none_kept(limits))
        buttons = [Button(one.name, f"/files get {one.name}") for one in found[:MOST_BUTTONS]]
        used, most = files.used(owner)[1], files.room.person_bytes
        text = words.listing(map(self._line, found), used, most, limits)
        return Reply(text, rows(buttons))

    def _line(self, one: StoredFile) -> str:
        ago = age_in_words((self._data_context.clock.wall_ns() - one.at_ns) / 1e9)
        return words.line(one.name, one.sort, one.size, ago, one.digest)

    async def _get(self, asked: CommandContext, name: str) -> Reply:
        filed = self._data_context.files.find(asked.caller.principal, name)
        most = asked.messenger.file_bytes
        if filed.size > most:
            raise OutOfBounds(words.too_large_to_send(filed.name, filed.size, most))
        attachment = await attachment_of(self._data_context.container_store, filed)
        text = words.handed(filed.name, filed.size, filed.digest)
        if attachment.pieces is None:
            return Reply(text, attachment=attachment)
        return self._aside.begin(
            asked,
            partial(send_file, asked, self._plain, attachment, text),
            partial(words.sending, filed.name, filed.size),
        )

    async def _delete(self, asked: CommandContext, name: str) -> Reply:
        data_context = self._data_context
        async with data_context.changes.turn() as turn:
            filed = data_context.files.find(asked.caller.principal, name)
            await turn.write(data_context.files.drop(filed.id))
        return Reply(words.deleted(filed.name))
