"""Small secrets in a folder: sealed under a key that lies beside them, all for their owner alone.

The key keeps what a backup or a glance at one file shows from being worth anything without it.
Whoever can read the whole folder can read everything.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Final

from nacl.exceptions import CryptoError
from nacl.secret import SecretBox
from nacl.utils import random

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from pathlib import Path

KEY_FILE: Final = "folder.key"


class SealedFolder:
    """Nothing is read or written before `open`.

    Args:
        path: Made where it is not there.
    """

    _box: SecretBox

    def __init__(self, path: Path) -> None:
        self.path = path
        self._key = b""

    def open(self) -> None:
        """Make it ready.

        Raises:
            ConfigurationError: It cannot be used, or its key is not one.
        """
        try:
            self.path.mkdir(mode=0o700, parents=True, exist_ok=True)
            self._close_to_others()
            file = self.path / KEY_FILE
            if not file.exists():
                self._put(file, random(SecretBox.KEY_SIZE))
            self._key = file.read_bytes()
            self._box = SecretBox(self._key)
        except (OSError, CryptoError, ValueError) as error:
            raise ConfigurationError(
                f"The folder {self.path} cannot be used for the keys of Matrix.",
                hint=f"({type(error).__name__})",
            ) from None

    @property
    def passphrase(self) -> str:
        """What else in this folder is sealed with, by those who want a text."""
        return self._key.hex()

    def read(self, name: str) -> bytes | None:
        """Return what was kept under a name; None for nothing.

        Raises:
            ConfigurationError: It is there, and was not sealed by us.
        """
        try:
            sealed = (self.path / name).read_bytes()
        except FileNotFoundError:
            return None
        try:
            return self._box.decrypt(sealed)
        except CryptoError:
            raise ConfigurationError(
                f"{self.path / name} was changed, or belongs to another folder.",
                hint="Bring the whole folder back from one backup.",
            ) from None

    def write(self, name: str, content: bytes) -> None:
        """Keep something under a name: all of it, or what was there before.

        Raises:
            OSError: It was not kept.
        """
        self._put(self.path / name, bytes(self._box.encrypt(content)))

    def _close_to_others(self) -> None:
        """Take from others what they may do here: what lies in it was perhaps made by hand."""
        self.path.chmod(0o700)
        for file in self.path.iterdir():
            if file.is_file() and not file.is_symlink():
                file.chmod(0o600)

    def _put(self, file: Path, content: bytes) -> None:
        """Have it under its name all at once, and there still when the power fails then."""
        new = file.with_suffix(".new")
        new.unlink(missing_ok=True)
        opened = os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            rest = memoryview(content)
            while rest:
                rest = rest[os.write(opened, rest) :]
            os.fsync(opened)
        finally:
            os.close(opened)
        new.replace(file)
        folder = os.open(self.path, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(folder)
        finally:
            os.close(folder)
