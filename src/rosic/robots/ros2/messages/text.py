"""Words from a chat, made fit for a ROS string."""

from __future__ import annotations

import unicodedata

MAX_TEXT_BYTES = 4096

_REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
# Marks that turn the reading direction: invisible, and able to make one text look like another.
_BIDI = frozenset("\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")


def clean_text(text: str, *, max_bytes: int = MAX_TEXT_BYTES) -> str:
    """Return ``text`` as a robot may receive it, at most ``max_bytes`` long in UTF-8.

    A lone surrogate, which rclpy cannot encode, becomes U+FFFD; control characters become spaces,
    except the newline; marks that turn the reading direction go. A cut falls between characters.
    """
    kept = "".join(map(_clean_character, text[:max_bytes]))
    return kept.encode("utf-8")[:max_bytes].decode("utf-8", "ignore")


def _clean_character(character: str) -> str:
    if character.isprintable() or character == "\n":
        return character
    if character in _BIDI:
        return ""
    category = unicodedata.category(character)
    if category == "Cs":
        return _REPLACEMENT
    return " " if category in {"Cc", "Zl", "Zp"} else character
