"""Says when a file of the data folder vanishes or is replaced while the gateway runs."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, Protocol, runtime_checkable

from rosic.core.saying import said

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.app.placing.furnishing import Furnishing
    from rosic.contracts.clock import Clock

LOOK_EVERY_S: Final = 2.0
BACK: Final = said("The files of my record are all there again. Robots may move.")

log = logging.getLogger("rosic.record")


@runtime_checkable
class OnFiles(Protocol):
    """A record that is kept in files, and notices when one of them is taken away."""

    def lost_file(self) -> str:
        """Return the name of a file that is gone or was replaced; empty while all are there."""
        ...


def lost(file: str) -> str:
    """Return what follows from a file that is gone."""
    return said(
        "{file} of my record is gone or was replaced. Nothing moves until it is back; stop still "
        "works. The operator has to look at the data folder.",
        file=file,
    )


class RecordWatch:
    """Looks every two seconds; each order is looked at besides, when it is written down.

    Args:
        store: The record.
        tell: Says a sentence to the admins.
    """

    def __init__(self, store: object, clock: Clock, tell: Callable[[str], object]) -> None:
        self._store = store
        self._clock = clock
        self._tell = tell
        self._said = ""

    async def run(self) -> None:
        """Look until cancelled."""
        while isinstance(self._store, OnFiles):
            self.look()
            await self._clock.sleep(LOOK_EVERY_S)

    def lost_file(self) -> str:
        """Return the file that is gone, of whatever record there is."""
        return self._store.lost_file() if isinstance(self._store, OnFiles) else ""

    def look(self) -> None:
        """Say what has changed."""
        file = self.lost_file()
        if file == self._said:
            return
        self._said = file
        if file:
            log.error("%s of the record is gone or was replaced: nothing moves until it is back; "
                      "see rosic doctor", file)  # fmt: skip
        else:
            log.warning("the files of the record are all there again")
        self._tell(lost(file) if file else BACK)


def record_watch_of(store: object, clock: Clock, furnishing: Furnishing) -> RecordWatch:
    """Return what tells the admins when a file of the record is gone."""

    def tell(text: str) -> None:
        furnishing.reach.tell(furnishing.admins(), text, urgent=True)

    return RecordWatch(store, clock, tell)
