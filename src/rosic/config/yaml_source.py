"""YAML, as much of it as a profile needs, read with the line of every key.

Only plain data is built, by the code below, from the parser's events: no tags, no anchors, no
merging, one document. ``on``, ``yes`` and ``12:30`` are texts here, as in YAML 1.2; a robot whose
choice is called ``off`` keeps it.
"""

from __future__ import annotations

import re
from math import isfinite
from typing import TYPE_CHECKING

import yaml

from rosic.config.source_map import Data, SourceMap, read_text
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rosic.contracts.file_rules import Place

DEPTH_LIMIT = 16
PARTS_LIMIT = 20_000
DIGITS_LIMIT = 40

_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|nan)", re.IGNORECASE)
_CONSTANTS: dict[str, bool | None] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
# Written in C where there is one: a file takes a tenth of the time, and a fleet is many files.
_FAST = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_yaml(path: Path) -> SourceMap:
    """Read one file.

    Raises:
        ConfigurationError: It cannot be read, is not YAML, or uses more of YAML than is allowed
            here. ``where`` holds the line.
    """
    return parse_yaml(read_text(path), str(path))


def parse_yaml(text: str, name: str) -> SourceMap:
    """Read what stands in a file.

    Raises:
        ConfigurationError: As `read_yaml` does.
    """
    try:
        return _Builder(name, yaml.parse(text, Loader=_FAST)).build()
    except (yaml.YAMLError, ConfigurationError):
        # What is wrong is always said in the same words, with the same line.
        return _read_slowly(text, name)


def _read_slowly(text: str, name: str) -> SourceMap:
    try:
        return _Builder(name, yaml.parse(text, Loader=yaml.SafeLoader)).build()
    except yaml.reader.ReaderError as fault:
        line = text.count("\n", 0, fault.position) + 1
        raise ConfigurationError(
            "The file holds a character that YAML does not allow.", where=f"{name}:{line}"
        ) from None
    except yaml.MarkedYAMLError as fault:
        mark = fault.problem_mark or fault.context_mark
        raise ConfigurationError(
            f"This is not YAML: {fault.problem or fault.context}.",
            where=f"{name}:{mark.line + 1}" if mark else name,
            hint="Look at the indentation, and put texts with special characters in quotes.",
        ) from None


class _Builder:
    """Turns the events of one document into data and lines."""

    def __init__(self, name: str, events: Iterator[yaml.Event]) -> None:
        self._name = name
        self._events = events
        self._lines: dict[Place, int] = {}
        self._parts = 0

    def build(self) -> SourceMap:
        next(self._events)
        if isinstance(next(self._events), yaml.StreamEndEvent):
            raise ConfigurationError("The file is empty.", where=self._name)
        data = self._value(next(self._events), ())
        next(self._events)
        extra = next(self._events)
        if not isinstance(extra, yaml.StreamEndEvent):
            raise self._error(extra, "A second document begins here.", "Keep one robot a file.")
        return SourceMap(self._name, data, self._lines)

    def _error(self, event: yaml.Event, sentence: str, hint: str = "") -> ConfigurationError:
        where = f"{self._name}:{_line(event)}"
        return ConfigurationError(sentence, where=where, hint=hint)

    def _value(self, event: yaml.Event, place: Place) -> Data:
        self._parts += 1
        if self._parts > PARTS_LIMIT or len(place) > DEPTH_LIMIT:
            raise self._error(event, "The file is too large or too deeply nested for a profile.")
        if isinstance(event, yaml.NodeEvent) and event.anchor is not None:
            raise self._error(
                event, "Anchors and aliases (& and *) are not used here.", "Write it out."
            )
        if getattr(event, "tag", None) is not None:
            raise self._error(event, "Tags (!) are not used here.", "Write the plain value.")
        if isinstance(event, yaml.ScalarEvent):
            return self._scalar(event)
        if isinstance(event, yaml.SequenceStartEvent):
            return self._sequence(place)
        return self._mapping(place)

    def _sequence(self, place: Place) -> list[Data]:
        items: list[Data] = []
        while not isinstance(event := next(self._events), yaml.SequenceEndEvent):
            here = (*place, len(items))
            self._lines[here] = _line(event)
            items.append(self._value(event, here))
        return items

    def _mapping(self, place: Place) -> dict[str, Data]:
        entries: dict[str, Data] = {}
        while not isinstance(event := next(self._events), yaml.MappingEndEvent):
            key = self._key(event, place)
            if key in entries:
                first = self._lines[*place, key]
                raise self._error(
                    event, f"{key!r} stands here twice.", f"The first is on line {first}."
                )
            here = (*place, key)
            self._lines[here] = _line(event)
            entries[key] = None
            entries[key] = self._value(next(self._events), here)
        return entries

    def _key(self, event: yaml.Event, place: Place) -> str:
        if not isinstance(event, yaml.ScalarEvent):
            raise self._error(event, "A key must be a word, not a list or a table.")
        self._value(event, place)
        return str(event.value)

    def _scalar(self, event: yaml.ScalarEvent) -> Data:
        text: str = event.value
        if any("\ud800" <= letter <= "\udfff" for letter in text):
            raise self._error(event, "This text holds half a character.")
        if event.style:  # quoted, or a block; a plain word has none
            return text
        if text in _CONSTANTS:
            return _CONSTANTS[text]
        if _NOT_FINITE.fullmatch(text):
            raise self._error(event, f"{text} is not a finite number.")
        if len(text) > DIGITS_LIMIT and _FLOAT.fullmatch(text):
            raise self._error(event, "This number is too long.")
        if _INTEGER.fullmatch(text):
            return int(text)
        if _FLOAT.fullmatch(text):
            return self._number(event, float(text))
        return text

    def _number(self, event: yaml.ScalarEvent, number: float) -> float:
        if not isfinite(number):
            raise self._error(event, f"{event.value} is not a finite number.")
        return number


def _line(event: yaml.Event) -> int:
    mark = event.start_mark
    return 1 if mark is None else mark.line + 1
