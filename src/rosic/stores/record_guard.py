"""Nothing is claimed in a record that nobody will read again, and each record knows its age.

Everything here runs in the writer's thread.
"""

from __future__ import annotations

import logging
from pathlib import PurePath
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.core.record import Claimed, Decided, Enrolled, KeyIssued, KeyRevoked, Record, Seeded
from rosic.core.saying import said
from rosic.errors import StoreFault
from rosic.stores.lane import Job
from rosic.stores.record_mark import Mark

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.stores.folder import Folder
    from rosic.stores.kept_files import KeptFiles

Calls: TypeAlias = list[Job[tuple[Record, ...]]]

MARK_EVERY_NS: Final = 60_000_000_000
# What must not be undone by putting an older record back: who was let in, and who no longer is.
MARKED: Final = (Enrolled, KeyIssued, KeyRevoked, Decided, Seeded)

log = logging.getLogger("rosic.stores")


class RecordGuard:
    """Looks at the files of a record around every commit, and renews its mark."""

    def __init__(self, folder: Folder, kept: KeptFiles, clock: Clock) -> None:
        self._folder = folder
        self._kept = kept
        self._clock = clock
        self._log = folder.database.with_name(f"{folder.database.name}-wal")
        self._mark = Mark()
        self._marked_ns = 0

    def begin(self, mark: Mark) -> None:
        """Know the files of a record that was just opened, and what it says of itself.

        Raises:
            OSError: One of them is gone already.
        """
        self._kept.know(self._folder.database)
        self._kept.know(self._folder.mark.path)
        self.connected()
        self._mark, self._marked_ns = mark, self._clock.monotonic_ns()

    def connected(self) -> None:
        """Know the log file that goes with a new connection."""
        self._kept.know_if_there(self._log)

    def disconnected(self) -> None:
        """With the last connection the log file goes."""
        self._kept.forget(self._log)

    def ended(self) -> None:
        """Look at nothing more: the record is closed."""
        self.disconnected()
        self._kept.forget(self._folder.database)
        self._kept.forget(self._folder.mark.path)

    def check_database(self) -> None:
        """See that the file which would be opened is the record.

        Raises:
            StoreFault: It is not.
        """
        if self._kept.is_lost(self._folder.database):
            raise StoreFault(said("The record is gone or was replaced. Nothing was written."))

    def check(self, group: Calls) -> Calls:
        """Return what of a group may be written: nothing is claimed while a file is missing.

        Raises:
            StoreFault: It is the record itself that is gone or was replaced.
        """
        lost = self._kept.lost()
        if not lost:
            return group
        name = PurePath(lost).name
        if lost in {str(self._folder.database), str(self._log)}:
            raise StoreFault(
                said("{file} is gone or was replaced. Nothing was written.", file=name)
            )
        may: Calls = []
        for job in group:
            if any(isinstance(record, Claimed) for record in job.content):
                job.error = StoreFault(said("{file} is gone or was replaced.", file=name))
            else:
                may.append(job)
        return may

    def next_mark(self, group: Calls) -> Mark | None:
        """Return what the record is to say of itself with a group; None: what it says now."""
        late = self._clock.monotonic_ns() - self._marked_ns > MARK_EVERY_NS
        if late or any(isinstance(record, MARKED) for job in group for record in job.content):
            return Mark(self._mark.identity, self._mark.number + 1)
        return None

    def has_marked(self, mark: Mark | None) -> None:
        """Say beside the record what it says; what cannot be said now is said with the next."""
        if mark is None:
            return
        self._mark, self._marked_ns = mark, self._clock.monotonic_ns()
        try:
            self._folder.mark.write(mark)
        except OSError as error:
            log.warning("%s cannot be written: %s", self._folder.mark.path, error.strerror)
