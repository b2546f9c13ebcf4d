"""The folder of one gateway: its lock, and the root key that seals personal content."""

from __future__ import annotations

import errno
import fcntl
import logging
import os
from contextlib import suppress
from typing import TYPE_CHECKING

import msgspec

from rosic.errors import ConfigurationError
from rosic.stores.record_mark import DATABASE, RecordMark
from rosic.stores.root_key import ROOT_KEY, root_of

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.stores.encryption import RootKey
    from rosic.stores.record_files import KeptFiles


# ---- the folder and its lock ----

LOCK = "gateway.lock"
RESERVE = "reserve"
RESERVE_BYTES = 1 << 20
OPENING_BYTES = 1 << 16

FULL = (
    "the disk of %s is full: its reserve of %d KiB was given up. Free some space: soon nothing can "
    "be moved, only stopped"
)

log = logging.getLogger("rosic.record")


def _take_room(path: Path) -> None:
    file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        os.posix_fallocate(file, 0, RESERVE_BYTES)
    except OSError:
        path.unlink()
        raise
    finally:
        os.close(file)


def holder_of(path: Path) -> str:
    """Return the process of the gateway that has a data folder; empty: none has.

    A gateway that starts at the same moment may find the folder taken: ask only when it matters.
    """
    for name in (LOCK, ""):  # its lock, or the folder itself where somebody has removed that file
        with suppress(OSError):
            lock = os.open(path / name, os.O_RDONLY | os.O_CLOEXEC)
            try:
                fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
            except BlockingIOError:
                number = os.read(lock, 32).decode(errors="replace").strip() if name else ""
                return number or "unknown"
            finally:
                os.close(lock)
    return ""


class DataDir:
    """The place where one gateway keeps everything.

    Args:
        path: Made, for its owner only, when it does not exist.
        kept: Knows the lock from now on.
        begin_anew: See `RecordMark`.

    Attributes:
        mark: What shows that the record is the newest.
    """

    def __init__(self, path: Path, kept: KeptFiles, *, begin_anew: bool) -> None:
        self.path = path
        self.mark = RecordMark(path, begin_anew=begin_anew)
        self._kept = kept
        self._locks: list[int] = []

    @property
    def database(self) -> Path:
        """The file of the record."""
        return self.path / DATABASE

    def take(self) -> None:
        """Make the folder if need be and keep every other gateway out of it.

        Raises:
            ConfigurationError: Another gateway has it, or it cannot be written.
        """
        try:
            self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
            lock = os.open(self.path / LOCK, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        except OSError as error:
            raise ConfigurationError(
                f"The data folder {self.path} cannot be written ({error.strerror}).",
                hint="Give it to the user who runs ROSIC, or name another folder.",
            ) from error
        self._locks.append(lock)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self._lock_itself()
        except OSError as error:
            other = os.read(lock, 32).decode(errors="replace").strip() or "unknown"
            self.give_back()
            raise ConfigurationError(
                f"Another gateway is already running on this data (process {other}).",
                hint="Stop it first, or give this one a data folder of its own.",
            ) from error
        number = f"{os.getpid()}\n".encode()
        os.pwrite(lock, number, 0)  # cut afterwards: a full disk gives back nothing it was given
        os.ftruncate(lock, len(number))
        self._kept.know(self.path / LOCK, lock)
        self._keep_reserve()

    def _keep_reserve(self) -> None:
        """Keep some of the disk for a start on one that is full, and give it up at such a start.

        Without it the record could not be opened there, and nobody could stop a robot by us.
        """
        reserve = self.path / RESERVE
        try:
            if self._free_bytes() < RESERVE_BYTES:
                reserve.unlink()
                log.warning(FULL, self.path, RESERVE_BYTES >> 10)
            elif not reserve.exists():
                _take_room(reserve)
        except OSError as error:
            log.debug("there is no reserve in %s: %s", self.path, error.strerror)

    def is_full(self) -> bool:
        """Whether its disk has no room for what a record has to write when it is opened."""
        try:
            return self._free_bytes() < OPENING_BYTES
        except OSError:
            return False

    def _free_bytes(self) -> int:
        disk = os.statvfs(self.path)
        return disk.f_bavail * disk.f_frsize

    def _lock_itself(self) -> None:
        """Lock the folder, too: its lock file may be removed while it is held.

        Raises:
            OSError: Another gateway has it.
        """
        folder = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        self._locks.append(folder)
        try:
            fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in {errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES}:
                raise  # else: this kind of disk locks files only

    def give_back(self) -> None:
        """Let another gateway in."""
        self._kept.forget(self.path / LOCK)
        while self._locks:
            with suppress(OSError):
                os.close(self._locks.pop())

    def root(self) -> RootKey:
        """Return the root key; made when there is nothing yet that it could belong to.

        Raises:
            ConfigurationError: It is missing beside an existing record, others can read it, or
                it is not a key.
        """
        try:
            begun = self.database.exists() and self.database.stat().st_size > 0
            return root_of(self.path, os.environ, begun=begun)
        except OSError as error:
            raise ConfigurationError(
                f"{error.filename or self.path / ROOT_KEY} cannot be used ({error.strerror}).",
                hint="It must be a file that the user who runs ROSIC can read.",
            ) from error


# ---- settings of the record ----
# The defaults are meant to be left alone.


class StoreSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Bounds and durability of one record.

    Attributes:
        group_max: Calls that share one transaction.
        queue_max: Calls that may wait; one more is refused with a sentence.
        notes_max: Notes kept for later while the disk does not work; the oldest are lost first.
        open_orders_max: Commands whose end was never told, before further ones are refused.
        unsifted: Commands that are not sifted yet, after every sifting. At most twice as many and
            one group more are looked through at opening, and a command that is settled before so
            many others were claimed costs no row in the table of open ones.
        busy_timeout_ms: How long another program may hold the database before a write fails.
        synchronous: Anything weaker than ``FULL`` is refused at opening: it loses claims.
        pages_max: Size of the database file in pages of 4,096 bytes; None is the disk's size.
        kept_days: A command is recognised as repeated for at least this long.
        checked_bytes: A database file up to this size is read whole for damage at opening.
    """

    group_max: int = 512
    queue_max: int = 10_000
    notes_max: int = 10_000
    open_orders_max: int = 100_000
    unsifted: int = 1_024
    busy_timeout_ms: int = 250
    synchronous: str = "FULL"
    pages_max: int | None = None
    kept_days: int = 30
    checked_bytes: int = 64 << 20
