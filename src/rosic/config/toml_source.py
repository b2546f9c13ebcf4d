"""TOML, read with the line of every key. `tomllib` reads the data; the lines are found here."""

from __future__ import annotations

import re
import tomllib
from typing import TYPE_CHECKING

from rosic.config.source_map import SourceMap, read_text
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.contracts.file_rules import Place

_SYNTAX = re.compile(
    r"(?P<what>.*?) \(at (?:line (?P<line>\d+), column (?P<column>\d+)|end of .*)\)"
)

LIST_HINT = "Write [[{}]], in two pairs of brackets."

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_SPACE = re.compile(r"[ \t]*")
_QUOTED = re.compile(
    r'"""(?:[^"\\]|\\.|"(?!""))*"{3,5}'
    r"|'''(?:[^']|'(?!''))*'{3,5}"
    r'|"(?:[^"\\]|\\.)*"'
    r"|'[^']*'",
    re.DOTALL,
)
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_BARE_VALUE = re.compile(r"[^,\]}#\n]+")


NONE_YET = "rosic init writes one; -c names another. rosic demo needs none."


def read_toml(path: Path) -> SourceMap:
    """Read one file.

    Raises:
        ConfigurationError: It cannot be read or is not TOML. ``where`` holds the line; nothing of
            the file's values is repeated, as one of them may be a secret.
    """
    name = str(path)
    text = read_text(path, NONE_YET).replace("\r\n", "\n")
    try:
        return SourceMap(name, tomllib.loads(text), _Lines(text).found, LIST_HINT)
    except tomllib.TOMLDecodeError as fault:
        raise _not_toml(name, text, str(fault)) from None
    except RecursionError:
        raise ConfigurationError("The file is too deeply nested.", where=name) from None


def _not_toml(name: str, text: str, message: str) -> ConfigurationError:
    found = _SYNTAX.fullmatch(message)
    what = found["what"] if found else "it cannot be read"
    what = what[:1].lower() + what[1:]
    if found and found["line"]:
        line, where = found["line"], f", column {found['column']}"
    else:
        line, where = str(text.count("\n") + 1), ", at the end"
    return ConfigurationError(
        f"This is not TOML{where}: {what}.",
        where=f"{name}:{line}",
        hint="Texts stand in quotes, and each key on a line of its own.",
    )


class _Lines:
    """Walks through a text that is known to be TOML and notes where keys and items stand."""

    def __init__(self, text: str) -> None:
        self.found: dict[Place, int] = {}
        self._text = text
        self._at = 0
        self._counted = (0, 1)
        self._arrays: dict[Place, int] = {}
        self._walk()

    def _walk(self) -> None:
        table: Place = ()
        self._skip(_BLANK)
        while self._at < len(self._text):
            if self._text[self._at] == "[":
                table = self._header()
            else:
                self._pair(table)
            self._skip(_BLANK)

    def _skip(self, pattern: re.Pattern[str]) -> str:
        match = pattern.match(self._text, self._at)
        if match is None:
            return ""
        self._at = match.end()
        return match[0]

    def _line(self) -> int:
        at, line = self._counted
        line += self._text.count("\n", at, self._at)
        self._counted = (self._at, line)
        return line

    def _header(self) -> Place:
        line = self._line()
        many = self._text.startswith("[[", self._at)
        self._at += 2 if many else 1
        *above, last = self._keys()
        self._at += 2 if many else 1
        place: Place = ()
        for key in above:
            place = self._newest((*place, key))
            self.found.setdefault(place, line)
        place = (*place, last)
        self.found.setdefault(place, line)
        if many:
            self._arrays[place] = self._arrays.get(place, 0) + 1
        place = self._newest(place)
        self.found.setdefault(place, line)
        return place

    def _newest(self, place: Place) -> Place:
        """Return the last table of an array of tables, or the place itself."""
        count = self._arrays.get(place)
        return place if count is None else (*place, count - 1)

    def _keys(self) -> list[str]:
        keys: list[str] = []
        while True:
            self._skip(_SPACE)
            quoted = self._skip(_QUOTED)
            if quoted:
                keys.append(str(tomllib.loads(f"key = {quoted}")["key"]))
            else:
                keys.append(self._skip(_BARE_KEY))
            self._skip(_SPACE)
            if not self._text.startswith(".", self._at):
                return keys
            self._at += 1

    def _pair(self, table: Place) -> None:
        line = self._line()
        place = table
        for key in self._keys():
            place = (*place, key)
            self.found.setdefault(place, line)
        self._at += 1
        self._skip(_SPACE)
        self._value(place)

    def _value(self, place: Place) -> None:
        opening = self._text[self._at]
        if opening == "[":
            self._items(place, "]")
        elif opening == "{":
            self._items(place, "}")
        elif not self._skip(_QUOTED):
            self._skip(_BARE_VALUE)

    def _items(self, place: Place, closing: str) -> None:
        self._at += 1
        self._skip(_BLANK)
        index = 0
        while self._text[self._at] != closing:
            if closing == "}":
                self._pair(place)
            else:
                self.found[*place, index] = self._line()
                self._value((*place, index))
            index += 1
            self._skip(_BLANK)
            if self._text[self._at] == ",":
                self._at += 1
                self._skip(_BLANK)
        self._at += 1
