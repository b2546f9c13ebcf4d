"""One value at its place in a skill, in SI; and whether values have a place at all."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from rosic.core.language.ast import Do, Line, Misunderstood
from rosic.core.language.compiled import TOLERANCE, CompiledParameter, CompiledSkill
from rosic.core.language.sanitise import clean

if TYPE_CHECKING:
    from rosic.core.language.numbers import Unit, UnitTable
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.order import SpokenValue
    from rosic.core.robot.skill import Argument


def fits(compiled: CompiledSkill, spoken: tuple[SpokenValue, ...], units: UnitTable) -> bool:
    """Return whether every value has a place, so that a line may be offered to somebody.

    A number beyond its bounds has one: the answer to it names the bound. Values may be missing.
    """
    given: dict[str, Argument] = {}
    for value in spoken:
        placed = place_value(compiled, given, value, units) or _beyond(
            compiled, given, value, units
        )
        if placed is None:
            return False
        parameter, argument = placed
        given[parameter.name] = argument
    return True


def is_understood(line: Line, vocabulary: Vocabulary) -> bool:
    """Return whether a line is surely a command: read to its end, each value at a place.

    What means nothing is no command because a robot that one talks to is chosen. Of what a group
    is asked, its first robot is looked at, so that it costs as much as one.
    """
    if not isinstance(line, Do):
        return not isinstance(line, Misunderstood)
    if line.speech:
        return line.named
    compiled = vocabulary.compiled_skill(line.robots[0], line.skills[0].id)
    return compiled is not None and fits(compiled, line.spoken, vocabulary.units)


def _beyond(
    compiled: CompiledSkill, given: dict[str, Argument], value: SpokenValue, units: UnitTable
) -> tuple[CompiledParameter, Argument] | None:
    """Return the place of a number that is outside its bounds; None for what has none."""
    unit = units.find(value.word) if value.word else None
    if value.number is None or (value.word and unit is None):
        return None
    parameter = (
        compiled.by_name.get(value.name) if value.name else free_number(compiled, given, unit)
    )
    if parameter is None or not parameter.is_number or parameter.name in given:
        return None
    unit = unit or parameter.unit
    si = unit.to_si(value.number)
    if unit.dimension != parameter.unit.dimension or not isfinite(si):
        return None
    return (parameter, si) if not parameter.low_edge <= si <= parameter.high_edge else None


def place_value(
    compiled: CompiledSkill, given: dict[str, Argument], value: SpokenValue, units: UnitTable
) -> tuple[CompiledParameter, Argument] | None:
    """Return where a value goes and what it is there; None when something is wrong with it.

    Args:
        compiled: Of which skill.
        given: What the values before it gave.
        value: As it was read.
        units: Those that are known.
    """
    if value.number is None:
        return _place_word(compiled, given, value)
    unit: Unit | None = None
    if value.word:
        unit = units.exact.get(value.word) or units.find(value.word)
        if unit is None:
            return None
    if value.name:
        parameter = compiled.by_name.get(value.name)
        if parameter is None or parameter.name in given:
            return None
    else:
        parameter = free_number(compiled, given, unit)
        if parameter is None:
            return None
    argument = _number(parameter, value.number, unit)
    return (parameter, argument) if argument is not None else None


def free_number(
    compiled: CompiledSkill, given: dict[str, Argument], unit: Unit | None
) -> CompiledParameter | None:
    """Return the first number that has no value yet, of a unit's dimension if there is one."""
    for parameter in compiled.numbers:
        if parameter.name not in given and (
            unit is None or parameter.unit.dimension == unit.dimension
        ):
            return parameter
    return None


def _place_word(
    compiled: CompiledSkill, given: dict[str, Argument], value: SpokenValue
) -> tuple[CompiledParameter, Argument] | None:
    word = value.word
    if not value.name:
        for parameter in compiled.choices:
            if parameter.name not in given and parameter.words and word in parameter.words:
                return parameter, parameter.words[word]
        return None
    named = compiled.by_name.get(value.name)
    if named is None or named.name in given:
        return None
    if named.text:
        text = clean(word).strip()
        return (named, text) if text else None
    choice = (named.words or {}).get(word)
    return (named, choice) if choice is not None else None


def _number(parameter: CompiledParameter, number: float, unit: Unit | None) -> Argument | None:
    """Return a number in SI within its bounds; None for anything else, NaN included."""
    declared = parameter.unit
    if unit is None:
        unit = declared
    elif unit.dimension != declared.dimension:
        return None
    si = unit.to_si(number)
    if not (parameter.is_number and parameter.low_edge <= si <= parameter.high_edge):
        return None
    if si < parameter.low:
        si = parameter.low
    elif si > parameter.high:
        si = parameter.high
    return _whole(si, declared) if parameter.integer else si


def _whole(si: float, unit: Unit) -> Argument | None:
    """Return a value that is whole in the declared unit; an ``int`` where that unit is SI."""
    value = unit.from_si(si)
    nearest = round(value)
    if abs(value - nearest) > TOLERANCE * max(1.0, abs(value)):
        return None
    return nearest if unit.factor == 1.0 and unit.offset == 0.0 else si
