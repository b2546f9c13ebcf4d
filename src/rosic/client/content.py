"""What is no text: what robots show, files of one's own, and the past as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, NamedTuple

from rosic.api.resource_schemas import FileOut
from rosic.client.resources import ResourceCalls, part, query

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.client.connection import MediaContent

VIEW_S: Final = 30.0
"""So much longer a robot may take to show something than to answer."""
FILE_S: Final = 300.0
ALL_S: Final = 3e8
TAKEN: Final = "rosic-taken"
IMAGE: Final = "image/"
TABLE: Final = "text/csv"
BYTES: Final = "application/octet-stream"


class Picture(NamedTuple):
    """What a robot shows.

    Attributes:
        media_type: ``image/png`` or ``image/jpeg``.
        taken: When; RFC 3339, UTC.
    """

    content: bytes
    media_type: str
    taken: str


class ContentCalls(ResourceCalls):
    """Asks for it; what is sent is sent once. Each raises as those of `ResourceCalls` do."""

    async def _fetch(
        self,
        path: str,
        kind: str,
        *,
        params: Mapping[str, str | float] | None = None,
        more_s: float = 0.0,
    ) -> MediaContent:
        raise NotImplementedError

    async def _send(self, path: str, content: bytes, name: str, more_s: float) -> FileOut:
        raise NotImplementedError

    async def picture(
        self, robot: str, kind: Literal["picture", "map"] = "picture", *, low: bool = False
    ) -> Picture:
        """Return what a robot sees, or its map; ``low`` is small, for a slow line."""
        params = {"low": "true"} if low else {}
        path = f"robots/{part(robot)}/views/{kind}"
        shown = await self._fetch(path, IMAGE, params=params, more_s=VIEW_S)
        return Picture(shown.content, shown.media_type, shown.headers.get(TAKEN, ""))

    async def files(self) -> list[FileOut]:
        """Return which files I keep there."""
        return await self._look("files", list[FileOut])

    async def send_file(self, name: str, content: bytes) -> FileOut:
        """Keep a file there, of at most 25 MB; it is looked at and never opened.

        Raises:
            ApiProblem: It is not kept, and why.
            NotAnswered: `NotKnown`: it may be kept, `files` says so; otherwise it is not.
        """
        return await self._send("files", content, name, FILE_S)

    async def file_content(self, file: str) -> bytes:
        """Return what is in a file of mine, by its id."""
        found = await self._fetch(f"files/{part(file)}", BYTES, more_s=FILE_S)
        return found.content

    async def delete_file(self, file: str) -> None:
        """Delete a file of mine, for good."""
        await self._once(f"files/{part(file)}", type(None), None, method="DELETE")

    async def history_table(
        self, robot: str = "", *, text: str = "", since_s: float = ALL_S
    ) -> bytes:
        """Return what was asked before as comma-separated values in UTF-8, at most 5,000 lines."""
        params = {**query(robot=robot, text=text), "since_s": since_s}
        found = await self._fetch("history/export", TABLE, params=params, more_s=VIEW_S)
        return found.content
