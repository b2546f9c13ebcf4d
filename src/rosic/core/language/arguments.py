"""From what was said to arguments in SI: completed, converted, bounded. Never clamped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.language.ast import Misunderstood
from rosic.core.language.skill_values import free_number, place_value
from rosic.core.language.value_errors import ValueErrorBuilder
from rosic.core.units import imperial_unit
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from rosic.core.language.ast import Do
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.order import SpokenValue
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument, Skill


def bind(
    vocabulary: Vocabulary,
    robot: RobotId,
    skill: Skill,
    spoken: tuple[SpokenValue, ...],
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
            raise ValueErrorBuilder(vocabulary, robot, compiled, spoken, group or robot).missing(
                parameter
            )
        arguments[parameter.name] = chosen
    return arguments


def place(
    vocabulary: Vocabulary,
    robot: RobotId,
    skill: Skill,
    spoken: tuple[SpokenValue, ...],
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
        placed = place_value(compiled, given, value, vocabulary.units)
        if placed is None:
            at = len(given)
            raise ValueErrorBuilder(vocabulary, robot, compiled, spoken, group or robot).to(
                at, given
            )
        parameter, argument = placed
        given[parameter.name] = argument
    return compiled, given


def unit_needed(vocabulary: Vocabulary, line: Do) -> Misunderstood | None:
    """Return what to ask somebody who reads feet of a number without a unit; None: nothing.

    A question that is asked in feet is not answered in metres. A number that is read alike in both
    is none of these.
    """
    compiled = vocabulary.compiled_skill(line.robots[0], line.skills[0].id)
    if compiled is None:
        return None
    given: dict[str, Argument] = {}
    declared: list[str] = []
    read: list[str] = []
    first: SpokenValue | None = None
    for value in line.spoken:
        parameter = _parameter_of(vocabulary, compiled, given, value)
        bare = value.number is not None and not value.word
        other = imperial_unit(parameter.unit) if bare and parameter is not None else None
        if parameter is not None:
            given[parameter.name] = 0.0
        if parameter is None or other is None or vocabulary.units.find(other.symbol) is None:
            declared.append(_as_said(value, value.word))
            read.append(declared[-1])
            continue
        first = first or value
        declared.append(_as_said(value, parameter.unit.symbol))
        read.append(_as_said(value, other.symbol))
    if first is None:
        return None
    start = f"{line.group or line.robots[0]} {compiled.spoken}"
    offers = tuple(" ".join((start, *values)) for values in (read, declared))
    return Misunderstood(
        said(
            "Say the unit of {number}: you chose to read feet, and the robot reads metres. "
            "Nothing was done.",
            number=f"{first.number:.10g}",
        ),
        offers,
    )


def _parameter_of(
    vocabulary: Vocabulary, compiled: CompiledSkill, given: dict[str, Argument], value: SpokenValue
) -> CompiledParameter | None:
    """Return where a value goes, whatever its bounds."""
    if value.number is None:
        placed = place_value(compiled, given, value, vocabulary.units)
        return None if placed is None else placed[0]
    if value.name:
        return compiled.by_name.get(value.name)
    unit = vocabulary.units.find(value.word) if value.word else None
    return free_number(compiled, given, unit)


def _as_said(value: SpokenValue, word: str) -> str:
    said_so = word if value.number is None else f"{value.number:.10g} {word}".rstrip()
    return f"{value.name}={said_so}" if value.name else said_so
