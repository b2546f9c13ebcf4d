"""What is asked of a file beyond the types of its keys: forms, bounds and checks.

Whoever owns a key says so here, an adapter for its own; ``config`` asks, and names file and line.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterable

# The way from the top of a file to one of its parts: ("skills", "grasp", "words", 0).
Place: TypeAlias = tuple[str | int, ...]


class FieldForm(NamedTuple):
    """What a text must look like.

    Attributes:
        pattern: Must match the whole text.
        meaning: Ends the sentence "this is not ...".
        empty: Whether nothing at all is right too.
    """

    pattern: str
    meaning: str
    hint: str
    empty: bool = False


class NumberBounds(NamedTuple):
    """Inclusive bounds of a number."""

    least: float
    most: float


class ValidationFinding(NamedTuple):
    """One thing that is wrong, in the part of the file that a rule was given.

    Attributes:
        place: Relative to that part.
    """

    place: Place
    sentence: str
    hint: str = ""


Field: TypeAlias = tuple[type, str]
Rule: TypeAlias = Callable[[Any], Iterator[ValidationFinding]]


class Rules(NamedTuple):
    """What is asked beyond the types. What is asked of a class is asked of those derived from it.

    Attributes:
        hidden: Fields that a file may not set.
        checks: Run on every object of a class that could be made.
    """

    bounds: Mapping[Field, NumberBounds]
    forms: Mapping[Field, FieldForm]
    hidden: frozenset[Field]
    checks: Mapping[type, tuple[Rule, ...]]


def nearest(word: str, known: Iterable[str], *, say_all: bool = True) -> str:
    """Return a hint: what was probably meant, or else all there is to choose from."""
    names = sorted(known)
    close = get_close_matches(word, names, n=1, cutoff=0.6)
    if close:
        return f"Did you mean {close[0]}?"
    return f"Known here: {', '.join(names)}." if names and say_all else ""
