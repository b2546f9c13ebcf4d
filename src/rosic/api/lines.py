"""What callers send as parts of a line: a part that began another line would be another command."""

from __future__ import annotations

from typing import Final

from rosic.core.i18n import said
from rosic.errors import NotUnderstood

ONE_LINE: Final = said("That has to be words of one line. Nothing was done.")
ONE_WORD: Final = said("That has to be one word. Nothing was done.")


def one_line(text: str) -> str:
    """Return a text as a part of a line.

    Raises:
        NotUnderstood: It is none, or not of one line.
    """
    if not text.strip() or not text.isprintable():
        raise NotUnderstood(ONE_LINE)
    return " ".join(text.split())


def one_word(text: str) -> str:
    """Return a text as one word of a line.

    Raises:
        NotUnderstood: It is none.
    """
    if one_line(text) != text or " " in text:
        raise NotUnderstood(ONE_WORD)
    return text
