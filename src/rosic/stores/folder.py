"""The folder of one gateway: its lock, and the root key that seals personal content."""

from __future__ import annotations

import fcntl
import os
import stat
from contextlib import suppress
from typing import TYPE_CHECKING

from rosic.errors import ConfigurationError
from rosic.stores.sealing import KEY_BYTES, Root, fresh_key

if TYPE_CHECKING:
    from pathlib import Path

LOCK = "gateway.lock"
ROOT_KEY = "root.key"
DATABASE = "rosic.db"


class Folder:
    """The place where one gateway keeps everything.

    Args:
        path: Made, for its owner only, when it does not exist.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lock: int | None = None

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
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            other = os.read(lock, 32).decode(errors="replace").strip() or "unknown"
            os.close(lock)
            raise ConfigurationError(
                f"Another gateway is already running on this data (process {other}).",
                hint="Stop it first, or give this one a data folder of its own.",
            ) from error
        os.ftruncate(lock, 0)
        os.pwrite(lock, f"{os.getpid()}\n".encode(), 0)
        self._lock = lock

    def give_back(self) -> None:
        """Let another gateway in."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def root(self) -> Root:
        """Return the root key; made when there is nothing yet that it could belong to.

        Raises:
            ConfigurationError: It is missing beside an existing record, others can read it, or
                it is not a key.
        """
        path = self.path / ROOT_KEY
        try:
            if not path.exists() and not self.database.exists():
                create(path, fresh_key())
            return Root(read_key(path))
        except FileNotFoundError as error:
            raise ConfigurationError(
                f"{path} is missing; without it the personal content of this record is unreadable.",
                hint="Put it back from your copy, or start with an empty data folder.",
            ) from error
        except OSError as error:
            raise ConfigurationError(
                f"{path} cannot be used ({error.strerror}).",
                hint="It must be a file that the user who runs ROSIC can read.",
            ) from error


def read_key(path: Path) -> bytes:
    """Read a key that only its owner can read.

    Raises:
        ConfigurationError: Others could read it, or it is not a key.
        OSError: It cannot be read.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        if stat.S_IMODE(os.fstat(descriptor).st_mode) & 0o077:
            raise ConfigurationError(
                f"{path} can be read by others.",
                hint=f"Run: chmod 600 {path} (and think about who may have read it).",
            )
        key = os.read(descriptor, KEY_BYTES + 1)
    finally:
        os.close(descriptor)
    if len(key) != KEY_BYTES:
        raise ConfigurationError(
            f"{path} is damaged: it must hold {KEY_BYTES} bytes.",
            hint="Put it back from your copy.",
        )
    return key


def create(path: Path, content: bytes) -> None:
    """Make a file for the owner alone: whole after a power cut, or not there at all.

    Raises:
        OSError: It could not be made. Nothing stays behind.
    """
    draft = path.with_name(f"{path.name}.new")
    with suppress(FileNotFoundError):
        draft.unlink()
    descriptor = os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o600)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        draft.rename(path)
    except OSError:
        with suppress(OSError):
            draft.unlink()
        raise
    sync(path.parent)


def sync(folder: Path) -> None:
    """Make the names in a folder survive a power cut."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
