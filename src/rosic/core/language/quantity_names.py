"""What numbers measure, as people read it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said

if TYPE_CHECKING:
    from rosic.core.language.compiled import CompiledParameter

_DIMENSIONS = {
    "length": said("a length"),
    "angle": said("an angle"),
    "time": said("a time"),
    "speed": said("a speed"),
    "turning speed": said("a turning speed"),
    "acceleration": said("an acceleration"),
    "turning acceleration": said("a turning acceleration"),
    "force": said("a force"),
    "torque": said("a torque"),
    "mass": said("a mass"),
    "share": said("a share"),
    "frequency": said("a frequency"),
    "voltage": said("a voltage"),
    "current": said("a current"),
    "power": said("a power"),
    "energy": said("an energy"),
    "pressure": said("a pressure"),
    "volume": said("a volume"),
    "area": said("an area"),
    "temperature": said("a temperature"),
}


def article(noun: str) -> str:
    """Put the article before a noun."""
    return said("an {noun}", noun=noun) if noun[:1] in "aeiou" else said("a {noun}", noun=noun)


def kind_of(dimension: str) -> str:
    """Return what a unit measures, as a thing: ``a length``."""
    return _DIMENSIONS.get(dimension) or article(dimension)


def kinds(parameters: tuple[CompiledParameter, ...]) -> tuple[str, ...]:
    """Return what numbers measure, each once: ``a length (m)``."""
    kinds = dict.fromkeys(
        said("{dimension} ({symbol})", dimension=kind_of(p.unit.dimension), symbol=p.unit.symbol)
        if p.unit.dimension
        else said("a plain number")
        for p in parameters
    )
    return tuple(kinds)
