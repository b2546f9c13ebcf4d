"""What is left open in a mission: named, bounded numbers, said when it is started.

A step says ``move $distance``; the number takes that place as people would type it, with its unit.
So a step that was filled is understood, bounded and permitted like any other.
"""

from __future__ import annotations

import re
from math import isfinite
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.i18n import said
from rosic.core.language.numbers import NONE, read_numeral
from rosic.errors import NotUnderstood, OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.core.language.numbers import Unit, UnitTable

NAME: Final = re.compile(r"\$([a-z][a-z0-9_]*)")
QUANTITIES_AT_MOST: Final = 16
TOLERANCE: Final = 1e-9
_SHOWN_DIGITS: Final = 9


class Quantity(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One number that is said when a mission is started.

    Attributes:
        title: As people read it; empty for its name.
        unit: How people give it when they name no unit, and how it is shown; empty for a plain
            number.
        min, max: Bounds in this unit, inclusive.
        default: In this unit; without one it has to be said.
    """

    min: float
    max: float
    unit: str = ""
    default: float | None = None
    title: str = ""


class TemplateValues(NamedTuple):
    """What was said of a mission.

    Attributes:
        given: Name to number, in the unit of its quantity.
        rest: What follows, as it was typed.
    """

    given: dict[str, float]
    rest: str


def shown(quantity: Quantity, value: float) -> str:
    """Return a value as people type it: ``2.5 m``."""
    number = f"{value:.{_SHOWN_DIGITS}f}".rstrip("0").rstrip(".")
    return f"{number} {quantity.unit}" if quantity.unit else number


def names_in(step: str) -> Iterator[str]:
    """Yield the names of what a step leaves open."""
    return (found.group(1) for found in NAME.finditer(step))


def filled(step: str, texts: Mapping[str, str]) -> str:
    """Return a step with everything in its place; what has no value stays as it is."""
    return NAME.sub(lambda found: texts.get(found.group(1), found.group(0)), step)


def read_values(text: str, quantities: Mapping[str, Quantity], units: UnitTable) -> TemplateValues:
    """Read ``distance=2 m speed 0.3 m/s`` off the beginning of a line.

    Raises:
        NotUnderstood: A value is no number of the right kind, or is said twice.
        OutOfBounds: It is outside its bounds.
    """
    words = text.replace("=", " = ").split()
    given: dict[str, float] = {}
    at = 0
    while at < len(words):
        name = words[at].casefold()
        named = at + 1 < len(words) and words[at + 1] == "="
        if name not in quantities:
            if named:
                raise NotUnderstood(no_such(name, quantities))
            break
        if name in given:
            raise NotUnderstood(said("{name} is said twice. Nothing was done.", name=name))
        at += 2 if named else 1
        given[name], used = _value(name, quantities[name], words[at : at + 3], units)
        at += used
    return TemplateValues(given, " ".join(words[at:]))


def no_such(name: str, quantities: Mapping[str, Quantity]) -> str:
    """Return that a name means nothing that is left open."""
    if not quantities:
        return said("Nothing is left open there, so there is no {name}.", name=name)
    return said(
        "There is no {name} to be said. There is: {names}.", name=name, names=", ".join(quantities)
    )


def read_value(name: str, quantity: Quantity, text: str, units: UnitTable) -> float:
    """Return one value in the unit of its quantity.

    Raises:
        NotUnderstood, OutOfBounds: As of `read_values`.
    """
    words = text.split()
    value, used = _value(name, quantity, words[:2], units)
    if used != len(words):
        raise NotUnderstood(_no_value(name, quantity))
    return value


def texts_of(quantities: Mapping[str, Quantity], given: Mapping[str, float]) -> dict[str, str]:
    """Return every quantity as it stands in a step: what was said, or else its default.

    Raises:
        NotUnderstood: One has neither.
    """
    texts = {}
    for name, quantity in quantities.items():
        value = given.get(name, quantity.default)
        if value is None:
            raise NotUnderstood(_no_value(name, quantity))
        texts[name] = shown(quantity, value)
    return texts


def bounds(name: str, quantity: Quantity) -> str:
    """Return what may be said for a quantity: ``distance 0.1 to 5 m, 1 m if nothing is said``."""
    least, most = shown(quantity, quantity.min), shown(quantity, quantity.max)
    if quantity.default is None:
        return said("{name}: {least} to {most}", name=name, least=least, most=most)
    return said(
        "{name}: {least} to {most}, {default} if nothing is said",
        name=name,
        least=least,
        most=most,
        default=shown(quantity, quantity.default),
    )


def _value(name: str, quantity: Quantity, words: list[str], units: UnitTable) -> tuple[float, int]:
    """Return a value, and how many words say it."""
    numeral = read_numeral(words[0]) if words else None
    if numeral is None or numeral.readings:
        raise NotUnderstood(_no_value(name, quantity))
    spelled, used = numeral.rest, 1
    if not spelled and _is_unit(words[1:], units):
        spelled, used = words[1], 2
    unit, own = units.find(spelled) if spelled else None, _unit(quantity, units)
    if spelled and (unit is None or unit.dimension != own.dimension):
        raise NotUnderstood(_no_value(name, quantity))
    value = numeral.value if unit is None else own.from_si(unit.to_si(numeral.value))
    return _bounded(name, quantity, value), used


def _is_unit(words: list[str], units: UnitTable) -> bool:
    """Whether a unit follows a number; in ``2 in 5 min`` it is when, and no inches."""
    when = len(words) > 1 and words[0] == "in" and read_numeral(words[1]) is not None
    return bool(words) and not when and units.find(words[0]) is not None


def _unit(quantity: Quantity, units: UnitTable) -> Unit:
    return (units.find(quantity.unit) if quantity.unit else None) or NONE


def _bounded(name: str, quantity: Quantity, value: float) -> float:
    edge = TOLERANCE * max(1.0, abs(quantity.min), abs(quantity.max))
    if not isfinite(value) or not quantity.min - edge <= value <= quantity.max + edge:
        raise OutOfBounds(
            said(
                "{name} goes from {least} to {most}. Nothing was done.",
                name=name,
                least=shown(quantity, quantity.min),
                most=shown(quantity, quantity.max),
            )
        )
    return min(max(value, quantity.min), quantity.max)


def _no_value(name: str, quantity: Quantity) -> str:
    example = quantity.min if quantity.default is None else quantity.default
    return said(
        "Say {name}, for example {name}={example}. Nothing was done.",
        name=name,
        example=shown(quantity, example),
    )
