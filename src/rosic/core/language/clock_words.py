"""Single words of a time: a line in words, and what the hands of a clock show."""

from __future__ import annotations

import re

from rosic.core.i18n import said
from rosic.core.language.sanitise import clean, fold_word, quote
from rosic.core.local_time import MINUTES_A_DAY

LONGEST_TEXT = 200

_CLOCK = re.compile(r"(\d{1,2})(?::(\d{2}))?(am|pm|a\.m\.|p\.m\.)?\Z", re.ASCII)


class Unclear(Exception):
    """The words say no time. ``str()`` is the sentence, ``offers`` what would be understood."""

    def __init__(self, sentence: str, *offers: str) -> None:
        super().__init__(sentence)
        self.sentence = sentence
        self.offers = offers


def words_of(text: str) -> list[str]:
    """Split into folded lower-case words; a comma is a word of its own."""
    if len(text) > LONGEST_TEXT:
        raise Unclear(
            said(
                "That is longer than any time: I read at most {longest_text} characters.",
                longest_text=LONGEST_TEXT,
            )
        )
    folded = (fold_word(word).casefold() for word in clean(text).split())
    words: list[str] = []
    for word in folded:
        words.extend(_at_commas(word))
    return words


def _at_commas(word: str) -> list[str]:
    """``tue,thu`` is three words; ``1,5h`` and a rule are one."""
    if "," not in word or "=" in word or (word[0].isdigit() and word[-1] != ","):
        return [word]
    return word.replace(",", " , ").split()


def clock_of(word: str, after: str) -> tuple[int, str, int] | None:
    """Read a time of day: minutes since midnight, am or pm if said, how many words."""
    if word in {"noon", "midday"}:
        return MINUTES_A_DAY // 2, "pm", 1
    match = _CLOCK.match(word)
    if match is None:
        return None
    apart = not match[3] and after in {"am", "pm", "a.m.", "p.m."}
    half = (after if apart else match[3] or "").replace(".", "")
    hour, minute = int(match[1]), int(match[2] or 0)
    if half:
        if not 1 <= hour <= 12:  # noqa: PLR2004
            raise _no_such(f"{word} {after}" if apart else word)
        hour = hour % 12 + 12 * (half == "pm")
    if (hour, minute) == (24, 0):
        return MINUTES_A_DAY, half, 1 + apart
    if hour > 23 or minute > 59:  # noqa: PLR2004
        raise _no_such(word)
    return hour * 60 + minute, half, 1 + apart


def _no_such(word: str) -> Unclear:
    return Unclear(said("There is no {quote} on a clock.", quote=quote(word)))
