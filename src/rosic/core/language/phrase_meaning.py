"""What one language's reading of a line asks of a robot or a group."""

from __future__ import annotations

from itertools import islice, pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.language.ast import Answered
from rosic.core.language.lexicon import ARTICLE, OPENING, SenseKind
from rosic.core.language.phrase_places import place_gone_to
from rosic.core.language.phrase_values import (
    PlacedValues,
    SkillEvidence,
    SkillValueReader,
    canonical,
    skill_evidence,
)
from rosic.core.language.phrase_words import NO_WORDS
from rosic.core.language.proposals import reversed_numbers

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.core.language.compiled import CompiledRobot, CompiledSkill, NameTarget
    from rosic.core.language.lexicon import LexiconTable
    from rosic.core.language.phrase_words import Item, RobotWords
    from rosic.core.language.vocabulary import Vocabulary

ROBOTS_LOOKED_AT: Final = 8
_OPENS: Final = (OPENING,)


class Reading(NamedTuple):
    """One language's reading of a line.

    Attributes:
        items: The words.
        unknown: How many of them mean nothing.
    """

    table: LexiconTable
    items: list[Item]
    unknown: int

    @property
    def is_blocked(self) -> bool:
        """Whether words in the line make it no order.

        Some say nothing before a number: ``a 0,2 m/s`` without its accent, but not ``il a avance``.
        """
        return any(
            item.means(SenseKind.BLOCKED)
            and (at == 1 or item.values(SenseKind.BLOCKED) != _OPENS)
            and not (item.means(SenseKind.BEFORE_NUMBER) and _is_number(self.items[at : at + 1]))
            for at, item in enumerate(self.items, 1)
        )

    def has(self, kind: SenseKind) -> bool:
        """Whether any words of a sort stand in the line."""
        return any(item.means(kind) for item in self.items)


def best_of(readings: Sequence[Reading]) -> list[Reading]:
    """Return the readings in which the fewest words mean nothing."""
    fewest = min((reading.unknown for reading in readings), default=0)
    return [reading for reading in readings if reading.unknown == fewest]


_OF_PROFILE: Final = frozenset({SenseKind.OWN_SKILL, SenseKind.OWN_CHOICE, SenseKind.OWN_PARAMETER})


def own_words(reading: Reading) -> int:
    """Return how many words are of the profile or numbers alone, and not of the language."""
    return sum(all(sense.kind in _OF_PROFILE for sense in item.senses) for item in reading.items)


def only_asks(reading: Reading) -> bool:
    """Whether a line is a question, with a name in it at most."""
    return all(
        item.means(SenseKind.QUESTION) or item.means(SenseKind.NOTHING) or item.callee is not None
        for item in reading.items
    )


def answered(manner: str) -> Answered:
    """Return the answer to what is polite; praise is answered as thanks are."""
    return Answered("thanks" if manner == "praise" else manner)


class Meaning(NamedTuple):
    """What a line asks of a robot, as far as it says so.

    Attributes:
        line: The line of the grammar.
        whole: Every word of it was used, and nothing else can be meant.
        goes: It goes to a place that is kept.
    """

    line: str
    skill: CompiledSkill
    values: PlacedValues
    evidence: SkillEvidence
    whole: bool
    goes: bool = False


