"""Numbers as people type them: ``0.5``, ``0,5``, ``50cm``, ``1/2``, ``1e1``, ``½``."""

from __future__ import annotations

import re
from unicodedata import category, numeric

import msgspec

FIRST = frozenset("0123456789.+-")

_NUMERAL = re.compile(
    r"(?P<sign>[+-]?)"
    r"(?:(?P<over>\d+)/(?P<under>\d+)|10\^(?P<power>[+-]?\d+)"
    r"|(?P<plain>\d*[.,]?\d+(?:[eE][+-]?\d+)?))"
    r"(?P<rest>.*)\Z",
    re.ASCII | re.DOTALL,
)
# 1,500 may be one and a half or fifteen hundred; 0,500 and 12,5 leave no doubt.
_AMBIGUOUS = re.compile(r"[1-9]\d{0,2},\d{3}\Z", re.ASCII)
# A number is over where a unit begins; what goes on like a number is none that can be read.
_GOES_ON = frozenset("0123456789.,+-/^*:")


class Numeral(msgspec.Struct, frozen=True):
    """A number at the start of a word.

    Attributes:
        value: Perhaps not finite; whoever uses it checks.
        rest: What follows it in the word: ``cm`` of ``50cm``.
        readings: The two numbers it may mean, if it may mean two.
    """

    value: float
    rest: str = ""
    readings: tuple[str, ...] = ()


def read_numeral(word: str) -> Numeral | None:
    """Read the number a word begins with, or return None. Takes time linear in the word."""
    match = _NUMERAL.match(word)
    if match is None:
        return _vulgar_fraction(word)
    rest = match["rest"]
    if rest and (rest[0] in _GOES_ON or rest[0].isnumeric()):
        return None
    sign, plain, power = match["sign"], match["plain"], match["power"]
    if plain is not None:
        if _AMBIGUOUS.match(plain):
            small = plain.replace(",", ".").rstrip("0").rstrip(".")
            readings = (sign + small, sign + plain.replace(",", ""))
            return Numeral(float("nan"), rest, readings)
        return Numeral(float(sign + plain.replace(",", ".")), rest)
    if power is not None:
        return Numeral(float(f"{sign}1e{power}"), rest)
    under = float(match["under"])
    return Numeral(float(sign + match["over"]) / under if under else float("nan"), rest)


def _vulgar_fraction(word: str) -> Numeral | None:
    """Read ½ and its like; nothing that counts (②) or stands above the line (²)."""
    first = word[:1]
    if first and category(first) == "No" and 0 < (value := numeric(first)) < 1:
        return Numeral(value, word[1:])
    return None
