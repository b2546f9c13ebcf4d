"""The files that a running gateway keeps open, and whether each is still where it was opened.

A file that was removed or replaced goes on being written, and nobody will ever read it again; nor
will anybody read what is written into one that was emptied or written over. Whatever keeps a file
from being looked at counts as its loss.
"""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


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
