"""What robots give: looked at whole before it is handed on, and again while it goes."""

from __future__ import annotations

import hashlib
from contextlib import aclosing
from typing import TYPE_CHECKING, NamedTuple

from rosic.container import file_messages as words
from rosic.container.file_types import SORTS, Sniffer, file_name
from rosic.core.records import Decided
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.contracts.robot import FileFolders
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.container_context import ContainerContext


class SeenFile(NamedTuple):
    """What a file is."""

    called: str
    media_type: str
    digest: bytes


class RobotOutbox:
    """Takes files out of the outboxes of all robots."""

    def __init__(self, folders: FileFolders, data_context: ContainerContext) -> None:
        self._folders = folders
        self._data_context = data_context

    async def seen(self, by: PrincipalId, robot: RobotId, own: str, size: int) -> SeenFile:
        """Find out what a robot's file is, and write down that it is handed on.

        Raises:
            Refusal: It is nothing that is handed on, or not as long as it was.
            RobotUnreachable: It cannot be read.
        """
        sniffer, digest, count = Sniffer(), hashlib.sha256(), 0
        async with aclosing(self._folders.read(robot, own)) as pieces:
            async for piece in pieces:
                sniffer.feed(piece)
                digest.update(piece)
                count += len(piece)
                if count > size:
                    break
        if count != size:
            raise NotUnderstood(words.CHANGED)
        sort = sniffer.sort(own)
        if sort is None:
            raise NotUnderstood(words.unknown(sorted(SORTS)))
        decided = Decided(
            act="file-from-robot",
            by=by,
            about=robot,
            at_ns=self._data_context.clock.wall_ns(),
            digest=digest.digest(),
        )
        async with self._data_context.changes.turn() as turn:
            await turn.write((decided,))
        return SeenFile(file_name(own, sort), sort.media_type, digest.digest())

    async def same(
        self, robot: RobotId, own: str, size: int, promised: bytes
    ) -> AsyncGenerator[bytes]:
        """Yield a file again.

        Raises:
            NotUnderstood: Before its last piece: it is another one now.
            RobotUnreachable: It cannot be read.
        """
        digest, count, held = hashlib.sha256(), 0, b""
        async with aclosing(self._folders.read(robot, own)) as pieces:
            async for piece in pieces:
                if held:
                    yield held
                held = piece
                digest.update(piece)
                count += len(piece)
                if count > size:
                    break
        if count != size or digest.digest() != promised:
            raise NotUnderstood(words.CHANGED)
        yield held
