"""Nothing is claimed in a record that nobody will read again, and each record knows its age.

Everything here runs in the writer's thread.
"""

from __future__ import annotations

import logging
import os
from contextlib import suppress
from pathlib import PurePath
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.core.i18n import said
from rosic.core.records import Claimed, Decided, Enrolled, KeyIssued, KeyRevoked, Record, Seeded
from rosic.core.time_units import MINUTE_NS
from rosic.errors import StoreFault
from rosic.stores.record_files import RecordFiles, by_its_number
from rosic.stores.record_mark import DATABASE, LOG, RecordNumber, packed
from rosic.stores.write_thread import WriteJob

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.contracts.clock import Clock
    from rosic.stores.data_dir import DataDir
    from rosic.stores.record_files import KeptFiles

Calls: TypeAlias = list[WriteJob[tuple[Record, ...]]]

MARK_EVERY_NS: Final = MINUTE_NS
# What must not be undone by putting an older record back: who was let in, and who no longer is.
MARKED: Final = (Enrolled, KeyIssued, KeyRevoked, Decided, Seeded)

log = logging.getLogger("rosic.stores")


class RecordGuard:
    """Looks at the files of a record around every commit, and renews its mark."""

    def __init__(self, folder: DataDir, kept: KeptFiles, clock: Clock) -> None:
        self._folder = folder
        self._kept = kept
        self._clock = clock
        self._files = RecordFiles()
        self._log = folder.database.with_name(LOG)
        self._index = folder.database.with_name(f"{DATABASE}-shm")
        self._mark = RecordNumber()
        self._highest = 0  # that the record may say of itself: what is being written now, too
        self._marked_ns = 0
        self._salts = b""
        self._log_is_marked = True
        self._is_proven = True
        self._said: frozenset[bytes] = frozenset()

    # ---- opening and closing ----

    def opening(self) -> RecordNumber:
        """Return what the database says of itself without its log, before it is opened.

        Until `opened`, a connection that is closed changes nothing: the log may be another one's.

        Raises:
            OSError: It cannot be read.
        """
        self._files.open_database(self._folder.database)
        if os.path.lexists(self._log) and self._log.stat().st_size:
            self._files.keep_log_apart()
        return self._files.mark() or RecordNumber()

    def opened(self) -> None:
        """The database and its log belong together.

        Raises:
            OSError: This kind of disk cannot lock.
        """
        self._files.let_log_in()

    def begin(self, mark: RecordNumber) -> None:
        """Know the files of a record that was just opened, and say beside it what it says.

        Raises:
            OSError: One of them is gone already.
        """
        self._mark, self._highest, self._marked_ns = mark, mark.number, self._clock.monotonic_ns()
        self._say()
        self._know_log()
        self._salts = self._files.salts()

    def connected(self, found: RecordNumber) -> None:
        """See that a new connection has the record as it was, and know the files that go with it.

        Raises:
            StoreFault: It is older than it was.
            OSError: One of the files is gone already.
        """
        if not self._is_as_it_was(found) or not self._has_grown(self._files.mark()):
            raise self._unproven()
        self._is_proven = True
        self._files.let_log_in()
        self._know_log()

    def _unproven(self) -> StoreFault:
        self._is_proven = False
        return StoreFault(said("The record is not what it was a moment ago. Nothing was written."))

    def _is_as_it_was(self, found: RecordNumber) -> bool:
        ours = found.identity == self._mark.identity
        return ours and self._mark.number <= found.number <= self._highest

    def _has_grown(self, alone: RecordNumber | None) -> bool:
        """Whether the database says alone what it said, or what its log brought into it since."""
        if alone is None or alone.identity not in {self._mark.identity, 0}:
            return False
        return self._mark.folded <= alone.number <= self._highest

    def _know_log(self) -> None:
        self._files.open_log(self._log, self._index)
        for path, descriptor, is_whole in (
            (self._folder.database, self._files.database, self._database_is_whole),
            (self._log, self._files.log, self._files.log_is_whole),
            (self._index, self._files.index, by_its_number),
        ):
            self._kept.know(path, descriptor, is_whole=is_whole, comes_first=True)

    def disconnecting(self) -> None:
        """See that what was written over is not folded into what was not."""
        elsewhere = self._kept.is_elsewhere
        for path in (self._folder.database, self._log):
            if self._kept.is_lost(path):
                self._is_proven = False
                if not elsewhere(path):
                    with suppress(OSError):
                        self._files.keep_log_apart()

    def disconnected(self) -> None:
        """With the last connection the log file goes; what the database says is asked anew."""
        self._kept.forget(self._log)
        self._kept.forget(self._index)
        self._files.close_log()
        with suppress(OSError):
            self._files.let_log_in()
        self._kept.look_less(self._folder.database, lambda: self._is_proven)

    def ended(self) -> None:
        """Look at nothing more: the record is closed."""
        for path in (self._log, self._index, self._folder.database, self._folder.mark.path):
            self._kept.forget(path)
        self._files.close()

    # ---- while it is open ----

    def _database_is_whole(self) -> bool:
        return self._is_proven and self._has_grown(self._files.mark())

    def _mark_is_whole(self) -> bool:
        """Whether the file beside the record says what was said last, or is being said."""
        return self._folder.mark.path.read_bytes() in self._said

    def reconnecting(self) -> None:
        """See that the file which would be opened is the record.

        Raises:
            StoreFault: It is not.
            OSError: It cannot be read.
        """
        if not self._is_proven:  # closing it again must change nothing
            with suppress(OSError):
                self._files.keep_log_apart()
        if self._kept.is_elsewhere(self._folder.database):
            raise StoreFault(said("The record is gone or was replaced. Nothing was written."))
        alone = self._files.mark()
        # What is no database SQLite itself refuses; beneath an empty one it would remove the log.
        if not self._files.size() or (alone is not None and not self._has_grown(alone)):
            raise self._unproven()

    def check(self, group: Calls) -> Calls:
        """Return what of a group may be written: nothing is claimed while a file is missing.

        Raises:
            StoreFault: It is the record itself that is gone or was replaced.
        """
        lost = self._kept.lost()
        if not lost:
            return group
        name = PurePath(lost).name
        if lost in {str(self._folder.database), str(self._log), str(self._index)}:
            raise StoreFault(
                said(
                    "{file} is gone or was replaced, emptied or overwritten. Nothing was written.",
                    file=name,
                )
            )
        may: Calls = []
        for job in group:
            if any(isinstance(record, Claimed) for record in job.content):
                job.fail(
                    StoreFault(
                        said("{file} is gone or was replaced, emptied or overwritten.", file=name)
                    )
                )
            else:
                may.append(job)
        return may

    def next_mark(self, group: Calls) -> RecordNumber | None:
        """Return what the record is to say of itself with a group; None: what it says now.

        A log that was begun since says a number of its own, so that none before it is taken for it;
        and a file that somebody has written over is written again.
        """
        late = self._clock.monotonic_ns() - self._marked_ns > MARK_EVERY_NS
        if (
            late
            or not self._log_is_marked
            or any(isinstance(record, MARKED) for job in group for record in job.content)
            or self._is_overwritten(self._folder.mark.path)
        ):
            self._highest = self._mark.number + 1
            return RecordNumber(self._mark.identity, self._highest, self._mark.folded)
        return None

    def _is_overwritten(self, path: Path) -> bool:
        return self._kept.is_lost(path) and not self._kept.is_elsewhere(path)

    def has_written(self, mark: RecordNumber | None) -> None:
        """Say beside the record what it says; what cannot be said now is said with the next."""
        salts = self._files.salts()
        if (
            salts and salts != self._salts
        ):  # what the log before it said is in the database for good
            folded = self._mark.number
            self._salts, self._log_is_marked = salts, False
            self._mark = RecordNumber(self._mark.identity, self._mark.number, folded)
        if mark is None:
            return
        self._mark = RecordNumber(mark.identity, mark.number, self._mark.folded)
        self._log_is_marked, self._marked_ns = True, self._clock.monotonic_ns()
        try:
            self._say()
        except OSError as error:
            log.warning("%s cannot be written: %s", self._folder.mark.path, error.strerror)

    def _say(self) -> None:
        """Write the file beside the record.

        Raises:
            OSError: It may say what it said before.
        """
        self._said |= {content := packed(self._mark)}
        self._folder.mark.write(self._mark)
        self._kept.know(self._folder.mark.path, is_whole=self._mark_is_whole)
        self._said = frozenset({content})
