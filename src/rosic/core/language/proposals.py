"""Lines of the grammar that may be meant by what is vague, or leaves something out.

A proposal acts only when it is tapped. Its numbers are small, and within the bounds of the profile.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Final

from rosic.core.language.formatting import usual_values
from rosic.core.language.lexicon import SenseKind
from rosic.core.language.phrase_values import PlacedValues, canonical
from rosic.core.language.skill_values import place_value

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator, Mapping, Sequence

    from rosic.core.language.ast import Do
    from rosic.core.language.compiled import CompiledParameter, CompiledSkill, NameTarget
    from rosic.core.language.numbers import UnitTable
    from rosic.core.language.phrase_words import Item
    from rosic.core.robot.skill import Argument

MOST_PROPOSED: Final = 3
STEP_OF_TASK: Final = " then "
SKILLS_LOOKED_AT: Final = 16
_EXTENTS: Final = frozenset({"length", "angle"})
"""Of a way or a turn below zero is the other way; of a flow or a force it is something else."""
_LITTLE: Final = frozenset({"little", "more", "much"})


def reversed_numbers(skill: CompiledSkill, values: PlacedValues) -> PlacedValues:
    """Return values with a negative number as what the skill declares as its reverse.

    ``move -1 m`` is 1 m back, where the profile says what is the reverse of forward.
    """
    reverse = skill.skill.reverse
    if not values.beyond or isinstance(reverse, str):
        return values
    below = [
        p
        for p in skill.numbers
        if p.unit.dimension in _EXTENTS and values.numbers.get(p.name, 0.0) < 0.0 <= p.low
    ]
    turned = [
        (p, choice)
        for p in skill.choices
        for choice in (reverse.get(p.name, {}).get(str(p.default or "")),)
        if choice is not None and p.name not in values.given
    ]
    if len(below) != 1 or len(turned) != 1:
        return values
    (number,), ((parameter, choice),) = below, turned
    si = -values.numbers[number.name]
    text = values.given[number.name].removeprefix("-")
    return values._replace(
        given={**values.given, number.name: text, parameter.name: choice},
        numbers={**values.numbers, number.name: si},
        beyond=not number.low_edge <= si <= number.high_edge,
    )


def open_choices(skill: CompiledSkill, values: PlacedValues) -> tuple[PlacedValues, ...]:
    """Return values with each choice that a word nobody knows may be: none is left to a default.

    Only of the first choice that is left open; the default is the first of them.
    """
    left = [p for p in skill.choices if p.default is not None and p.name not in values.given]
    if not left:
        return ()
    choices = dict.fromkeys((str(left[0].default), *(left[0].words or {}).values()))
    return tuple(
        [values._replace(given={**values.given, left[0].name: choice}) for choice in choices]
    )


def vague_lines(
    name: str, skill: CompiledSkill, values: PlacedValues, items: Sequence[Item]
) -> Iterator[str]:
    """Yield a line, and where a number is missing some with what it may be.

    Args:
        name: Whose.
        skill: The skill.
        values: What was said of it.
        items: The words of the line.
    """
    missing = [p for p in values.missing(skill) if p.is_number]
    vague = {value for item in items for value in item.values(SenseKind.VAGUE)}
    if not missing or vague.isdisjoint(_LITTLE):
        yield canonical(name, skill, values)
    if len(missing) == 1:
        for text in _amounts(missing[0]):
            given = {**values.given, missing[0].name: text}
            yield canonical(name, skill, values._replace(given=given))


def _amounts(parameter: CompiledParameter) -> tuple[str, ...]:
    """Return a few small values of a number."""
    symbol = parameter.unit.symbol
    return tuple([f"{value} {symbol}".rstrip() for value in usual_values(parameter)])


def first_lines(callee: NameTarget, vague: Collection[str]) -> Iterator[str]:
    """Yield what somebody may want of a robot who says only that it is to move."""
    robot = callee.robots[0]
    home = robot.phrases.get("home")
    if home is not None and "place" in vague:
        yield f"{callee.name} {home.spoken}"
    for skill in islice(robot.skills.values(), SKILLS_LOOKED_AT):
        missing = [p for p in skill.parameters if p.default is None]
        directed = [p for p in skill.choices if p.default is not None]
        if not directed or len(missing) != 1 or not missing[0].is_number:
            continue
        amount = _amounts(missing[0])[0]
        for choice in _wanted(directed[0], skill, vague):
            given = {directed[0].name: choice, missing[0].name: amount}
            yield canonical(callee.name, skill, PlacedValues(given, {}, (), False))
        return
    for skill in islice(robot.skills.values(), MOST_PROPOSED):
        yield f"{callee.name} {skill.spoken}"


def _wanted(
    parameter: CompiledParameter, skill: CompiledSkill, vague: Collection[str]
) -> tuple[str, ...]:
    """Return the choices to propose, most likely first."""
    choices = tuple(dict.fromkeys((parameter.words or {}).values()))
    reverse = skill.skill.reverse
    if not isinstance(reverse, str) and not {"undo", "other"}.isdisjoint(vague):
        back = reverse.get(parameter.name, {}).get(str(parameter.default))
        if back is not None:
            return tuple(dict.fromkeys((back, *choices)))
    return choices


# ---- what follows another order ----

_FASTER: Final = 1.5
_SPEEDS: Final = frozenset({"speed", "turning speed"})


def said_before(skill: CompiledSkill, last: Do, units: UnitTable) -> dict[str, str]:
    """Return the values of an order as they are said: in declared units, choices by their name."""
    given: dict[str, Argument] = {}
    said: dict[str, str] = {}
    for value in last.spoken:
        placed = place_value(skill, given, value, units)
        if placed is None:
            continue
        parameter, argument = placed
        given[parameter.name] = argument
        said[parameter.name] = _said(parameter, argument)
    return said


def _said(parameter: CompiledParameter, value: Argument) -> str:
    if not parameter.is_number:
        return str(value)
    unit = parameter.unit
    return f"{unit.from_si(float(value)):.6g} {unit.symbol}".rstrip()


def following_lines(
    callee: NameTarget,
    skill: CompiledSkill,
    given: Mapping[str, str],
    values: PlacedValues,
    vague: Collection[str],
) -> Iterator[str]:
    """Yield what a vague line may mean after an order.

    Args:
        callee: Whose.
        skill: What was ordered.
        given: Its values, as they are said.
        values: What the line itself says of that skill.
        vague: What it says besides: ``again``, ``faster``.
    """
    said = {**given, **values.given}
    if not {"undo", "other"}.isdisjoint(vague) or (vague == {"instead"} and not values.given):
        undone = _reversed(callee, skill, given)
        if undone:
            yield undone
        return
    for p in skill.numbers:
        now = values.numbers.get(p.name)
        if now is not None or (p.name not in given and p.default is None):
            continue
        si = _number(p, given)
        if p.unit.dimension in _SPEEDS and "faster" in vague:
            said[p.name] = _said(p, _rounded(p, si * _FASTER))
        elif p.unit.dimension in _SPEEDS and "slower" in vague:
            said[p.name] = _said(p, _rounded(p, si / _FASTER))
        elif p.default is None and "little" in vague:
            said[p.name] = _said(p, _rounded(p, si / 2))
    yield canonical(callee.name, skill, PlacedValues(said, {}, (), False))


def _number(parameter: CompiledParameter, given: Mapping[str, str]) -> float:
    text = given.get(parameter.name)
    if text is None:
        return float(parameter.default or 0.0)
    return parameter.unit.to_si(float(text.split(" ", 1)[0]))


def _rounded(parameter: CompiledParameter, si: float) -> float:
    """Return a number of two digits in its unit, within its bounds."""
    unit = parameter.unit
    short = unit.to_si(float(f"{unit.from_si(si):.2g}"))
    return min(max(short, parameter.low), parameter.high)


def _reversed(callee: NameTarget, skill: CompiledSkill, given: Mapping[str, str]) -> str:
    """Return the line that undoes an order, where the profile says what does; else nothing."""
    reverse = skill.skill.reverse
    robot = callee.robots[0]
    if isinstance(reverse, str):
        other = robot.skills.get(reverse)
        return f"{callee.name} {other.spoken}" if other is not None else ""
    undone = dict(given)
    for name, choices in reverse.items():
        parameter = skill.by_name.get(name)
        now = given.get(name, str(parameter.default) if parameter is not None else "")
        if now not in choices:
            return ""
        undone[name] = choices[now]
    if not reverse:
        return ""
    return canonical(callee.name, skill, PlacedValues(undone, {}, (), False))
