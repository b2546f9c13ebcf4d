"""``/files``: what I keep of my own; getting it back, deleting it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.container import words_files as words
from rosic.container.words_container import age
from rosic.core.message import Attachment, Button
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.pipeline.desk import Reply, rows
from rosic.pipeline.files.reading import content_of
from rosic.pipeline.office import check_private

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rosic.container.drawer import Filed
    from rosic.pipeline.containers.parts import Holdings
    from rosic.pipeline.files.handing import Handing
    from rosic.pipeline.office import Asked

Part: TypeAlias = "Callable[[Asked, str], Awaitable[Reply]]"

MOST_BUTTONS: Final = 8


class Filing:
    """The clerk of everybody's own files; in private alone.

    Attributes:
        further: Who does what else may be said after ``/files``, by its first word.
    """

    def __init__(self, holdings: Holdings) -> None:
        self._holdings = holdings
        self.further: dict[str, Part] = {"get": self._get, "delete": self._delete}

    def hand_over(self, handing: Handing) -> None:
        """Let files go to robots, and come from them."""
        self.further |= {"send": handing.send, "put": handing.put, "from": handing.fetch}

    async def files(self, asked: Asked) -> Reply:
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

    def _list(self, asked: Asked) -> Reply:
        files, owner = self._holdings.files, asked.caller.principal
        found = files.of(owner)
        if not found:
            return Reply(words.NONE)
        buttons = [Button(one.name, f"/files get {one.name}") for one in found[:MOST_BUTTONS]]
        text = words.listing(map(self._line, found), files.used(owner)[1], files.room.person_bytes)
        return Reply(text, rows(buttons))

    def _line(self, one: Filed) -> str:
        ago = age((self._holdings.clock.wall_ns() - one.at_ns) / 1e9)
        return words.line(one.name, one.sort, one.size, ago, one.digest)

    async def _get(self, asked: Asked, name: str) -> Reply:
        filed = self._holdings.files.find(asked.caller.principal, name)
        most = asked.messenger.file_bytes
        if filed.size > most:
            raise OutOfBounds(words.too_large_to_send(filed.name, filed.size, most))
        content = await content_of(self._holdings.vault, filed)
        text = words.handed(filed.name, filed.size, filed.digest)
        return Reply(text, attachment=Attachment(filed.name, filed.media_type, content))

    async def _delete(self, asked: Asked, name: str) -> Reply:
        holdings = self._holdings
        async with holdings.changes.turn() as turn:
            filed = holdings.files.find(asked.caller.principal, name)
            await turn.write(holdings.files.drop(filed.id))
        return Reply(words.deleted(filed.name))
