"""From the words of a line to a skill and its values, said as a line of the grammar says them."""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.language.lexicon import SenseKind
from rosic.core.language.spoken_numbers import SpokenNumber, SpokenNumbers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.language.compiled import CompiledParameter, CompiledRobot, CompiledSkill
    from rosic.core.language.numbers import UnitTable
    from rosic.core.language.phrase_words import Item, RobotWords

SKILLS_LOOKED_AT: Final = 32
_DIRECTIONS: Final = frozenset({"forward", "back", "backward", "left", "right", "up", "down"})
"""Choices that say what is to be done although no skill is named."""

_IGNORED: Final = frozenset(
    {
        *(SenseKind.NOTHING, SenseKind.BEFORE_NUMBER, SenseKind.REQUEST, SenseKind.ONE),
        *(SenseKind.VERB, SenseKind.COUNTER),
    }
)


# ---- which skills may be meant ----


class SkillEvidence(NamedTuple):
    """What the words say about the skill.

    Attributes:
        skills: Those of the robot that every word for a skill may mean.
        surely: A word says it; else it follows from a verb of any motion.
    """

    skills: tuple[CompiledSkill, ...]
    surely: bool


def skill_evidence(items: Sequence[Item], robot: CompiledRobot, words: RobotWords) -> SkillEvidence:
    """Return which skills of a robot the words of a line may mean, most likely first.

    A word for a skill says more than a choice that it has, that more than a phrase such as ``go
    to``, that more than the names of its parameters, and all of them more than a verb.
    """
    named: list[dict[str, None]] = []
    phrases: dict[str, None] = {}
    chosen: dict[str, None] = {}
    verbs: dict[str, None] = {}
    parameters: list[str] = []
    for item in items:
        if not item.senses:
            continue
        strong = dict.fromkeys(_skills(item, robot))
        if strong and item.follows_verb:
            phrases.update(strong)
        elif strong and item.means(SenseKind.VERB):
            verbs.update(strong)
        elif strong:
            named.append(strong)
        verbs.update(dict.fromkeys(_common(item, SenseKind.VERB, robot)))
        chosen.update(dict.fromkeys(_choosing(item, words)))
        parameters += item.values(SenseKind.OWN_PARAMETER)[:1]
    both = [name for name in (named or [{}])[0] if all(name in other for other in named)]
    if named:
        return SkillEvidence(tuple([robot.skills[name] for name in both]), True)
    taking = _taking(parameters, robot) if not (chosen or phrases) else ()
    likely = tuple(chosen) or tuple(phrases) or taking
    surely = bool(likely)
    if chosen:
        surely = any(_DIRECTIONS.intersection(_said_choices(item, words)) for item in items)
    return SkillEvidence(tuple([robot.skills[n] for n in likely or tuple(verbs)]), surely)


def _choosing(item: Item, words: RobotWords) -> list[str]:
    """Return the skills that have a choice."""
    said = item.values(SenseKind.CHOICE) + item.values(SenseKind.OWN_CHOICE)
    return [skill for choice in said for skill in words.chosen.get(choice, ())] if said else []


def _said_choices(item: Item, words: RobotWords) -> set[str]:
    """Return the choices of this robot that some words say, as its profile calls them."""
    said = (*item.values(SenseKind.CHOICE), *item.values(SenseKind.OWN_CHOICE))
    return {words.choices[choice] for choice in said if choice in words.choices}


def _taking(parameters: Sequence[str], robot: CompiledRobot) -> tuple[str, ...]:
    """Return the skills that have all the parameters that were named."""
    return tuple(
        [
            name
            for name, skill in islice(robot.skills.items(), SKILLS_LOOKED_AT)
            if parameters and all(parameter in skill.by_name for parameter in parameters)
        ]
    )


def _skills(item: Item, robot: CompiledRobot) -> tuple[str, ...]:
    """Return the ids of the robot's skills that some words name."""
    own = item.values(SenseKind.OWN_SKILL)
    return (*own, *_common(item, SenseKind.SKILL, robot))


def _common(item: Item, kind: SenseKind, robot: CompiledRobot) -> tuple[str, ...]:
    """Return the ids of a robot's skills that profiles commonly call so."""
    known = [robot.phrases[name] for name in item.values(kind) if name in robot.phrases]
    return tuple([compiled.skill.id for compiled in known])


