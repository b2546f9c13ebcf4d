"""Did you mean? Only asked when something was not understood, and bounded then."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

MOST_CANDIDATES = 512
MOST_SUGGESTIONS = 3
LONGEST_WORD = 32
OR, AND = said(" or "), said(" and ")
_SHORT = 4  # up to this length one slip of a finger is enough to be another word
_PREFIX = 3


def distance(left: str, right: str, limit: int) -> int:
    """Return how many slips of a finger lie between two words, or ``limit + 1`` if more.

    A slip is a letter left out, put in, taken for another, or two neighbours swapped (optimal
    string alignment).
    """
    if abs(len(left) - len(right)) > limit:
        return limit + 1
    before: list[int] = []
    row = list(range(len(right) + 1))
    for i, a in enumerate(left, 1):
        before, above, row = row, before, [i]
        for j, b in enumerate(right, 1):
            best = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (a != b))
            if j > 1 and above and a == right[j - 2] and b == left[i - 2]:
                best = min(best, above[j - 2] + 1)
            row.append(best)
        if min(row) > limit:
            return limit + 1
    return row[-1]


def did_you_mean(word: str, candidates: Iterable[str]) -> tuple[str, ...]:
    """Return up to three candidates that may have been meant: the closest ones.

    Looks at no more than 512 candidates, whatever is given.
    """
    word = word.casefold()
    if not word or len(word) > LONGEST_WORD:
        return ()
    limit = 2 if len(word) > _SHORT else 1 if len(word) > 1 else 0
    letters = set(word)
    found: dict[str, int] = {}
    length = len(word)
    begins = length >= _PREFIX
    for candidate in islice(candidates, MOST_CANDIDATES):
        folded = candidate.casefold()
        if begins and folded.startswith(word):
            found[candidate] = limit
        elif -limit <= len(folded) - length <= limit and len(letters ^ set(folded)) <= 2 * limit:
            slips = distance(word, folded, limit)
            if slips <= limit:
                found[candidate] = slips
    closest = min(found.values(), default=0)
    return tuple(sorted(c for c in found if found[c] == closest))[:MOST_SUGGESTIONS]


def one_each(words: tuple[str, ...], meanings: Mapping[str, object]) -> tuple[str, ...]:
    """Return the words without those that mean the same as an earlier one."""
    kept: dict[int, str] = {}
    for word in words:
        kept.setdefault(id(meanings.get(word, word)), word)
    return tuple(kept.values())


def listed(words: tuple[str, ...], joint: str = OR) -> str:
    """Return ``a``, ``a or b``, ``a, b or c``."""
    *before, last = words or ("",)
    return joined(joint, (joined(", ", before), last)) if before else last
