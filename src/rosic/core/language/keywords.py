"""The words that belong to the language itself, so that no robot and no skill may have them."""

from __future__ import annotations

import re
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from rosic.core.language.common_names import typed_names

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping


# ---- option words ----

# What stands between the values of a command for ROSIC, in other languages.
#
# Each means the English word that is read. None is reserved: where somebody or something here is
# called so, that is meant.

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


# ---- keywords ----

# What help has a page of.
HELP_PAGES = frozenset({"alarms", "fleet", "move", "see", "share"})

# The pages in other languages. None of them is reserved.
PAGE_ALIASES: dict[str, str] = {
    "alarme": "alarms",
    "bewegen": "move",
    "flotte": "fleet",
    "sehen": "see",
    "teilen": "share",
}

# What people say instead, and what is offered to them.
HINTS: dict[str, str] = {
    "?": "help",
    "commands": "help",
    "go-on": "resume",
    "list": "robots",
    "select": "use",
    "state": "status",
    "unstop": "resume",
}

# What is asked of a robot that its status says, where no skill is called so. None is reserved.
STATUS_WORDS = frozenset({"battery", "where"} | {"akku", "batterie", "wo"})
IS_WORDS = frozenset({"are", "is"} | {"ist", "sind"})

# Words that carry no meaning here. A phrase may contain them ("go to"), a name may not be one.
FILLERS = frozenset({"a", "an", "and", "at", "by", "for", "of", "please", "the", "to", "with", "&"})

# A line that begins with one may be no order: ``the launch``.
ARTICLES = frozenset({"a", "an", "the"})

# Likewise in other languages, among the values of a command. They are not reserved: where a choice
# is called so, that is meant.
SOFT_FILLERS = frozenset({"bitte", "mit", "nach", "um", "und"})

# A bare number behind one may be a time of day: ``grasp at 8``.
BEFORE_TIMES = frozenset({"at", "um"})

# Before a choice one may begin something else to do: ``move 1 m and back``.
AND_ALSO = frozenset({"and", "und"})

# Before a name, where nothing is called so: ``bild von omni``, ``hilfe zu omni``.
BEFORE_NAMES = frozenset({"den", "der", "für", "vom", "von", "zu", "zum", "zur"})

# Said before or behind a name, where nothing is called so.
POLITE = frozenset({"bitte"})

EVERYTHING = frozenset({"all", "everybody", "everyone", "everything"})
# Likewise elsewhere, where no robot is called so; and what goes along: ``weitermachen lassen``.
EVERYTHING_ELSEWHERE = frozenset({"alle", "alles"})
ALONG_ELSEWHERE = frozenset(
    {"again", "jetzt", "now", "robots", "roboter"} | {"bitte", "lassen", "und", "wieder"}
)
# What leaves out of those named before it whoever is named behind it, where no robot is called so.
EXCEPTING: frozenset[tuple[str, ...]] = frozenset(
    {("but",), ("except",), ("excepting",), ("excluding",), ("minus",), ("not",), ("without",)}
    | {("apart", "from"), ("other", "than"), ("but", "not")}
    | {("ausser",), ("nicht",), ("ohne",), ("aber", "nicht"), ("bis", "auf"), ("nur", "nicht")}
)
NOTHING = frozenset({"nobody", "none", "nothing"})

NUMBERS: dict[str, float] = {
    "half": 0.5,
    "one": 1.0,
    "two": 2.0,
    "three": 3.0,
    "four": 4.0,
    "five": 5.0,
    "six": 6.0,
    "seven": 7.0,
    "eight": 8.0,
    "nine": 9.0,
    "ten": 10.0,
}

# Said, they are numbers, so that the answer can be that they are not finite.
NOT_FINITE: dict[str, float] = {
    sign + word: float(sign + "inf") if word != "nan" else float("nan")
    for sign in ("", "+", "-")
    for word in ("inf", "infinity", "infinite", "∞", "nan")
}
