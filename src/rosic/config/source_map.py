"""A file that was read: what it says, and on which line each part of it stands."""

from __future__ import annotations

import stat
from typing import TYPE_CHECKING, Any, TypeAlias

from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rosic.contracts.file_rules import Place

SIZE_LIMIT_BYTES = 1 << 20

# What a file says, before anything about it is known: whoever uses it looks first.
Data: TypeAlias = Any


class SourceMap:
    """The content of a file, with marks.

    Attributes:
        name: The file as it was named, for people.
        data: Tables, lists, texts, numbers, truth values; None where nothing was written.
        lines: Line of the key that leads to a place, or of the item in a list; from 1.
        list_hint: How a list of tables is written in this kind of file; ``{}`` is its key.
    """

    def __init__(
        self, name: str, data: Data, lines: Mapping[Place, int], list_hint: str = ""
    ) -> None:
        self.name = name
        self.list_hint = list_hint
        self.data = data
        self.lines = lines

    def where(self, place: Place) -> str:
        """Return ``file:line`` of a place, or of the nearest part around it that has a line."""
        for length in range(len(place), -1, -1):
            line = self.lines.get(place[:length])
            if line is not None:
                return f"{self.name}:{line}"
        return self.name

    def error(self, place: Place, sentence: str, hint: str = "") -> ConfigurationError:
        """Return an error that points at a place."""
        return ConfigurationError(sentence, where=self.where(place), hint=hint)


def read_text(path: Path, missing: str = "") -> str:
    """Read a small UTF-8 file.

    Args:
        path: Which.
        missing: What helps where there is none.

    Raises:
        ConfigurationError: Missing, unreadable, not a file, too large, or not UTF-8.
    """
    name = str(path)
    try:
        with path.open("rb") as file:
            raw = file.read(SIZE_LIMIT_BYTES + 1)
    except FileNotFoundError:
        raise ConfigurationError("There is no such file.", where=name, hint=missing) from None
    except IsADirectoryError:
        raise ConfigurationError("This is a folder, not a file.", where=name) from None
    except PermissionError:
        raise ConfigurationError("The file may not be read.", where=name) from None
    except (OSError, ValueError) as fault:
        raise ConfigurationError("The file cannot be read.", where=name) from fault
    if len(raw) > SIZE_LIMIT_BYTES:
        raise ConfigurationError("The file is larger than 1 MiB.", where=name)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        line = raw.count(b"\n", 0, fault.start) + 1
        raise ConfigurationError(
            "The file is not UTF-8 text.", where=f"{name}:{line}", hint="Save it as UTF-8."
        ) from None


def readable_by_others(path: Path) -> bool:
    """Whether anybody but the owner of a file may read it."""
    return bool(stat.S_IMODE(path.stat().st_mode) & (stat.S_IRWXG | stat.S_IRWXO))