class MeaningReader:
    """Finds what a reading asks for.

    Args:
        vocabulary: What can be said.
    """

    __slots__ = ("_vocabulary",)

    def __init__(self, vocabulary: Vocabulary) -> None:
        self._vocabulary = vocabulary

    def read(self, reading: Reading, callee: NameTarget) -> Meaning | None:
        """Return what a reading asks of somebody; None where it names nothing they can do."""
        robot = self._able(reading, callee)
        words = self._vocabulary.words.get(robot.id, NO_WORDS)
        items = without_callee(reading.items, callee)
        evidence = skill_evidence(items, robot, words)
        if words.places and len(callee.robots) == 1:
            going = self._going(reading.table, items, callee)
            if going is not None:
                return going
        return self._best(items, evidence, callee, positional=reading.table.positional)

    def _going(
        self, table: LexiconTable, items: Sequence[Item], callee: NameTarget
    ) -> Meaning | None:
        """Return what a line asks that goes to a place of the robot."""
        robot = callee.robots[0]
        place, whole = place_gone_to(items, self._vocabulary.places.get(robot.id, {}), table)
        skill = robot.skills.get(place.skill) if place is not None else None
        if place is None or skill is None:
            return None
        line = f"{callee.name} {skill.spoken} {place.name}"
        values = PlacedValues({}, {}, (), beyond=False)
        return Meaning(line, skill, values, SkillEvidence((skill,), surely=True), whole, goes=True)

    def _able(self, reading: Reading, callee: NameTarget) -> CompiledRobot:
        """Return the member of a group that has what is asked for, or the robot."""
        if len(callee.robots) == 1:
            return callee.robots[0]
        before: RobotWords | None = None
        for robot in islice(callee.robots, ROBOTS_LOOKED_AT):
            words = self._vocabulary.words.get(robot.id, NO_WORDS)
            if words is before:
                continue  # robots of one kind share their words
            before = words
            if skill_evidence(reading.items, robot, words).surely:
                return robot
        return callee.robots[0]

    def _best(
        self,
        items: Sequence[Item],
        evidence: SkillEvidence,
        callee: NameTarget,
        *,
        positional: bool,
    ) -> Meaning | None:
        """Return the skill that takes most of the words; the profile's order decides a tie."""
        best: Meaning | None = None
        alike = 0
        rank = (0, 0, 0)
        for skill in islice(evidence.skills, ROBOTS_LOOKED_AT):
            reader = SkillValueReader(items, skill, self._vocabulary.units, positional=positional)
            values = reader.read()
            missing = len(values.missing(skill))
            mine = (len(values.left), missing, int(values.beyond))
            if best is None or mine < rank:
                best = self._meant(callee, skill, values, evidence)
                rank, alike = mine, 1
            elif mine == rank:
                alike += 1
        if best is None:
            return None
        # A skill that only a verb of any motion names is sure where it takes a number of the line.
        surely = evidence.surely or (bool(best.values.numbers) and _verb_first(items))
        # Of two that lack something the profile's first is asked about; of two whole ones, neither.
        doubt = alike > 1 and not rank[1]
        return best._replace(whole=surely and not (rank[0] or doubt or best.values.bare))

    def _meant(
        self,
        callee: NameTarget,
        skill: CompiledSkill,
        values: PlacedValues,
        evidence: SkillEvidence,
    ) -> Meaning:
        turned = reversed_numbers(skill, values)
        line = canonical(callee.name, skill, turned)
        return Meaning(line, skill, turned, evidence, whole=False)


def _is_number(items: Sequence[Item]) -> bool:
    return any(
        item.numeral is not None or item.means(SenseKind.NUMBER) or item.means(SenseKind.ONE)
        for item in items
    )


def _verb_first(items: Sequence[Item]) -> bool:
    """Whether the verb stands before the number: ``1 m to go`` is no order."""
    for item in items:
        if item.means(SenseKind.VERB):
            return True
        if item.numeral is not None or item.means(SenseKind.NUMBER):
            return False
    return False


def without_callee(items: Sequence[Item], callee: NameTarget) -> list[Item]:
    """Return the words without those that name whom all of it is for."""
    kept: list[Item] = []
    subject = False
    for item in items:
        named = item.callee is not None and item.callee.name == callee.name
        if named and not subject:
            subject = True
        elif kept or subject or not item.means(SenseKind.THEN):  # and now, forward
            kept.append(item)
    return kept


# ---- the order of the words ----

DOES: Final = (SenseKind.SKILL, SenseKind.VERB, SenseKind.OWN_SKILL, SenseKind.CHOICE)


def is_in_order(items: Sequence[Item], callee: NameTarget) -> bool:
    """Whether of two that are named the first is asked, and the second follows what it is to do.

    ``cf2 follow cf1`` says who follows whom, ``follow cf1 with cf2`` the other way round.
    """
    named = {at: item.callee.name for at, item in enumerate(items) if item.callee is not None}
    if len(set(named.values())) < 2:  # noqa: PLR2004
        return True
    does = [
        at
        for at, item in enumerate(items)
        if item.means(SenseKind.SKILL) or item.means(SenseKind.OWN_SKILL)
    ]
    moved = any(item.means(SenseKind.VERB) for item in items)
    if len(named) != 2 or len(does) != 1 or moved:  # noqa: PLR2004
        return False
    first, second = named
    return named[first] == callee.name and first < does[0] < second


def is_told(items: Sequence[Item]) -> bool:
    """Whether a line says of a robot what it can do: ``omni puede avanzar 1 m``."""
    return any(
        item.callee is not None and after.means(SenseKind.REQUEST) and " " not in after.text
        for item, after in pairwise(items)
    )


def speaks_of(items: Sequence[Item]) -> bool:
    """Whether a line begins with an article before what can be done: ``the launch``."""
    articles = items[0].values(SenseKind.NOTHING) if len(items) > 1 else ()
    does = any(items[1].means(kind) for kind in DOES) if articles else False
    return does and ARTICLE in articles and items[1].callee is None


def clauses_of(items: Sequence[Item]) -> list[list[Item]]:
    """Return the words between those that say that something follows.

    What says nothing that can be done belongs to what is before it.
    """
    clauses: list[list[Item]] = [[]]
    for item in items:
        if item.means(SenseKind.THEN):
            clauses.append([])
        else:
            clauses[-1].append(item)
    kept: list[list[Item]] = []
    for clause in clauses:
        if kept and not any(item.means(kind) for item in clause for kind in DOES):
            kept[-1] += clause
        elif clause:
            kept.append(clause)
    return kept
