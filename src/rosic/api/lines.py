"""What callers send as parts of a message: a part that began another line is another command."""

from __future__ import annotations

import re
from hashlib import blake2b
from typing import Final

from rosic.core.i18n import said
from rosic.errors import NotUnderstood

ONE_LINE: Final = said("That has to be words of one line. Nothing was done.")
ONE_WORD: Final = said("That has to be one word. Nothing was done.")
KEY_FORM: Final = re.compile(r"[!-~]{1,128}\Z")
BAD_KEY: Final = said("Idempotency-Key is 1 to 128 letters, digits and signs, without a space.")


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


def message_of_key(key: str) -> str:
    """Return the id of the message that a caller knows by a key; empty for a new one.

    Raises:
        NotUnderstood: It is no key.
    """
    if not key:
        return ""
    if not KEY_FORM.match(key):
        raise NotUnderstood(BAD_KEY)
    return f"key-{blake2b(key.encode(), digest_size=16).hexdigest()}"
