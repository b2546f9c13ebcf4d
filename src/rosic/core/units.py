"""Quantities as they are read: in the units of the profile, or in feet, pounds and Fahrenheit."""

from __future__ import annotations

import re
from math import ceil, floor, log10
from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.i18n import ImperialCatalogue, figure, joined, said

if TYPE_CHECKING:
    from rosic.core.i18n import Catalogue
    from rosic.core.language.numbers import Unit  # it reads quantities, and so comes later

# The unit as it is shown, to what it is read in: imperial = value * factor + offset.
_IMPERIAL = {
    "mm": ("in", 1 / 25.4, 0.0),
    "cm": ("in", 1 / 2.54, 0.0),
    "dm": ("in", 1 / 0.254, 0.0),
    "m": ("ft", 1 / 0.3048, 0.0),
    "km": ("mi", 1 / 1.609344, 0.0),
    "mm/s": ("in/s", 1 / 25.4, 0.0),
    "cm/s": ("in/s", 1 / 2.54, 0.0),
    "m/s": ("ft/s", 1 / 0.3048, 0.0),
    "km/h": ("mph", 1 / 1.609344, 0.0),
    "kg": ("lb", 1 / 0.45359237, 0.0),
    "°C": ("°F", 1.8, 32.0),
}

_WORDS = {"deg": said("deg"), "deg/s": said("deg/s")}
"""Units that are written as a word, and so as another one in other languages."""

_DIGITS, _SLIP = 3, 1e-9
_QUANTITY = re.compile(
    r"(?<![\w.,])(-?[0-9]{1,12}(?:\.[0-9]{1,12})?) "
    r"(mm/s|cm/s|km/h|m/s|mm|cm|dm|km|kg|m|°C)(?![\w/])"
)


def shown_unit(symbol: str) -> str:
    """Return a unit as it is written in the reader's language."""
    return _WORDS.get(symbol) or symbol


def measured(text: str, value: float, symbol: str) -> str:
    """Return a quantity that is shown in other units to whoever reads those.

    Args:
        text: How it reads as it is: ``0.50 m``.
        value: In that unit.
        symbol: Of that unit.
    """
    other = _IMPERIAL.get(symbol)
    if other is None:
        if symbol not in _WORDS:
            return figure(text)
        return joined("", (figure(text.removesuffix(symbol)), _WORDS[symbol]))
    name, factor, offset = other
    return figure(text, f"{round(value * factor + offset, 2):g} {name}")


def number_in_units(value: float, symbol: str) -> str:
    """Return a number with two decimals in the reader's units; its unit is said elsewhere."""
    _, factor, offset = _IMPERIAL.get(symbol, ("", 1.0, 0.0))
    return figure(f"{value:.2f}", f"{value * factor + offset:.2f}")


def bound_in_words(value: float, symbol: str, *, upper: bool, with_unit: bool = True) -> str:
    """Return one of two bounds as it is read; in other units it is rounded inwards.

    Args:
        value: In the unit of the profile.
        symbol: Of that unit.
        upper: Whether it is the upper of the two.
        with_unit: Whether the unit stands behind it.
    """
    number = f"{value:g}"
    shown = joined(" ", filter(None, (figure(number), shown_unit(symbol) if with_unit else "")))
    other = _IMPERIAL.get(symbol)
    if other is None:
        return shown
    name, factor, offset = other
    there = value * factor + offset
    step = 10.0 ** (floor(log10(abs(there))) + 1 - _DIGITS) if there else 1.0
    inward = (floor if upper else ceil)(there / step + (_SLIP if upper else -_SLIP)) * step
    imperial = f"{inward:.{_DIGITS}g}"
    unit = f" {name}" if with_unit else ""
    return figure(f"{number} {symbol}" if with_unit else number, f"{imperial}{unit}")


def in_units_of(text: str, catalogue: Catalogue | None) -> str:
    """Return what a robot said, with its quantities as whoever reads this catalogue reads them.

    A robot's own words are no sentence of ours: its quantities are found where they stand.
    """
    if not isinstance(catalogue, ImperialCatalogue):
        return text
    return _QUANTITY.sub(_converted, text)


def _converted(found: re.Match[str]) -> str:
    name, factor, offset = _IMPERIAL[found[2]]
    value = float(found[1]) * factor + offset
    decimals = 2 if abs(value) < 10 else 1  # noqa: PLR2004 - as many digits as a robot gives
    return f"{round(value, decimals):g} {name}"


def imperial_unit(unit: Unit) -> Unit | None:
    """Return what a unit is read in instead; None if it stays."""
    other = _IMPERIAL.get(unit.symbol)
    if other is None:
        return None
    name, factor, offset = other
    per = unit.factor / factor
    return replace(unit, symbol=name, factor=per, offset=unit.offset - offset * per)
