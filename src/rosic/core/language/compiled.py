"""Profiles with everything worked out beforehand, so that a message costs look-ups only."""

from __future__ import annotations

import re
from math import isfinite
from typing import TYPE_CHECKING, TypeVar

import msgspec

from rosic.core.language.common_names import shown_name, typed_names
from rosic.core.language.keywords import FILLERS, NOT_FINITE
from rosic.core.language.lexicon import longest_by_first_word
from rosic.core.language.numbers import NONE, Unit, UnitTable, read_numeral
from rosic.core.language.sanitise import clean_name, normalised, quote
from rosic.core.language.suggestions import did_you_mean
from rosic.core.robot.profile import Profile, RobotId
from rosic.core.robot.skill import Argument, Parameter, Skill, SkillClass

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

T = TypeVar("T")

# A bound that went through another unit and back still is the bound.
TOLERANCE = 1e-9
DIGITS = 12
FOLDED_AT_MOST = 512

# What a robot with the text link can do without its profile saying so.
SAY = Skill(
    id="say",
    title="Say something to it",
    kind=SkillClass.TASK,
    parameters={"text": Parameter(title="Text", text=True)},
)


class CompiledParameter(msgspec.Struct, frozen=True, kw_only=True):
    """A parameter in SI.

    Attributes:
        name: As in the profile.
        shown: As people read it.
        unit: The declared one.
        low, high: Bounds, SI, inclusive.
        low_edge, high_edge: The bounds, wider by what converting a unit may lose.
        words: Spelling to choice; None for what is not a choice.
        default: SI; None when it must be given.
    """

    name: str
    shown: str
    unit: Unit
    low: float
    high: float
    low_edge: float
    high_edge: float
    integer: bool
    text: bool
    words: dict[str, str] | None
    default: Argument | None

    @property
    def is_number(self) -> bool:
        """Whether it takes a number."""
        return self.words is None and not self.text


class CompiledSkill(msgspec.Struct, frozen=True, kw_only=True):
    """A skill of one robot.

    Attributes:
        skill: As in the profile.
        spoken: Its name in a command: ``move joint``.
        by_name: Spelling of a parameter's name to the parameter.
        numbers, choices: The parameters of that sort, in declared order.
        words: Every word that some choice knows.
        plain_words: Those of them that even after a number are no unit.
        longest_word: For choices of several words: first word to the number of words.
        text: The parameter that takes the rest of the line, if there is one.
        dimensions: What its numbers measure.
    """

    skill: Skill
    spoken: str
    parameters: tuple[CompiledParameter, ...]
    by_name: dict[str, CompiledParameter]
    numbers: tuple[CompiledParameter, ...]
    choices: tuple[CompiledParameter, ...]
    words: frozenset[str]
    plain_words: frozenset[str]
    longest_word: dict[str, int]
    text: CompiledParameter | None
    dimensions: frozenset[str]

    def declared(self, arguments: Mapping[str, Argument]) -> dict[str, Argument]:
        """Return arguments in SI as programs give them: numbers in their declared units."""
        units = {each.name: each.unit for each in self.numbers}
        return {
            name: value if isinstance(value, str) else _declared(units.get(name, NONE), value)
            for name, value in arguments.items()
        }


def _declared(unit: Unit, value: float) -> float:
    """Return a number in a unit, without what converting it there and back adds at the end."""
    number = float(f"{unit.from_si(value):.{DIGITS}g}")
    return int(number) if isinstance(value, int) and number.is_integer() else number


class CompiledRobot(msgspec.Struct, frozen=True, kw_only=True):
    """A robot.

    Attributes:
        shown: As people read it.
        names: Every word that calls it, or a group it belongs to.
        skills: By id.
        phrases: What a person says to skill.
        longest: First word of a phrase to the number of words in the longest such phrase.
    """

    id: RobotId
    profile: Profile
    shown: str
    names: tuple[str, ...]
    skills: dict[str, CompiledSkill]
    phrases: dict[str, CompiledSkill]
    longest: dict[str, int]


class NameTarget(msgspec.Struct, frozen=True):
    """Whom a name calls.

    Attributes:
        name: A robot's id or a group's name.
        robots: One, or the members of the group.
        group: Whether it is a group, be it of one.
    """

    name: str
    robots: tuple[CompiledRobot, ...]
    group: bool = False


def fold(text: str) -> str:
    """Return a name as the grammar compares it: NFKC, small letters, single spaces.

    Of what is longer than any name no more is looked at.
    """
    return " ".join(normalised(text[:FOLDED_AT_MOST]).casefold().split())


def spellings(name: str) -> tuple[str, ...]:
    """Return the ways in which people type an identifier: ``move_joint``, ``move joint``, ..."""
    folded = fold(name)
    parts = re.split(r"[_\- ]+", folded)
    return tuple(dict.fromkeys([folded, " ".join(parts), "-".join(parts), "".join(parts)]))


def skills_of(profile: Profile) -> dict[str, Skill]:
    """Return everything a robot can do; a robot with the text link can also be spoken to."""
    skills = {
        name: skill if skill.id else msgspec.structs.replace(skill, id=name)
        for name, skill in profile.skills.items()
    }
    if profile.link.dialogue:
        skills.setdefault(SAY.id, SAY)
    return skills


