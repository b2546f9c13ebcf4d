"""Which messages were decrypted before: over restarts, so that none is ever taken for a new one.

Whoever runs a homeserver can give the same ciphertext out again as another event, with another
time. Its place in its session cannot be changed, so one place belongs to one event, for good
(Matrix specification v1.11, client-server API, "Message replay attacks": ``m.megolm.v1``).
"""

from __future__ import annotations

import asyncio
import sqlite3
from collections import OrderedDict
from contextlib import closing
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.errors import ConfigurationError, MessengerFault

if TYPE_CHECKING:
    from pathlib import Path

REMEMBERED: Final = 100_000
FILE: Final = "replays.db"

SessionPlace: TypeAlias = tuple[str, str, int]
"""Identity key of the sending device, session, index within it."""

_MAKE: Final = """
CREATE TABLE IF NOT EXISTS decrypted (
    number INTEGER PRIMARY KEY,
    sender_key TEXT NOT NULL,
    session TEXT NOT NULL,
    place INTEGER NOT NULL,
    event TEXT NOT NULL,
    sent_ms INTEGER NOT NULL,
    UNIQUE (sender_key, session, place)
)
"""
_READ: Final = (
    "SELECT sender_key, session, place, event, sent_ms FROM decrypted ORDER BY number DESC LIMIT ?"
)
_WRITE: Final = (
    "INSERT OR IGNORE INTO decrypted (sender_key, session, place, event, sent_ms)"
    " VALUES (?, ?, ?, ?, ?)"
)
_FORGET: Final = "DELETE FROM decrypted WHERE number <= (SELECT max(number) FROM decrypted) - ?"


class ReplayGuard:
    """What matrix-nio looks up for every event that it decrypts; it takes this for a dictionary.

    Args:
        folder: Its file lies there.
        most: So many are remembered.
    """

    def __init__(self, folder: Path, most: int = REMEMBERED) -> None:
        self._file = folder / FILE
        self._most = most
        self._events: OrderedDict[SessionPlace, tuple[str, int]] = OrderedDict()
        self._unwritten: list[tuple[str, str, int, str, int]] = []
        self._writing = asyncio.Lock()

    def __getitem__(self, place: SessionPlace) -> tuple[str, int]:
        return self._events[place]

    def __setitem__(self, place: SessionPlace, event: tuple[str, int]) -> None:
        self._events[place] = event
        self._unwritten.append((*place, *event))
        while len(self._events) > self._most:
            self._events.popitem(last=False)

    async def open(self) -> None:
        """Read what earlier runs have decrypted.

        Raises:
            ConfigurationError: The file is damaged, or cannot be used.
        """
        try:
            rows = await asyncio.to_thread(self._read)
        except sqlite3.Error as error:
            raise ConfigurationError(
                f"{self._file} cannot be read, so nobody knows what was said before.",
                hint=f"Bring the folder back from your copy. ({error})",
            ) from None
        for sender_key, session, place, event, sent_ms in reversed(rows):
            self._events[sender_key, session, place] = event, sent_ms

    async def settle(self) -> None:
        """Wait until all that was decrypted is on disk.

        Raises:
            MessengerFault: It is not: it could be given out again as something new.
        """
        async with self._writing:
            rows, self._unwritten = self._unwritten, []
            if not rows:
                return
            try:
                await asyncio.to_thread(self._write, rows)
            except sqlite3.Error as error:
                self._unwritten = [*rows, *self._unwritten][-self._most :]
                raise MessengerFault("What was decrypted could not be written down.") from error

    def _opened(self) -> sqlite3.Connection:
        connection = sqlite3.connect(self._file)
        connection.execute("PRAGMA synchronous = FULL")
        connection.execute(_MAKE)
        return connection

    def _read(self) -> list[tuple[str, str, int, str, int]]:
        with closing(self._opened()) as connection:
            return connection.execute(_READ, (self._most,)).fetchall()

    def _write(self, rows: list[tuple[str, str, int, str, int]]) -> None:
        with closing(self._opened()) as connection, connection:
            connection.executemany(_WRITE, rows)
            connection.execute(_FORGET, (self._most,))
