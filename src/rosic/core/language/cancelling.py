"""Does somebody end what they have under way? Asked of every message, right after `hears_stop`.

It ends orders of one's own and latches nothing. As with a stop, what is not understood in it makes
it mean more and not less: everything of theirs.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rosic.core.language.cancel_words import CANCEL, KEPT, MISSPELT, TASKS, WITH
from rosic.core.language.sanitise import is_plain
from rosic.core.language.stop_detection import (
    LONGEST_LINE,
    LONGEST_SHOUT,
    hears_stop,
    lines_of,
    words_of,
)
from rosic.core.language.stop_words import ALONG, EVERYTHING, UNSAID, fold_stop

if TYPE_CHECKING:
    from collections.abc import Container

# So much of a text is looked at; a cancel further behind is read in its turn.
LOOKED_AT = 512
# The number of a booking, or a time of day.
_NUMBERED = re.compile(r"\b(?:[0-9a-f]{8,}|\d{1,2}[:.]\d\d)\b")


def is_cancel_word(word: str) -> bool:
    """Whether a word ends what somebody has under way, so that nothing else may be called so."""
    return fold_stop(word) in CANCEL


def hears_cancel(text: str, known: Container[str] = ()) -> tuple[str, ...] | None:
    """Return of whom a text ends what its author has under way, or None if it ends nothing.

    One line that does makes the whole text do so. Takes time linear in the first 512 characters and
    none for the rest.

    Args:
        text: Raw, as received; any ``str``.
        known: Names of robots, groups, skills, verbs and choices in small letters.

    Returns:
        The words said beside it, in small letters; ``()`` means everything of theirs.
    """
    head = text[:LOOKED_AT]
    if is_plain(head):
        words = words_of(head, known)
        if CANCEL.isdisjoint(words) and MISSPELT.isdisjoint(words):
            return None
    heard = [_heard(line, known) for line in lines_of(head)]
    found = [names for names in heard if names is not None]
    if not found:
        return None
    return () if () in found else tuple(dict.fromkeys([name for names in found for name in names]))


def is_urgent(text: str) -> bool:
    """Whether a text overtakes what was received before it: it stops something, or ends it."""
    return hears_stop(text) is not None or hears_cancel(text) is not None


def _heard(line: str, known: Container[str]) -> tuple[str, ...] | None:
    if len(line) > LONGEST_SHOUT or _NUMBERED.search(line):
        return None
    words = words_of(line, known)
    folded = [fold_stop(word) for word in words]
    at = [n for n, (w, f) in enumerate(zip(words, folded, strict=True)) if _ends(w, f, known)]
    unsaid = bool(at) and at[0] > 0 and folded[at[0] - 1] in UNSAID
    if not at or unsaid or not KEPT.isdisjoint(folded):
        return None
    others = tuple(w for w, f in zip(words, folded, strict=True) if not _is_aside(w, f, known))
    if not others or " ".join(others) in known or all(word in known for word in others):
        return others
    if not TASKS.isdisjoint(folded):
        return () if TASKS.issuperset(others) else None
    leads = all(_is_aside(w, f, known) for w, f in zip(words[: at[0]], folded, strict=False))
    if not leads or len(line.strip()) > LONGEST_LINE:
        return None
    return others if EVERYTHING.isdisjoint(folded) else ()


def _ends(word: str, folded: str, known: Container[str]) -> bool:
    return folded in CANCEL or (folded in MISSPELT and word not in known)


def _is_aside(word: str, folded: str, known: Container[str]) -> bool:
    if folded in CANCEL or folded in ALONG or folded in EVERYTHING:
        return True
    return (folded in WITH or folded in MISSPELT) and word not in known
