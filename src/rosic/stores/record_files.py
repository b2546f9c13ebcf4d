"""What stands in the files of a record, read beside SQLite and without it.

SQLite keeps a part of what it read, and an index of its log, in memory: it would go on writing into
files that somebody has emptied or written over, and nobody could read them again.
"""

from __future__ import annotations

import fcntl
import os
import struct
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.stores.record_mark import RecordNumber

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


# ---- kept files ----

# The files that a running gateway keeps open, and whether each is still where it was opened.
#
# A file that was removed or replaced goes on being written, and nobody will ever read it again;
# nor will anybody read what is written into one that was emptied or written over. Whatever keeps
# a file from being looked at counts as its loss.


class KeptFile(NamedTuple):
    """One file.

    Attributes:
        number: Of what was opened there.
        is_whole: Says whether what was written into it still stands there.
        comes_first: It is the record itself: said before any other that is lost, too.
    """

    number: tuple[int, int]
    is_whole: Callable[[], bool]
    comes_first: bool


def by_its_number() -> bool:
    """Whether a file is whole of which nothing is known but which one it is."""
    return True


class KeptFiles:
    """Files by path, each with the number of what was opened there. Looked at from any thread."""

    def __init__(self) -> None:
        self._known: dict[str, KeptFile] = {}

    def know(
        self,
        path: Path,
        descriptor: int | None = None,
        *,
        is_whole: Callable[[], bool] = by_its_number,
        comes_first: bool = False,
    ) -> None:
        """Take a file for the one that belongs there: what is open, or what is there now.

        Raises:
            OSError: It is not there.
        """
        number = _number(path if descriptor is None else descriptor)
        self._known[str(path)] = KeptFile(number, is_whole, comes_first)

    def look_less(self, path: Path, is_whole: Callable[[], bool]) -> None:
        """Ask something else about what stands in a file that is known."""
        if (kept := self._known.get(str(path))) is not None:
            self._known[str(path)] = kept._replace(is_whole=is_whole)

    def forget(self, path: Path) -> None:
        """Look at a file no more: it was closed."""
        self._known.pop(str(path), None)

    def lost(self) -> str:
        """Return the path of a file that is gone, was replaced, emptied or written over.

        Of several that of the record itself. Empty while all are there, as they were left.
        """
        known = sorted(dict(self._known).items(), key=lambda item: not item[1].comes_first)
        return next((path for path, kept in known if _is_lost(path, kept)), "")

    def is_lost(self, path: Path) -> bool:
        """Whether one file is gone, was replaced, emptied or written over."""
        kept = self._known.get(str(path))
        return kept is not None and _is_lost(path, kept)

    def is_elsewhere(self, path: Path) -> bool:
        """Whether one file is gone or was replaced, whatever stands in it."""
        kept = self._known.get(str(path))
        return kept is not None and _is_lost(path, kept._replace(is_whole=by_its_number))


def _is_lost(path: Path | str, kept: KeptFile) -> bool:
    try:
        return _number(path) != kept.number or not kept.is_whole()
    except Exception:  # noqa: BLE001 - whatever it is: nobody can say that it is there
        return True


def _number(file: Path | str | int) -> tuple[int, int]:
    status = os.stat(file)  # noqa: PTH116 - asked around every commit
    return status.st_dev, status.st_ino


# ---- record files ----

MAGIC: Final = b"SQLite format 3\0"
HEADER: Final = struct.Struct(">60xi4xi28x")  # of a database: the user version, the application id
FRAME: Final = struct.Struct(">8x8sII")  # of a log: the salts, the checksum up to here
SALTS: Final = slice(16, 24)  # in the header of a log
LOG_HEADER_BYTES: Final = 32
# Of the index of a log, each twice: version, page size, frames, the checksum of the last, the salts
INDEX: Final = struct.Struct("=I10xHI4xII8s8x")
INDEX_VERSION: Final = 3_007_000
LOOKS: Final = 100  # at an index that is being written at this moment
# Where a connection locks a database before it folds the log into it for the last time.
SHARED_FIRST: Final = 0x4000_0002
LOCK: Final = struct.Struct("hhqqi0q")


