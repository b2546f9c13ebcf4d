"""Robots that are called by what they are: ``drone 1``, ``drones``, ``alle Drohnen``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.language.lexicon import SenseKind
from rosic.core.language.phrase_words import NO_WORDS, Item

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.core.language.compiled import NameTarget
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot.profile import RobotId

ALL: Final = "all"
FARTHEST: Final = 2
"""So many words may stand before a kind: a number, and what counts it."""


class KindReader:
    """Finds robots and groups that a line calls by what they are.

    Args:
        vocabulary: What can be said.
        visible: The robots that this person may see.
        seen: What the person may see of a robot or group.
    """

    __slots__ = ("_found", "_seen", "_visible", "_vocabulary")

    def __init__(
        self,
        vocabulary: Vocabulary,
        visible: frozenset[RobotId],
        seen: Callable[[NameTarget], NameTarget | None],
    ) -> None:
        self._vocabulary = vocabulary
        self._visible = visible
        self._seen = seen
        self._found: dict[str, NameTarget | None] = {}

    def named(self, items: list[Item]) -> list[Item]:
        """Return the words with those made one that say ``drone 1``, ``drones`` or ``all drones``.

        What is no robot or group by that stays what it is.
        """
        kinds = [
            at
            for at, item in enumerate(items)
            if item.means(SenseKind.KIND) or item.means(SenseKind.KINDS)
        ]
        if not kinds:
            return items
        counted = any(item.means(SenseKind.COUNTER) for item in items)
        found: list[Item] = []
        at = 0
        while at < len(items):
            if not counted and (kind := items[at].values(SenseKind.KINDS)):
                callee, end = self.all_of(kind[0]), at + 1
            elif any(at <= place <= at + FARTHEST for place in kinds):
                callee, end = self._of_kind(items, at, counted=counted)
            else:
                callee, end = None, at
            if callee is None:
                found.append(items[at])
                at += 1
                continue
            text = " ".join(item.text for item in items[at:end])
            words = self._vocabulary.words.get(callee.robots[0].id, NO_WORDS)
            senses = words.senses.get(callee.name, ())
            found.append(Item(text, items[at].at, items[end - 1].end, senses, callee))
            at = end
        return found

    def _of_kind(
        self, items: Sequence[Item], at: int, *, counted: bool
    ) -> tuple[NameTarget | None, int]:
        """Return who is named here by what they are, and where that ends."""
        every = ALL in items[at].values(SenseKind.KIND)
        number, end = _number_before(items, at) if counted else ("", at)
        end += every
        if end >= len(items):
            return None, at
        kinds = items[end].values(SenseKind.KINDS)
        if kinds:
            return self.all_of(kinds[0]), end + 1
        kind = next((k for k in items[end].values(SenseKind.KIND) if k != ALL), "")
        if kind and every:
            return self.all_of(kind), end + 1
        if kind and not number and end + 1 < len(items):
            number, end = _digits(items[end + 1]), end + 1
        return (self._numbered(kind, number), end + 1) if kind and number else (None, at)

    def all_of(self, kind: str) -> NameTarget | None:
        """Return the group whose visible members are all that have a skill."""
        if kind not in self._found:
            self._found[kind] = self._all_of(kind)
        return self._found[kind]

    def _all_of(self, kind: str) -> NameTarget | None:
        able = self._vocabulary.having.get(kind, frozenset()) & self._visible
        for callee in self._vocabulary.groups:
            seen = self._seen(callee)
            if seen is not None and frozenset([robot.id for robot in seen.robots]) == able:
                return seen
        return None

    def _numbered(self, kind: str, number: str) -> NameTarget | None:
        """Return the robot that a profile calls so in any language: ``drone 1``."""
        for name in self._vocabulary.phrases.kinds.get(kind, ()):
            callee = self._vocabulary.spoken_names.get(f"{name} {number}")
            if callee is not None and not callee.group and (seen := self._seen(callee)):
                return seen
        return None


def _number_before(items: Sequence[Item], at: int) -> tuple[str, int]:
    """Return the number that stands before a kind, as in ``2号无人机``, and where it ends."""
    for place in (at, at + 1):
        others = items[at : place + 1] if place > at else items[at + 1 : at + 2]
        counter = any(item.means(SenseKind.COUNTER) for item in others)
        if counter and place < len(items) and (number := _digits(items[place])):
            return number, at + 2
    return "", at


def _digits(item: Item) -> str:
    """Return a whole number as digits; empty for anything else."""
    numbers = item.values(SenseKind.NUMBER)
    if item.numeral is not None and not item.numeral.rest:
        return item.text if item.text.isdecimal() else ""
    return f"{float(numbers[0]):.0f}" if numbers and float(numbers[0]).is_integer() else ""
