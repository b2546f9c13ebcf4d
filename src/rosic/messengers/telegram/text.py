"""Texts in the sizes that Telegram takes, counted as Telegram counts: in UTF-16 code units."""

from __future__ import annotations

import unicodedata

MESSAGE_UNITS = 4_096
CAPTION_UNITS = 1_024
ANSWER_UNITS = 200
LABEL_UNITS = 64

_JOINS = frozenset({"\u200d", "\ufe0e", "\ufe0f"})
_SEAMS = ("\n\n", "\n", ". ", " ")


def clean(text: str) -> str:
    """Return the text with halves of characters replaced, which no connection can carry."""
    return text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")


def units(text: str) -> int:
    """Return its length in UTF-16 code units."""
    return len(text) if text.isascii() else len(text.encode("utf-16-le", "surrogatepass")) // 2


def shorten(text: str, limit: int) -> str:
    """Return as much of it as fits; for labels, which have no second part."""
    text = clean(text)
    return text if units(text) <= limit else text[: _fit(text, limit - 1)] + "…"


def split(text: str, limit: int = MESSAGE_UNITS) -> list[str]:
    """Cut a text into parts of at most ``limit`` units, at a paragraph, a line, a word if it can.

    Nothing is lost but white space at the seams, which Telegram takes away from the ends of a
    message anyway.
    """
    rest, parts = clean(text), []
    while units(rest) > limit:
        end = _seam(rest, _fit(rest, limit))
        parts.append(rest[:end].rstrip())
        rest = rest[end:].lstrip()
    parts.append(rest)
    return [part for part in parts if part] or [""]


def _fit(text: str, limit: int) -> int:
    """Return how many characters fit into so many units, without taking a character apart."""
    taken = 0
    for index, character in enumerate(text):
        taken += 2 if character > "\uffff" else 1
        if taken > limit:
            return _whole(text, index)
    return len(text)


def _whole(text: str, end: int) -> int:
    """Move a cut forwards, out of a character that is made of several."""
    for back in range(32):
        at = end - back
        if at <= 1:
            break
        joined = text[at] in _JOINS or text[at - 1] == "\u200d" or unicodedata.combining(text[at])
        if not joined:
            return at
    return end


def _seam(text: str, end: int) -> int:
    """Return the best place to cut in the second half of what fits."""
    for seam in _SEAMS:
        at = text.rfind(seam, end // 2, end + 1)
        if at > 0 and text[:at].strip():
            return min(at + len(seam), end)
    return end
