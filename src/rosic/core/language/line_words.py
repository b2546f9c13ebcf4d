"""The words of a line, as they are compared: what they mean is another question."""

from __future__ import annotations

from typing import Final, NamedTuple

from rosic.core.language.keywords import EXCEPTING, FILLERS
from rosic.core.language.sanitise import clean, fold_word

FOLDED_AT_MOST: Final = 1024

NEGATING: Final = frozenset({"minus", "nicht", "not"})
"""Of what leaves robots out, the words that also say something else in many a sentence."""

_ENDS: Final = ".,;:!?"


class LineWords(NamedTuple):
    """The words of a line.

    Attributes:
        raw: As typed.
        low: In small letters.
        slash: The line began with a slash, which is no part of the first word here.
    """

    raw: list[str]
    low: list[str]
    slash: bool


def words_of(line: str) -> LineWords:
    """Return the words of a line that is `clean`, has some, and begins and ends with one."""
    words = line
    if "=" in words:
        words = words.replace("=", " = ")
    raw = words.split()
    if line[-1] in _ENDS or ", " in line or ": " in line or "; " in line:
        raw = [word.rstrip(_ENDS) or word for word in raw]
    if not line.isascii():
        raw = _folded(raw)
    low = [word.casefold() for word in raw]
    slash = low[0][0] == "/"
    if slash:
        raw[0] = raw[0].partition("@")[0].lstrip("/") or "/"
        low[0] = low[0].partition("@")[0].lstrip("/") or "/"
    return LineWords(raw, low, slash)


def past_fillers(low: list[str], at: int) -> int:
    """Return where the next word stands that carries a meaning; the end, if none does."""
    while at < len(low) and low[at] in FILLERS:
        at += 1
    return at


def past_excepting(low: list[str], at: int) -> int:
    """Return where what leaves robots out ends that begins here; 0: nothing does."""
    for end in (at + 2, at + 1):
        if end <= len(low) and tuple(low[at:end]) in EXCEPTING:
            return end
    return 0


def leaves_out(text: str) -> bool:
    """Whether a text, which stops or ends everything, was perhaps to leave somebody out."""
    if len(text) > FOLDED_AT_MOST:
        return False
    low = clean(" ".join(text.split())).casefold().split()
    return any(past_excepting(low, at) and low[at] not in NEGATING for at in range(1, len(low)))


def _folded(raw: list[str]) -> list[str]:
    """Fold words as far as anything but free text can go: names, numbers and units stand there."""
    room, folded = FOLDED_AT_MOST, []
    for word in raw:
        room -= len(word)
        if room < 0:
            break
        folded.append(fold_word(word))
    return folded + raw[len(folded) :]
