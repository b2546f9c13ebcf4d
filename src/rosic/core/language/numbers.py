"""Units as factors. Whoever starts ROSIC compiles them; this module only looks them up."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING
from unicodedata import category, numeric

import msgspec

from rosic.core.language.suggestions import distance

if TYPE_CHECKING:
    from collections.abc import Container


# ---- units as factors ----
# Whoever starts ROSIC compiles them; here they are only looked up.

# Shorter ones are symbols, and one letter makes another unit of a symbol.
_SHORTEST_NAME = 5
_PREFIX = re.compile(
    "atto|centi|deca|deci|deka|demi|dezi|exa|femto|giga|hecto|hekto|kilo|mega|micro|mikro|milli"
    "|nano|peta|pico|piko|semi|sesqui|tera|zenti"
)


class Unit(msgspec.Struct, frozen=True):
    """How a spelled unit becomes SI: ``value * factor + offset``.

    Attributes:
        symbol: How it is shown.
        dimension: What it measures, in a word a person may read: ``length``, ``turning speed``.
        factor: Greater than 0.
        offset: 0 but for temperatures.
    """

    symbol: str
    dimension: str
    factor: float
    offset: float = 0.0

    def to_si(self, value: float) -> float:
        """Return a value of this unit in SI."""
        return value * self.factor + self.offset

    def from_si(self, value: float) -> float:
        """Return a value in SI in this unit."""
        return (value - self.offset) / self.factor


# A plain number: a count, the index of a joint.
NONE = Unit("", "", 1.0)


class UnitTable(msgspec.Struct, frozen=True):
    """Every spelling of every unit.

    Attributes:
        exact: Spelling, in the right case, to unit.
        forgiving: Lower-case spelling to unit, where the case decides nothing: ``CM`` is cm, but
            ``Mm`` is not mm.
    """

    exact: dict[str, Unit]
    forgiving: dict[str, Unit]

    def find(self, spelled: str) -> Unit | None:
        """Return the unit of a spelling, or None."""
        return self.exact.get(spelled) or self.forgiving.get(spelled.casefold())

    def misspelt(self, word: str, dimensions: Container[str]) -> tuple[str, ...]:
        """Return the name that a word is, but for one slip of a finger; empty for none.

        Never another unit, as that would be another quantity: of symbols nothing is made, nor of
        what may be two units, nor of a unit that is not known: a decametre is no decimetre, and a
        gradian is no radian. Looks at all names of these dimensions.
        """
        word = word.casefold()
        found = {
            name: unit
            for name, unit in self.exact.items()
            if unit.dimension in dimensions and _misspelt(word, name.casefold())
        }
        return tuple(found)[:1] if len(set(found.values())) == 1 else ()


def _misspelt(word: str, name: str) -> bool:
    """Whether a word is a name of a unit, but for one slip of a finger inside it.

    Not where the slip made another prefix, beginning or end, or put a letter before or behind the
    name: these are other units (decametre, gradian, kilograd, mmeter, degreeC).
    """
    if min(len(word), len(name)) < _SHORTEST_NAME or not name.isalpha() or name in word:
        return False
    found = _PREFIX.match(word)
    prefix = found[0] if found is not None else ""
    word, other = word.removeprefix(prefix), name.removeprefix(prefix)
    if (word[:1], word[-1:]) != (other[:1], other[-1:]) or len(other) + len(prefix) != len(name):
        return False
    return distance(word, other, 1) <= 1


# ---- numbers as people type them ----

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
