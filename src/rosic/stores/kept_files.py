"""The files that a running gateway keeps open, and whether each is still where it was opened.

A file that was removed or replaced goes on being written, and nobody will ever read it again.
"""

from __future__ import annotations

import os
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


class KeptFiles:
    """Files by path, each with the number of what was opened there. Looked at from any thread."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[int, int]] = {}

    def know(self, path: Path, descriptor: int | None = None) -> None:
        """Take a file for the one that belongs there: what is open, or what is there now.

        Raises:
            OSError: It is not there.
        """
        self._known[str(path)] = _number(path if descriptor is None else descriptor)

    def know_if_there(self, path: Path) -> None:
        """Take a file for the one that belongs there, if there is one."""
        with suppress(OSError):
            self.know(path)

    def forget(self, path: Path) -> None:
        """Look at a file no more: it was closed."""
        self._known.pop(str(path), None)

    def lost(self) -> str:
        """Return the path of a file that is gone or was replaced; empty while all are there."""
        for path, number in tuple(self._known.items()):
            try:
                if _number(path) != number:
                    return path
            except OSError:
                return path
        return ""

    def is_lost(self, path: Path) -> bool:
        """Whether one file is gone or was replaced."""
        number = self._known.get(str(path))
        try:
            return number is not None and _number(path) != number
        except OSError:
            return True


def _number(file: Path | str | int) -> tuple[int, int]:
    status = os.stat(file)  # noqa: PTH116 - asked around every commit
    return status.st_dev, status.st_ino
