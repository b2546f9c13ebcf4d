"""From what was said to arguments in SI: completed, converted, bounded. Never clamped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.language.skill_values import place_value
from rosic.core.language.value_errors import ValueErrorBuilder
from rosic.errors import NotUnderstood

if TYPE_CHECKING:
    from rosic.core.language.compiled import CompiledSkill
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