# ---- values ----


class PlacedValues(NamedTuple):
    """The values of one skill in a line.

    Attributes:
        given: Parameter to how its value is said: ``0.5 m``, ``left``.
        numbers: Parameter to its number, SI, of those that are numbers.
        left: Words that say nothing of this skill.
        bare: A number has neither a unit nor the name of its parameter beside it.
        beyond: A number is outside its bounds.
    """

    given: dict[str, str]
    numbers: dict[str, float]
    left: tuple[Item, ...]
    beyond: bool
    bare: bool = False

    def missing(self, skill: CompiledSkill) -> tuple[CompiledParameter, ...]:
        """Return the parameters that have no value and no default."""
        return tuple(
            [p for p in skill.parameters if p.default is None and p.name not in self.given]
        )


class SkillValueReader:
    """Reads the values of one skill from the words of a line; used once.

    Args:
        items: The words.
        skill: Whose values.
        units: Those that are known.
        positional: How numbers are put together: see `Numerals.positional`.
    """

    __slots__ = (
        *("_bare", "_beyond", "_given", "_items", "_left", "_named", "_numbers", "_si", "_skill"),
        *("_units", "_waits"),
    )

    def __init__(
        self, items: Sequence[Item], skill: CompiledSkill, units: UnitTable, *, positional: bool
    ) -> None:
        self._items = items
        self._skill = skill
        self._units = units
        self._numbers = SpokenNumbers(items, units, positional=positional)
        self._given: dict[str, str] = {}
        self._si: dict[str, float] = {}
        self._left: list[Item] = []
        self._beyond = self._bare = False
        self._named: CompiledParameter | None = None
        self._waits: Item | None = None

    def read(self) -> PlacedValues:
        """Return the values, and the words that are none of them."""
        at = 0
        while at < len(self._items):
            number = self._numbers.at(at)
            if number is not None:
                named = self._named is not None or self._names_next(number.after)
                self._bare = self._bare or not (number.unit or named)
                if not self._place(number):
                    self._left += self._items[at : number.after]
                at = number.after
            else:
                item, at = self._items[at], at + 1
                if not item.is_known:
                    self._left.append(item)
                elif not _says_nothing(item):
                    self._take(item, at)
        self._name(None, None)
        left = tuple([item for item in self._left if not self._names_given(item)])
        return PlacedValues(self._given, self._si, left, self._beyond, self._bare)

    def _take(self, item: Item, after: int) -> None:
        """Take in some words that are no number."""
        parameter = self._parameter(item)
        if item.text == "=":
            return
        if self._choose(item):
            self._named = self._waits = None
        elif self._named is None and self._choices(item):
            self._left.append(item)  # left and right
        elif parameter is not None and parameter.name in self._given:
            return  # the second joint
        elif parameter is not None and self._is_followed(after):
            self._name(parameter, None if self._says_skill(item) else item)
        elif not self._is_ignored(item, after):
            self._left.append(item)

    def _name(self, parameter: CompiledParameter | None, waits: Item | None) -> None:
        """Note which parameter the next value is of; of the one before nothing was said."""
        if self._waits is not None:
            self._left.append(self._waits)
        self._named, self._waits = parameter, waits

    def _is_followed(self, at: int) -> bool:
        """Whether a value follows a parameter's name, words that say nothing between."""
        items = self._items
        while at < len(items) and items[at].means(SenseKind.NOTHING):
            at += 1
        if at >= len(items):
            return False
        return self._numbers.at(at) is not None or bool(self._choices(items[at]))

    def _names_next(self, at: int) -> bool:
        """Whether the name of a parameter follows a number: ``the second joint``.

        Not if another number follows that may be its own: ``2 x 1 m``.
        """
        items = self._items
        parameter = self._parameter(items[at]) if at < len(items) else None
        if parameter is None:
            return False
        at += 1
        while at < len(items) and items[at].means(SenseKind.NOTHING):
            at += 1
        number = self._numbers.at(at) if at < len(items) else None
        unit = self._units.find(number.unit) if number is not None and number.unit else None
        return number is None or (unit is not None and unit.dimension != parameter.unit.dimension)

    def _parameter(self, item: Item) -> CompiledParameter | None:
        by_name = self._skill.by_name
        own, common = item.values(SenseKind.OWN_PARAMETER), item.values(SenseKind.PARAMETER)
        for name in (*own, *common):
            if name in by_name:
                return by_name[name]
        return None

    def _says_skill(self, item: Item) -> bool:
        skill = self._skill.skill.id
        common = {skill, skill.replace("_", " "), skill.replace("_", "")}
        return skill in item.values(SenseKind.OWN_SKILL) or not common.isdisjoint(
            item.values(SenseKind.SKILL)
        )

    def _names_given(self, item: Item) -> bool:
        """Whether some words only name a parameter that has a choice: ``into the home pose``."""
        parameter = self._parameter(item)
        return parameter is not None and not parameter.is_number and parameter.name in self._given

    def _is_ignored(self, item: Item, after: int) -> bool:
        if item.means(SenseKind.COMBINED):
            return False  # descends: of a robot that cannot go down
        if self._says_skill(item) or any(sense.kind in _IGNORED for sense in item.senses):
            return True
        manners = item.values(SenseKind.MANNER)
        greets = "hello" in manners and not item.means(SenseKind.TIME)  # morgen
        return (after == 1 and greets) or (after == len(self._items) and "thanks" in manners)

    # ---- choices ----

    def _choices(self, item: Item) -> list[tuple[CompiledParameter, str]]:
        """Return what some words may choose: the parameter, and its choice."""
        said = (
            *item.values(SenseKind.OWN_CHOICE),
            *item.values(SenseKind.CHOICE),
            *item.values(SenseKind.SKILL),
            *((item.text, item.callee.name) if item.callee is not None else ()),
        )
        if not said:
            return []
        return [
            (parameter, parameter.words[word])
            for parameter in self._skill.choices
            for word in said
            if parameter.words is not None and word in parameter.words
        ]

    def _choose(self, item: Item) -> bool:
        """Take in a choice; whether the words are one. Said twice alike, it is said once."""
        for parameter, choice in self._choices(item):
            if self._named is not None and parameter.name != self._named.name:
                continue
            if self._given.setdefault(parameter.name, choice) == choice:
                return True
        return False

    # ---- numbers ----

    def _place(self, number: SpokenNumber) -> bool:
        """Give a number its place; whether it has one."""
        unit = self._units.find(number.unit) if number.unit else None
        if number.unit and unit is None:
            return False
        alike = [
            p
            for p in ((self._named,) if self._named is not None else self._skill.numbers)
            if p.is_number
            and p.name not in self._given
            and (unit is None or p.unit.dimension == unit.dimension)
        ]
        self._named = self._waits = None
        if not alike:
            return False
        parameter = alike[0]
        shown = unit or parameter.unit
        si = shown.to_si(number.value)
        self._beyond = self._beyond or not parameter.low_edge <= si <= parameter.high_edge
        self._given[parameter.name] = f"{number.value:.10g} {shown.symbol}".rstrip()
        self._si[parameter.name] = si
        return True


def _says_nothing(item: Item) -> bool:
    """Whether some words say nothing of any skill's values."""
    return bool(item.senses) and item.callee is None and _IGNORED.issuperset(item.kinds)


# ---- as a line of the grammar ----


def canonical(name: str, skill: CompiledSkill, values: PlacedValues) -> str:
    """Return the line of the grammar that says this of a robot or a group."""
    said = []
    for parameter in skill.parameters:
        value = values.given.get(parameter.name)
        if value is not None:
            alone = _goes_alone(skill, parameter, value)
            said.append(value.replace("_", " ") if alone else f"{parameter.name}={value}")
    return " ".join((name, skill.spoken, *said))


def _goes_alone(skill: CompiledSkill, parameter: CompiledParameter, value: str) -> bool:
    """Whether a value goes to its parameter without the name of that."""
    if parameter.words is not None:
        others = (other.words or {} for other in skill.choices if other is not parameter)
        return not any(value in words for words in others)
    dimension = parameter.unit.dimension
    alike = [p for p in skill.numbers if p.unit.dimension == dimension]
    return bool(dimension) and " " in value and len(alike) == 1
