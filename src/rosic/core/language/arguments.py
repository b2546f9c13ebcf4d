"""From what was said to arguments in SI: completed, converted, bounded. Never clamped."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from rosic.core.i18n import joined, said
from rosic.core.language.ast import Misunderstood
from rosic.core.language.common_names import shown_name
from rosic.core.language.numbers import read_numeral
from rosic.core.language.sanitise import quote
from rosic.core.language.skill_values import free_number, place_value
from rosic.core.language.value_errors import ValueErrorBuilder
from rosic.core.units import bound_in_words, imperial_unit, measured
from rosic.errors import NotUnderstood, OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.ast import Do
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.language.numbers import UnitTable
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.order import SpokenValue
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument, Parameter, Skill, Strategy


# ---- strategy arguments ----

# What is said of a strategy, checked against what the robot's profile declares.

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


# ---- arguments ----


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