def compile_parameter(name: str, parameter: Parameter, units: UnitTable) -> CompiledParameter:
    """Work a parameter out.

    Raises:
        ValueError: Its unit is unknown, or a choice cannot be said.
    """
    unit = _unit(name, parameter, units)
    low, high = (
        unit.to_si(bound) if bound is not None else 0.0 for bound in (parameter.min, parameter.max)
    )
    if not (isfinite(low) and isfinite(high)):
        raise ValueError(f"parameter {name!r}: its bounds are too large")
    integer = parameter.integer and unit.factor == 1.0 and unit.offset == 0.0
    default = parameter.default
    if default is not None and not isinstance(default, str):
        default = unit.to_si(default)
        default = int(default) if integer else min(max(float(default), low), high)
    return CompiledParameter(
        name=name,
        shown=shown_name(clean_name(name)),
        unit=unit,
        low=low,
        high=high,
        low_edge=low - TOLERANCE * abs(low),
        high_edge=high + TOLERANCE * abs(high),
        integer=parameter.integer,
        text=parameter.text,
        words=_choice_words(name, parameter),
        default=default,
    )


def compile_skill(skill: Skill, units: UnitTable) -> CompiledSkill:
    """Work a skill out.

    Raises:
        ValueError: A parameter cannot be worked out.
    """
    parameters = tuple(compile_parameter(n, p, units) for n, p in skill.parameters.items())
    by_name: dict[str, CompiledParameter] = {}
    for parameter in parameters:
        for spelling in spellings(parameter.name):
            by_name.setdefault(spelling, parameter)
    add_common(by_name, ((parameter.name, parameter) for parameter in parameters))
    words = [word for parameter in parameters for word in parameter.words or ()]
    texts = [parameter for parameter in parameters if parameter.text]
    dimensions = {parameter.unit.dimension for parameter in parameters if parameter.is_number}
    return CompiledSkill(
        skill=skill,
        spoken=fold(skill.id).replace("_", " "),
        parameters=parameters,
        by_name=by_name,
        numbers=tuple(p for p in parameters if p.is_number),
        choices=tuple(p for p in parameters if p.words is not None),
        words=frozenset(words),
        plain_words=frozenset(
            word for word in words if (units.find(word) or NONE).dimension not in dimensions - {""}
        ),
        longest_word=longest_by_first_word(word for word in words if " " in word),
        text=texts[0] if texts else None,
        dimensions=frozenset(dimensions),
    )


def add_common(known: dict[str, T], named: Iterable[tuple[str, T]]) -> None:
    """Let common names be said in other languages, too, where they leave no doubt.

    Args:
        known: What can be said to what it means; is added to.
        named: A name of the profile, and what it means.
    """
    meant: dict[str, list[T]] = {}
    for name, what in named:
        for word in typed_names(name):
            meant.setdefault(word, []).append(what)
    for word, several in meant.items():
        if len(several) == 1:
            known.setdefault(word, several[0])


def merge(skills: tuple[CompiledSkill, ...]) -> CompiledSkill:
    """Return what reads the values for several robots at once: each knows its own words.

    Robots whose profiles say the same share one compiled skill, and nothing is merged.
    """
    first = skills[0]
    others = [skill for skill in skills if skill is not first]
    if not others:
        return first
    by_name = {name: parameter for s in reversed(skills) for name, parameter in s.by_name.items()}
    return msgspec.structs.replace(
        first,
        by_name=by_name,
        words=first.words.union(*(skill.words for skill in others)),
        plain_words=first.plain_words.union(*(skill.plain_words for skill in others)),
        dimensions=first.dimensions.union(*(skill.dimensions for skill in others)),
        longest_word=longest_by_first_word(
            word for skill in skills for p in skill.choices for word in p.words or () if " " in word
        ),
    )


def _unit(name: str, parameter: Parameter, units: UnitTable) -> Unit:
    if not parameter.unit:
        return NONE
    unit = units.find(parameter.unit)
    if unit is None:
        close = did_you_mean(parameter.unit, units.exact)
        hint = f" Did you mean {units.exact[close[0]].symbol}?" if close else ""
        raise ValueError(f"parameter {name!r}: {quote(parameter.unit)} is not a known unit.{hint}")
    return unit


def _choice_words(name: str, parameter: Parameter) -> dict[str, str] | None:
    if parameter.choices is None:
        return None
    words: dict[str, str] = {}
    for choice, others in parameter.choices.items():
        for spelling in (*spellings(choice), *map(fold, others)):
            if spelling in FILLERS or spelling in NOT_FINITE or read_numeral(spelling) is not None:
                raise ValueError(f"parameter {name!r}: {quote(spelling)} cannot be a choice")
            if words.setdefault(spelling, choice) != choice:
                raise ValueError(
                    f"parameter {name!r}: {quote(spelling)} is both "
                    f"{quote(words[spelling])} and {quote(choice)}"
                )
    add_common(words, ((choice, choice) for choice in parameter.choices))
    return words
