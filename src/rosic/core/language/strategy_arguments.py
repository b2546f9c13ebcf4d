"""What is said of a strategy, checked against what the robot's profile declares."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from rosic.core.i18n import joined, said
from rosic.core.language.common_names import shown_name
from rosic.core.language.numbers import read_numeral
from rosic.core.language.sanitise import quote
from rosic.core.units import bound_in_words, measured
from rosic.errors import NotUnderstood, OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.numbers import UnitTable
    from rosic.core.robot.skill import Parameter
    from rosic.core.robot.strategy import Strategy

Values: TypeAlias = dict[str, float | str]


def checked(strategy: Strategy, given: Mapping[str, float | str], units: UnitTable) -> Values:
    """Return every parameter's value in the units of the profile, each within its bounds.

    Args:
        strategy: As declared.
        given: As said; a text may carry a unit: ``20 cm/s``.
        units: What people may say.

    Raises:
        NotUnderstood: A parameter is unknown or missing, or a value is none of its kind.
        OutOfBounds: A number is outside its bounds; the sentence names them.
    """
    for name in given:
        if name not in strategy.parameters:
            known = joined(", ", map(shown_name, strategy.parameters)) or "-"
            raise NotUnderstood(
                said(
                    "There is no parameter {name} there. There are: {known}.",
                    name=quote(name),
                    known=known,
                )
            )
    values: Values = {}
    for name, parameter in strategy.parameters.items():
        value = given.get(name, parameter.default)
        if value is None:
            raise NotUnderstood(said("{name} has to be said, too.", name=shown_name(name)))
        values[name] = _one(name, parameter, value, units)
    return values


def _one(name: str, parameter: Parameter, value: float | str, units: UnitTable) -> float | str:
    if parameter.choices is not None:
        for choice, spellings in parameter.choices.items():
            if str(value).casefold() in {choice, *spellings}:
                return choice
        raise NotUnderstood(
            said(
                "{name} is one of {choices}.",
                name=shown_name(name),
                choices=joined(", ", map(shown_name, parameter.choices)),
            )
        )
    number = float(value) if isinstance(value, float | int) else _number(value, parameter, units)
    low, high = parameter.min, parameter.max
    if number is None or (parameter.integer and not number.is_integer()):
        raise NotUnderstood(
            said(
                "{name}: {value} is no such number.", name=shown_name(name), value=quote(str(value))
            )
        )
    if low is None or high is None or not low <= number <= high:
        raise OutOfBounds(
            said(
                "{name} must be from {low} to {high}.",
                name=shown_name(name),
                low=bound_in_words(low or 0.0, parameter.unit, upper=False, with_unit=False),
                high=bound_in_words(high or 0.0, parameter.unit, upper=True),
            )
        )
    return number


def _number(text: str, parameter: Parameter, units: UnitTable) -> float | None:
    """Read a number in the parameter's unit, or in another of its kind."""
    numeral = read_numeral("".join(text.split()))
    if numeral is None or numeral.readings:
        return None
    if not numeral.rest:
        return numeral.value
    unit, own = units.find(numeral.rest), units.find(parameter.unit)
    if unit is None or own is None or unit.dimension != own.dimension:
        return None
    return own.from_si(unit.to_si(numeral.value))


def spoken(values: Mapping[str, float | str], strategy: Strategy | None) -> str:
    """Return values as people read them."""
    row: list[str] = []
    for name, value in values.items():
        parameter = None if strategy is None else strategy.parameters.get(name)
        unit = parameter.unit if parameter is not None else ""
        if isinstance(value, float | int):
            shown: str = measured(f"{value:g} {unit}".rstrip(), value, unit)
        else:
            shown = shown_name(value)
        row.append(joined(" ", (shown_name(name), shown)))
    return joined(", ", row)
