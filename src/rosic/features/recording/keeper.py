"""Where people's recordings lie: sealed in the container of whoever made them, part by part.

A part that is on disk outlives this process. What was broken off is made a whole file at the next
start, up to its last part, and its owner is told.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
from contextlib import suppress
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.container.file_types import SORTS
from rosic.container.files import PART_BYTES, Recorded, parts_of
from rosic.core.records import Decided
from rosic.core.time_units import SECOND_NS
from rosic.errors import RecordUnavailable
from rosic.features.recording import messages as words

if TYPE_CHECKING:
    from rosic.container.files import StoredFile
    from rosic.contracts.recording import Recorder
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.container_context import ContainerContext
    from rosic.gateway.feature import Kernel

MCAP: Final = SORTS["mcap"]
MOST_BYTES: Final = 40_000_000
LEAST_BYTES: Final = 1_000_000
"""With less room than this nothing is begun."""
MOST_PARTS: Final = 2_000

log = logging.getLogger("rosic.recording")


class OpenRecording:
    """One file that is being recorded.

    Attributes:
        id: Its id.
        most_bytes: It may come to so many.
        digest, count, size: Of what was written so far.
    """

    def __init__(
        self, containers: ContainerContext, file: str, owner: PrincipalId, most_bytes: int
    ) -> None:
        self.id, self.most_bytes = file, most_bytes
        self.digest, self.count, self.size = hashlib.sha256(), 0, 0
        self._containers, self._owner = containers, owner

    async def write(self, part: bytes) -> None:
        """Keep the next part.

        Raises:
            RecordUnavailable: It cannot be kept: there is no room for more parts, or its owner
                was erased meanwhile.
        """
        files = self._containers.files
        for at in range(0, len(part), PART_BYTES):
            piece = part[at : at + PART_BYTES]
            async with self._containers.changes.turn() as turn:
                if self.count >= MOST_PARTS or not files.knows(self.id):
                    raise RecordUnavailable(words.NO_MORE_PARTS)
                await turn.write((files.part(self._owner, self.id, self.count, piece),))
            self.digest.update(piece)
            self.count += 1
            self.size += len(piece)


class RecordingKeeper:
    """Everybody's recordings on disk."""

    def __init__(self, kernel: Kernel, containers: ContainerContext) -> None:
        self._recorder = kernel.recorder
        self._containers = containers
        self._open: dict[str, OpenRecording] = {}

    async def begin(self, asked: CommandContext, robot: RobotId) -> OpenRecording:
        """Keep room for a recording, on the record.

        Raises:
            TooManyRequests: There is none.
            RecordUnavailable: It cannot be written; nothing was begun.
        """
        files, who = self._containers.files, asked.caller.principal
        file, now_ns = asked.cid.hex()[:32], self._containers.clock.wall_ns()
        left = files.room.person_bytes - files.used(who)[1]
        most = max(LEAST_BYTES, min(MOST_BYTES, left))
        when = datetime.fromtimestamp(now_ns // SECOND_NS, tz=UTC)
        name = f"{robot}-{when:%Y%m%dT%H%M%SZ}.mcap"
        decided = Decided(act="record", by=who, about=robot, at_ns=now_ns, digest=asked.cid)
        async with self._containers.changes.turn() as turn:
            kind = Recorded(MCAP.name, MOST_PARTS)
            await turn.write((decided, *files.begin(who, file, name, most, kind)))
        opened = self._open[file] = OpenRecording(self._containers, file, who, most)
        return opened

    async def finish(self, file: str) -> StoredFile | None:
        """Let a recording that is whole be a file of whoever made it; None: it was erased.

        Raises:
            RecordUnavailable: It cannot be written.
        """
        opened, files = self._open.pop(file), self._containers.files
        async with self._containers.changes.turn() as turn:
            begun = self._begun(file)
            if begun is None:
                return None
            digest, count = opened.digest.digest(), opened.count
            await turn.write(
                files.finish(file, begun.name, MCAP, opened.size, digest, max(1, count))
            )
        return self._kept(begun.owner, file)

    async def rescue(self, file: str) -> StoredFile | None:
        """Make a whole file of what is on disk of one; None, if nothing of it can be kept."""
        self._open.pop(file, None)
        begun = self._begun(file)
        if begun is None:
            return None
        try:
            parts = [part async for part in parts_of(self._containers.container_store, file)]
            whole = await asyncio.to_thread(_repaired, self._recorder, parts)
            if whole.pieces:
                await self._replace(begun, whole)
                return self._kept(begun.owner, file)
        except RecordUnavailable:
            log.warning("what was recorded cannot be kept as a file now")
            return None
        await self.drop(file)
        return None

    async def _replace(self, begun: StoredFile, whole: _Repaired) -> None:
        """Let a repaired file be in place of what was there of it, all at once."""
        files, owner, file = self._containers.files, begun.owner, begun.id
        count = len(whole.pieces)
        async with self._containers.changes.turn() as turn:
            if not files.knows(file):
                return
            # The parts that are too many go first; a part of the same number is replaced.
            gone = files.drop(file)[1 + count :]
            kept = (files.part(owner, file, n, piece) for n, piece in enumerate(whole.pieces))
            finished = files.finish(file, begun.name, MCAP, whole.size, whole.digest, count)
            await turn.write((*gone, *kept, *finished))

    async def restore(self) -> None:
        """Make whole what an earlier run left, and tell whoever it is of."""
        for begun in self._containers.files.unfinished(recorded=True):
            if begun.id in self._open:
                continue
            kept = await self.rescue(begun.id)
            text = words.cut_off(begun.name) if kept is None else words.rescued(kept.name)
            self._containers.tell((begun.owner,), text)

    async def drop(self, file: str) -> None:
        """Keep nothing of a file."""
        self._open.pop(file, None)
        with suppress(RecordUnavailable):
            async with self._containers.changes.turn() as turn:
                await turn.write(self._containers.files.drop(file))

    def _begun(self, file: str) -> StoredFile | None:
        found = self._containers.files.unfinished(recorded=True)
        return next((one for one in found if one.id == file), None)

    def _kept(self, owner: PrincipalId, file: str) -> StoredFile | None:
        return next((one for one in self._containers.files.of(owner) if one.id == file), None)


class _Repaired(NamedTuple):
    """A whole file in pieces; none: nothing could be read."""

    pieces: tuple[bytes, ...]
    size: int
    digest: bytes


def _repaired(recorder: Recorder | None, parts: list[bytes]) -> _Repaired:
    """Make a whole file of parts; on a thread, as it may be large."""
    whole = b"" if recorder is None or not parts else recorder.repair(b"".join(parts))
    pieces = tuple(whole[at : at + PART_BYTES] for at in range(0, len(whole), PART_BYTES))
    return _Repaired(pieces, len(whole), hashlib.sha256(whole).digest())