class RecordFiles:
    """The files of one record, by descriptors of its own.

    Closing any descriptor of a file lets go of every lock that this process has on it, those of
    SQLite too: each of these is closed only when no connection is open any more.

    Attributes:
        database: None until it is open, as the others.
        log: What is not in the database yet.
        index: Of the log; SQLite has it in memory.
    """

    def __init__(self) -> None:
        self.database: int | None = None
        self.log: int | None = None
        self.index: int | None = None

    def open_database(self, path: Path) -> None:
        """Open the database, before the first connection.

        Raises:
            OSError: It cannot be read.
        """
        if self.database is None:
            self.database = _opened(path)

    def open_log(self, path: Path, index: Path) -> None:
        """Open what goes with a connection.

        Raises:
            OSError: One of them cannot be read.
        """
        self.log, self.index = _opened(path), _opened(index)

    def close_log(self) -> None:
        """Close what went with a connection that is closed by now."""
        for descriptor in (self.log, self.index):
            if descriptor is not None:
                os.close(descriptor)
        self.log = self.index = None

    def close(self) -> None:
        """Close everything; no connection is open any more."""
        self.close_log()
        if self.database is not None:
            os.close(self.database)
        self.database = None

    def mark(self) -> RecordNumber | None:
        """Return what the database says of itself without its log; None: it is none.

        Raises:
            OSError: It cannot be read.
        """
        return None if self.database is None else mark_in(self.database)

    def size(self) -> int:
        """Return how large the database is.

        Raises:
            OSError: It cannot be said.
        """
        return 0 if self.database is None else os.fstat(self.database).st_size

    def salts(self) -> bytes:
        """Return what tells the log from those before it; empty when that cannot be read."""
        if self.index is None:
            return b""
        try:
            salts: bytes = INDEX.unpack(os.pread(self.index, INDEX.size, 0))[5]
        except (OSError, struct.error):
            return b""
        return salts

    def log_is_whole(self) -> bool:
        """Whether the log ends with what was written last.

        Raises:
            OSError: It cannot be read.
            struct.error: A part of it is missing.
        """
        if self.log is None or self.index is None:
            return False
        for _ in range(LOOKS):
            before = os.pread(self.index, 2 * INDEX.size, 0)
            whole = _ends_well(self.log, before)
            if whole or before == os.pread(self.index, 2 * INDEX.size, 0):
                return whole
        return False

    def keep_log_apart(self) -> None:
        """See that closing the connection does not fold the log into the database.

        Raises:
            OSError: This kind of disk cannot.
        """
        self._lock(fcntl.F_RDLCK)

    def let_log_in(self) -> None:
        """Let the log be folded into the database again."""
        self._lock(fcntl.F_UNLCK)

    def _lock(self, kind: int) -> None:
        if self.database is not None:
            # Of the descriptor, not of the process: it counts against our own connection.
            wanted = LOCK.pack(kind, os.SEEK_SET, SHARED_FIRST, 1, 0)
            fcntl.fcntl(self.database, fcntl.F_OFD_SETLK, wanted)


def mark_in(database: int) -> RecordNumber | None:
    """Return what a file says of itself without its log; None: it is no database.

    Raises:
        OSError: It cannot be read.
    """
    header = os.pread(database, HEADER.size, 0)
    if len(header) < HEADER.size or not header.startswith(MAGIC):
        return None
    number, identity = HEADER.unpack(header)
    return RecordNumber(identity, number)


def _opened(path: Path) -> int:
    return os.open(path, os.O_RDONLY | os.O_CLOEXEC)


def _ends_well(log: int, index: bytes) -> bool:
    if index[: INDEX.size] != index[INDEX.size :]:
        return False
    version, page, frames, *checksum, salts = INDEX.unpack(index[: INDEX.size])
    if version != INDEX_VERSION:
        return False
    if not frames:
        return True  # nothing that matters stands in it
    page_bytes = (page & 0xFE00) + ((page & 1) << 16)
    at = LOG_HEADER_BYTES + (frames - 1) * (FRAME.size + page_bytes)
    last = FRAME.unpack(os.pread(log, FRAME.size, at))
    whole = os.fstat(log).st_size >= at + FRAME.size + page_bytes
    return whole and last == (salts, *checksum) and os.pread(log, 24, 0)[SALTS] == salts
