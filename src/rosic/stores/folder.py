"""The folder of one gateway: its lock, and the root key that seals personal content."""

from __future__ import annotations

import fcntl
import os
from typing import TYPE_CHECKING

from rosic.errors import ConfigurationError
from rosic.stores.rootkey import ROOT_KEY, root_of

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.stores.sealing import Root

LOCK = "gateway.lock"
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
        try:
            return root_of(self.path, os.environ, begun=self.database.exists())
        except OSError as error:
            raise ConfigurationError(
                f"{error.filename or self.path / ROOT_KEY} cannot be used ({error.strerror}).",
                hint="It must be a file that the user who runs ROSIC can read.",
            ) from error
