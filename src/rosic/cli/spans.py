"""Lengths of time, as people write them after an option: ``2h``, ``90 min``, ``3 days``."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rosic.core.language.time_tokens import TimeTokens, UnclearTime
from rosic.errors import OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Iterable

_NEGATIVE = re.compile(r"-\.?\d")


def seconds(option: str, text: str, *, zero: bool = False) -> float:
    """Return how many seconds a text says.

    Args:
        option: For the sentence.
        text: As typed.
        zero: Whether no time at all is a length here.

    Raises:
        OutOfBounds: It is no length of time, or none at all, or less.
    """
    if _NEGATIVE.match(text.strip()):
        raise OutOfBounds(f"{option} {text} is less than no time. Nothing was done.")
    try:
        said = TimeTokens(text)
    except UnclearTime:
        said = None
    length_s = None if said is None or not _alone(said) else said.length_s
    if length_s is None:
        raise OutOfBounds(
            f"I cannot read {option} {text!r} as a length of time. Write {option} 2h, "
            f"{option} 30min or {option} 3d."
        )
    if length_s <= 0 and not zero:
        raise OutOfBounds(f"{option} {text} is no time at all. Nothing was done.")
    return length_s


def _alone(said: TimeTokens) -> bool:
    """Whether a length is all that was said."""
    other = (said.start, said.end, said.day, said.date, said.delay_s, said.count, said.until)
    return not said.weekdays and all(part is None for part in other)


def joined(arguments: Iterable[str], options: Iterable[str]) -> list[str]:
    """Return arguments in which a negative length belongs to its option.

    Otherwise ``--for -1h`` reads as two options, and the sentence would be about that.
    """
    spans, found = set(options), list[str]()
    for word in arguments:
        if found and found[-1] in spans and _NEGATIVE.match(word):
            found[-1] = f"{found[-1]}={word}"
        else:
            found.append(word)
    return found
