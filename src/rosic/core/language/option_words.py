"""What stands between the values of a command for ROSIC, in other languages.

Each means the English word that is read. None is reserved: where somebody or something here is
called so, that is meant.
"""

from __future__ import annotations

import re
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from rosic.core.language.common_names import typed_names

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

_DECIMAL: Final = re.compile(r"(?<=\d),(?=\d)")

OPTIONS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "als": "as",
        "aus": "off",
        "bestätigen": "confirm",
        "darf": "may",
        "für": "for",
        "jetzt": "now",
        "mich": "me",
        "mit": "with",
        "sofort": "now",
        "und": "and",
        "von": "from",
        "zurück": "back",
        "überall": "everywhere",
    }
)


def option_typed(word: str) -> str:
    """Return the English word that a word in small letters means; else the word itself."""
    return OPTIONS.get(word, word)


def parameter_typed(word: str, known: Collection[str]) -> str:
    """Return which parameter a word in small letters means; the word where it means none.

    Args:
        word: ``speed``, or what is typed for it elsewhere.
        known: The parameters there are: who has one of that very name means it.
    """
    if word in known:
        return word
    return next((name for name in sorted(known) if word in typed_names(name)), word)


def decimals_typed(text: str) -> str:
    """Return a text with the commas within its numbers as points: ``0,2 m/s``."""
    return _DECIMAL.sub(".", text)
