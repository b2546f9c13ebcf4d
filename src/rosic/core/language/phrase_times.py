"""When something is to be done, in a line that says what: ``tomorrow at 8``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.language.lexicon import SenseKind

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.language.phrase_words import Item

UNSURE: Final = "?"
"""A line speaks of a time that is not read."""
_CLOCK: Final = re.compile(r"(\d{1,2})[:.h](\d\d)")
_LENGTHS: Final = frozenset({"min", "h"})
_BEFORE_NUMBER: Final = frozenset({"at", "in"})
_SAYS_NOTHING: Final = frozenset({"at", "oclock"})


class TimedLine(NamedTuple):
    """A line taken apart.

    Attributes:
        when: As ``/schedule`` reads it; empty: the line says no time.
        items: The other words.
    """

    when: str
    items: list[Item]


def without_time(items: Sequence[Item]) -> TimedLine:
    """Return the time that a line says, and the words that say what is to be done then.

    A number belongs to the time behind ``at`` and behind a day, before ``o'clock``, and with what
    counts it behind ``in``.
    """
    words: list[str] = []
    others: list[Item] = []
    at = 0
    while at < len(items):
        said, end = _time_at(items, at, words)
        if end == at:
            others.append(items[at])
            end = at + 1
        words += said
        at = end
    hours = sum(":" in word for word in words)
    unsure = hours > 1 or words[-1:] == ["every"] or any(word in _LENGTHS for word in left(others))
    if words and unsure:
        return TimedLine(UNSURE, others)
    return TimedLine(" ".join(words), others) if words else TimedLine("", list(items))


def left(items: Sequence[Item]) -> list[str]:
    """Return the words of a time that have no place in it."""
    return [word for item in items for word in item.values(SenseKind.TIME)]


def _time_at(items: Sequence[Item], at: int, before: Sequence[str]) -> tuple[list[str], int]:
    """Return the words of a time that stand here, and where they end: here, if none do."""
    item = items[at]
    clock = _clock(item)
    if clock:
        return [clock], at + 1
    said = item.values(SenseKind.TIME)
    if not said:
        return _hour(items, at, counted=bool(before))
    word = said[0]
    if word not in _BEFORE_NUMBER:
        return ([] if word in _SAYS_NOTHING or word in _LENGTHS else [word]), at + (
            word not in _LENGTHS
        )
    if word == "in":
        return _length(items, at)
    found, end = _hour(items, at + 1, counted=True)
    if not found and at + 1 < len(items) and (clock := _clock(items[at + 1])):
        return [clock], at + 2
    return (found, end) if found else ([], at)


def _hour(items: Sequence[Item], at: int, *, counted: bool) -> tuple[list[str], int]:
    """Return a full hour: a number that is counted as one, or that what is before counts."""
    number = _number(items, at)
    if number is None or not 0 <= number < 25:  # noqa: PLR2004 - hours of a day
        return [], at
    after = items[at + 1].values(SenseKind.TIME) if at + 1 < len(items) else ()
    unit = at + 1 < len(items) and items[at + 1].means(SenseKind.UNIT)
    if "oclock" in after:
        return [f"{number:.0f}:00"], at + 2
    return ([f"{number:.0f}:00"], at + 1) if counted and not unit and not after else ([], at)


def _length(items: Sequence[Item], at: int) -> tuple[list[str], int]:
    """Return ``in 10 min``."""
    number = _number(items, at + 1)
    after = items[at + 2].values(SenseKind.TIME) if at + 2 < len(items) else ()
    unit = next((word for word in after if word in _LENGTHS), "")
    return ([f"in {number:.10g} {unit}"], at + 3) if number is not None and unit else ([], at)


def _number(items: Sequence[Item], at: int) -> float | None:
    if at >= len(items):
        return None
    numeral, numbers = items[at].numeral, items[at].values(SenseKind.NUMBER)
    if numeral is not None:
        return numeral.value if not numeral.rest and not numeral.readings else None
    return float(numbers[0]) if numbers else None


def _clock(item: Item) -> str:
    found = _CLOCK.fullmatch(item.text)
    return f"{int(found[1])}:{found[2]}" if found else ""
