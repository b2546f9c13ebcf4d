"""From what was said to arguments in SI: completed, converted, bounded. Never clamped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.language.cleaning import clean
from rosic.core.language.compiled import TOLERANCE, CompiledParameter, CompiledSkill
from rosic.core.language.objection import Objection
from rosic.core.saying import said
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from rosic.core.language.units import Unit, UnitTable
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.order import Spoken
    from rosic.core.robot import RobotId
    from rosic.core.skill import Argument, Skill


def bind(
    vocabulary: Vocabulary,
    robot: RobotId,
    skill: Skill,
    spoken: tuple[Spoken, ...],
    *,
    group: str = "",
) -> dict[str, Argument]:
    """Return the arguments of a skill in SI, in the order of the profile, none missing.

    A named value goes where its name says. Others are taken in the order they were said: a number
    with a unit to the first free parameter of that dimension, one without to the first free
    number, in its declared unit, a word to the first free choice that knows it. A value at a bound
    passes, whatever its conversion did to the last digits, and then is the bound.

    Args:
        vocabulary: The snapshot with which the line was understood.
        robot: Whose arguments.
        skill: One of its skills.
        spoken: As `understand` read them.
        group: Who was addressed, if it was a group: for the commands that are offered instead.

    Raises:
        NotUnderstood: A value has no place, a place has no value, or a value is no number.
        OutOfBounds: A number is outside its bounds. The sentence names the bound.
    """
    compiled, given = place(vocabulary, robot, skill, spoken, group=group)
    arguments: dict[str, Argument] = {}
    for parameter in compiled.parameters:
        chosen = given.get(parameter.name, parameter.default)
        if chosen is None:
            raise Objection(vocabulary, robot, compiled, spoken, group or robot).missing(parameter)
        arguments[parameter.name] = chosen
    return arguments


def place(
    vocabulary: Vocabulary,
    robot: RobotId,
    skill: Skill,
    spoken: tuple[Spoken, ...],
    *,
    group: str = "",
) -> tuple[CompiledSkill, dict[str, Argument]]:
    """Return a skill and the arguments that were said, in SI; some may be missing yet.

    Raises:
        NotUnderstood: A value has no place, or is no number.
        OutOfBounds: A number is outside its bounds. The sentence names the bound.
    """
    compiled = vocabulary.compiled_skill(robot, skill.id)
    if compiled is None:
        raise NotUnderstood(said("{robot} has no such skill. Nothing was done.", robot=robot))
    given: dict[str, Argument] = {}
    for value in spoken:
        placed = _place(compiled, given, value, vocabulary.units)
        if placed is None:
            at = len(given)
            raise Objection(vocabulary, robot, compiled, spoken, group or robot).to(at, given)
        parameter, argument = placed
        given[parameter.name] = argument
    return compiled, given


def _place(
    compiled: CompiledSkill, given: dict[str, Argument], value: Spoken, units: UnitTable
) -> tuple[CompiledParameter, Argument] | None:
    """Return where a value goes and what it is there; None when something is wrong with it."""
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
    compiled: CompiledSkill, given: dict[str, Argument], value: Spoken
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
