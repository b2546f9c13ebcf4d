"""The values in a command: ``50 cm``, ``force = 20``, ``left``, ``half a metre``."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from rosic.core.language.keywords import (
    AND_ALSO,
    BEFORE_TIMES,
    FILLERS,
    NOT_FINITE,
    NUMBERS,
    SOFT_FILLERS,
)
from rosic.core.language.numbers import read_numeral
from rosic.core.order import SpokenValue

if TYPE_CHECKING:
    from rosic.core.language.compiled import CompiledSkill
    from rosic.core.language.numbers import UnitTable

_SKIPPED = FILLERS | SOFT_FILLERS
_PER = frozenset({"per", "pro"})


class AmbiguousNumber(Exception):  # never leaves this package
    """A number may mean two numbers.

    Attributes:
        at: Place of the word.
        readings: What to put there instead.
    """

    def __init__(self, at: int, readings: tuple[str, ...]) -> None:
        super().__init__()
        self.at = at
        self.readings = readings


class ValueReader:
    """Reads values from words, each word once.

    Nothing is refused here: a word that means nothing stays a word, and binding says so.

    Attributes:
        unsure: A word, a unit or a number below zero may not be what the skill takes.
    """

    __slots__ = ("_at", "_low", "_raw", "_skill", "_units", "unsure")

    def __init__(
        self, raw: list[str], low: list[str], at: int, skill: CompiledSkill, units: UnitTable
    ) -> None:
        self._raw = raw
        self._low = low
        self._at = at
        self._skill = skill
        self._units = units
        self.unsure = False

    def read(self) -> tuple[SpokenValue, ...]:
        """Return the values from here to the end of the line.

        Raises:
            AmbiguousNumber: A number may mean two numbers.
        """
        low = self._low
        words = self._skill.words
        end = len(low)
        spoken: list[SpokenValue] = []
        while self._at < end:
            word = low[self._at]
            if word in words and not self._has_equals():
                self._at += 1
                spoken.append(SpokenValue("", None, word))
            elif word.replace(".", "", 1).isdecimal():
                value = self._value("")
                self.unsure = self.unsure or (low[self._at - 2] in BEFORE_TIMES and not value.word)
                spoken.append(value)
            elif (word in FILLERS and not self._is_one(word)) or self._is_soft(word):
                self._at += 1
                after = low[self._at] if self._at < end else ""
                self.unsure = self.unsure or (word in AND_ALSO and after in words)
            else:
                spoken.append(self._named_or_value(word))
        return tuple(spoken)

    def _has_equals(self) -> bool:
        after = self._at + 1
        return after < len(self._low) and self._low[after] == "="

    def _is_soft(self, word: str) -> bool:
        """Whether a word carries no meaning, unless it is the name of a value or of a unit."""
        return (
            word in SOFT_FILLERS
            and word not in self._skill.by_name
            and word not in self._skill.longest_word
            and not self._has_equals()
        )

    def _is_one(self, word: str) -> bool:
        """Whether ``a`` or ``an`` stands for 1: ``a metre``."""
        after = self._at + 1
        return (
            word in {"a", "an"}
            and after < len(self._low)
            and self._low[after] not in self._skill.plain_words
            and self._units.find(self._raw[after]) is not None
        )

    def _named_or_value(self, word: str) -> SpokenValue:
        if self._has_equals():
            self._at += 2
            return self._value(word)
        if word in self._skill.by_name:
            self._at += 1
            while self._at < len(self._low) and self._low[self._at] in FILLERS:
                self._at += 1
            return self._value(word)
        return self._value("")

    def _value(self, name: str) -> SpokenValue:
        """Read one value here; at the end of the line there is none."""
        at = self._at
        if at >= len(self._low):
            return SpokenValue(name, None, "")
        word = self._low[at]
        self._at = at + 1
        if word.replace(".", "", 1).isdecimal():
            return SpokenValue(name, float(word), self._unit())
        numeral = read_numeral(self._raw[at])
        if numeral is not None:
            if numeral.readings:
                raise AmbiguousNumber(at, tuple(r + numeral.rest for r in numeral.readings))
            below = numeral.value < 0 and not name  # x=-2 says what it says; left -2 may not
            self.unsure = self.unsure or below or bool(numeral.rest)
            return SpokenValue(name, numeral.value, numeral.rest or self._unit())
        return self._word(name, word)

    def _word(self, name: str, word: str) -> SpokenValue:
        for count in range(self._skill.longest_word.get(word, 0), 1, -1):
            phrase = " ".join(self._low[self._at - 1 : self._at - 1 + count])
            if phrase in self._skill.words:
                self._at += count - 1
                return SpokenValue(name, None, phrase)
        if word in self._skill.words:
            return SpokenValue(name, None, word)
        number = 1.0 if word in {"a", "an"} else NUMBERS.get(word, NOT_FINITE.get(word))
        self.unsure = self.unsure or number is None or not isfinite(number)
        if number is None:
            return SpokenValue(name, None, word)
        while self._at < len(self._low) and self._low[self._at] in {"a", "an", "of"}:
            self._at += 1
        unit = self._unit()
        if number % 1 > 0 and not unit:  # half to the left
            self.unsure = True
            return SpokenValue(name, None, word)
        return SpokenValue(name, number, unit)

    def _unit(self) -> str:
        """Read the unit of the number before, if one follows; else return an empty text."""
        at = self._at
        if at >= len(self._low):
            return ""
        raw, low = self._raw[at], self._low[at]
        skill = self._skill
        if low in skill.plain_words or self._has_equals():
            return ""
        if raw not in self._units.exact:
            if low in _SKIPPED or low in skill.words or low in skill.by_name or low in NUMBERS:
                return ""
            if low in skill.longest_word or read_numeral(raw) is not None or low == "=":
                return ""
        self._at = at + 1
        unit = self._units.exact.get(raw)
        after = self._low[at + 1] if at + 1 < len(self._low) else ""
        ends = not after or (after in skill.words and after not in skill.by_name)
        doubtful = unit is None or unit.dimension not in skill.dimensions
        self.unsure = self.unsure or doubtful or (raw == "in" and not ends)
        return self._per(raw)

    def _per(self, raw: str) -> str:
        """Read on where a unit has several words: ``metres per second``."""
        at = self._at
        if at + 1 < len(self._low) and self._low[at] in _PER:
            phrase = f"{raw} {self._low[at]} {self._raw[at + 1]}"
            if self._units.find(phrase) is not None:
                self._at = at + 2
                return phrase
        return raw
