"""When something is to be done, in a line that says what: ``tomorrow at 8``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.language.lexicon import SenseKind
from rosic.core.language.phrase_words import CLOCK

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from rosic.core.language.phrase_words import Item

UNSURE: Final = "?"
"""A line speaks of a time that is not read."""
_LENGTHS: Final = frozenset({"min", "h"})
_BEFORE_NUMBER: Final = frozenset({"at", "in"})
_MINUTES: Final = {"half past": 30, "half to": -30, "quarter past": 15, "quarter to": -15}
_HALVES: Final = frozenset({"am", "pm"})
_HALF: Final = 0.5
_SIGNED: Final = re.compile(r"(\d{1,4})(h|min)")
_DAY_MIN: Final = 24 * 60
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
    if not any(item.means(SenseKind.TIME) or CLOCK.fullmatch(item.text) for item in items):
        return TimedLine("", list(items))
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
    moments = hours or any(word == "noon" or word.startswith("in ") for word in words)
    unsure = (
        hours > 1
        or not moments
        or words[-1:] == ["every"]
        or any(word in _LENGTHS for word in left(others))
    )
    if unsure and (words or any("in" in item.values(SenseKind.TIME) for item in others)):
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
    if not said or said[0] in _MINUTES or said[0] in _HALVES:
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
    """Return an hour, with its half or quarter: a number that is one, or that is counted as one."""
    begin = at
    part, at = _one_of(items, at, _MINUTES)
    half, at = _one_of(items, at, _HALVES)
    number = _hour_said(items, at) if counted else _number(items, at)
    if number is None or not 0 <= number < 25 or number % 1:  # noqa: PLR2004 - hours of a day
        return [], begin
    clock, at = _one_of(items, at + 1, ("oclock",))
    minutes, at = _minutes(items, at) if clock else (0, at)
    after, at = _one_of(items, at, () if part else tuple(_MINUTES))
    half, at = (half, at) if half else _one_of(items, at, _HALVES)
    unit = at < len(items) and items[at].means(SenseKind.UNIT)
    if unit or left(items[at : at + 1]) or not (counted or part or half or clock):
        return [], begin
    hour = int(number) + 12 if half == "pm" and number < 12 else int(number) % 24  # noqa: PLR2004
    of_day = (60 * hour + minutes + _MINUTES.get(part or after, 0)) % _DAY_MIN
    return [f"{of_day // 60}:{of_day % 60:02}"], at


def _hour_said(items: Sequence[Item], at: int) -> float | None:
    """Return the number of an hour, which may have its sign behind it: ``8h``."""
    found = _SIGNED.fullmatch(items[at].text) if at < len(items) else None
    return float(found[1]) if found and found[2] == "h" else _number(items, at)


def _one_of(items: Sequence[Item], at: int, words: Collection[str]) -> tuple[str, int]:
    """Return which of some words of a time stands here, and what is behind it."""
    said = items[at].values(SenseKind.TIME) if at < len(items) else ()
    found = next((word for word in said if word in words), "")
    return found, at + bool(found)


def _minutes(items: Sequence[Item], at: int) -> tuple[int, int]:
    """Return the minutes that follow an hour: ``8 Uhr 30``."""
    number = _number(items, at)
    unit = at + 1 < len(items) and items[at + 1].means(SenseKind.UNIT)
    if number is None or not 0 < number < 60 or number % 1 or unit:  # noqa: PLR2004
        return 0, at
    return int(number), at + 1


def _length(items: Sequence[Item], at: int) -> tuple[list[str], int]:
    """Return ``in 10 min``."""
    signed = _SIGNED.fullmatch(items[at + 1].text) if at + 1 < len(items) else None
    if signed:  # in 8h
        return [f"in {signed[1]} {signed[2]}"], at + 2
    if (
        at + 2 < len(items)
        and items[at + 1].means(SenseKind.ONE)
        and _number(items, at + 2) == _HALF
    ):
        at += 1  # in einer halben Stunde
    number = _number(items, at + 1)
    after = items[at + 2].values(SenseKind.TIME) if at + 2 < len(items) else ()
    unit = next((word for word in after if word in _LENGTHS), "")
    return ([f"in {number:.10g} {unit}"], at + 3) if number is not None and unit else ([], at)


def _number(items: Sequence[Item], at: int) -> float | None:
    if at >= len(items):
        return None
    if items[at].means(SenseKind.ONE):
        return 1.0
    numeral, numbers = items[at].numeral, items[at].values(SenseKind.NUMBER)
    if numeral is not None:
        return numeral.value if not numeral.rest and not numeral.readings else None
    return float(numbers[0]) if numbers else None


def _clock(item: Item) -> str:
    found = CLOCK.fullmatch(item.text)
    return f"{int(found[1])}:{found[2]}" if found else ""
