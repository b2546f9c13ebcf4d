"""Says when a file of the data folder vanishes, or is written by somebody else, meanwhile."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, Final

from rosic.contracts.store import FileBackedRecord, RepairableStopFile
from rosic.core.i18n import said
from rosic.errors import RosicError

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.clock import Clock

LOOK_EVERY_S: Final = 2.0
TOGETHER: Final = "it, or rosic.db, rosic.db-wal and record.mark as they were last,"
BACK: Final = said("The files of my record are all there again. Robots may move.")

log = logging.getLogger("rosic.record")


def lost(file: str) -> str:
    """Return what follows from a file that is gone."""
    return said(
        "{file} of my record is gone or was replaced, emptied or overwritten. Nothing moves until "
        "it is back; stop still works. The operator has to look at the data folder.",
        file=file,
    )


class RecordMonitor:
    """Looks every two seconds; each order is looked at besides, when it is written down.

    Args:
        store: The record.
        latch: The stop file.
        tell: Says a sentence to the admins.
    """

    def __init__(
        self, store: object, latch: object, clock: Clock, tell: Callable[[str], object]
    ) -> None:
        self._store = store
        self._latch = latch
        self._clock = clock
        self._tell = tell
        self._said = ""

    async def run(self) -> None:
        """Look until cancelled."""
        while isinstance(self._store, FileBackedRecord):
            self.say(await asyncio.to_thread(self._store.lost_file))
            if self._said:
                await self._mend()
            await self._clock.sleep(LOOK_EVERY_S)

    async def _mend(self) -> None:
        """Write again what is known here; the mark the record itself writes again."""
        if isinstance(self._latch, RepairableStopFile):
            try:
                await self._latch.mend()
            except (OSError, RosicError) as error:
                log.warning("the stop file cannot be written again: %s", error)

    def lost_file(self) -> str:
        """Return the file that was not there when it was looked for last; empty: all were."""
        return self._said

    def say(self, file: str) -> None:
        """Say what has changed.

        Args:
            file: That is not there now; empty: all are.
        """
        if file == self._said:
            return
        self._said = file
        if file:
            log.error(
                "%s of the record is gone or was replaced, emptied or overwritten: nothing "
                "moves until it is back; end me and put %s back, see rosic doctor",
                file,
                TOGETHER,
            )
        else:
            log.warning("the files of the record are all there again")
        self._tell(lost(file) if file else BACK)
