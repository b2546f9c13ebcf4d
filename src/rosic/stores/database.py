"""The record on disk: what an event loop sees of it."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rosic.errors import StoreFault
from rosic.stores.folder import Folder
from rosic.stores.lane import Lane
from rosic.stores.settings import Settings
from rosic.stores.writer import Writer

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rosic.contracts.clock import Clock
    from rosic.core.record import Decided, Memory, Record

DEFAULTS = Settings()
AT_ONCE = 500  # administrative acts read in one step
NEWER_THAN_ALL = 2**63 - 1


class DatabaseStore:
    """One SQLite file, one writer thread, one transaction for many calls.

    Args:
        folder: Of one gateway; made for its owner only when it does not exist.
        clock: Says how old a command is.
    """

    def __init__(self, folder: Path, *, clock: Clock, settings: Settings = DEFAULTS) -> None:
        self._folder = Folder(folder)
        self._clock = clock
        self._settings = settings
        self._writer: Writer | None = None
        self._lane: Lane[tuple[Record, ...]] | None = None

    @property
    def lost(self) -> int:
        """Notes that could not be kept since opening; the record holds the same number."""
        return 0 if self._writer is None else self._writer.lost

    async def open(self) -> Memory:
        """Open, migrate, check, and return what was; see ``contracts.store``."""
        writer = Writer(self._folder, self._settings, self._clock)
        lane: Lane[tuple[Record, ...]] = Lane(
            "rosic-record",
            writer.settle,
            finish=writer.close,
            group_max=self._settings.group_max,
            queue_max=self._settings.queue_max,
        )
        lane.start()
        try:
            memory = await lane.call(writer.open)
        except BaseException:
            await lane.stop()
            raise
        self._writer, self._lane = writer, lane
        return memory

    async def close(self) -> None:
        """Write what is waiting, then close."""
        if self._lane is not None:
            await self._lane.stop()

    async def write(self, *records: Record) -> None:
        """Write all or none; see ``contracts.store``."""
        await self._opened().put(records)

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        """Write soon, in order, and call ``then``; see ``contracts.store``."""
        if self._lane is None or not self._lane.drop((record,), then):
            if self._writer is not None:
                self._writer.miss(1)
            then()

    def note(self, *records: Record) -> None:
        """Write soon, in order. While the disk does not work, notes wait, within bounds."""
        if self._lane is not None and not self._lane.drop(records) and self._writer is not None:
            self._writer.miss(1)

    async def prune(self) -> int:
        """Forget settled commands that are older than the settings keep. Return how many.

        Goes in small steps, so that writes pass between them. Meant to be called once a day.

        Raises:
            StoreFault: Not all were forgotten; the rest is tried the next time.
        """
        if self._writer is None:
            raise StoreFault("The record is closed.")
        total = 0
        while step := await self._opened().call(self._writer.prune):
            total += step
        return total

    async def decisions(self, limit: int) -> tuple[Decided, ...]:
        """Return the newest administrative acts, the newest first; at most so many.

        What was written or noted before the call is among them. Goes in small steps, so that
        writes pass between them.

        Raises:
            StoreFault: They cannot be read now.
        """
        writer = self._writer
        if writer is None:
            raise StoreFault("The record is closed.")
        found: list[Decided] = []
        before = NEWER_THAN_ALL
        while (size := min(limit - len(found), AT_ONCE)) > 0:
            page = await self._opened().call(partial(writer.decisions, before, size))
            found += [decided for _, decided in page]
            if len(page) < size:
                break
            before = page[-1][0]
        return tuple(found)

    async def shred(self, container: str) -> None:
        """Erase the personal content of one container for good, by erasing its key.

        Raises:
            StoreFault: It may still be readable; doing it again is safe.
        """
        writer = self._writer
        if writer is None:
            raise StoreFault("The record is closed.")
        await self._opened().call(lambda: writer.shred(container))

    def _opened(self) -> Lane[tuple[Record, ...]]:
        if self._lane is None:
            raise StoreFault("The record is closed. Nothing was written.")
        return self._lane
