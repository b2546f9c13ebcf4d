"""What to say when a line was not understood: why, and what may have been meant.

Only here more than the words themselves is looked at, and at most some hundred names. Robots that
the person may not see are neither named nor hinted at.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING

from rosic.core.language.cleaning import quote
from rosic.core.language.lines import Misunderstood
from rosic.core.language.suggestions import MOST_CANDIDATES, did_you_mean, listed
from rosic.core.language.words import HINTS, VERBS
from rosic.core.saying import said

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rosic.core.language.compiled import CompiledSkill
    from rosic.core.language.vocabulary import Callee, Vocabulary
    from rosic.core.robot import RobotId

MOST_OFFERS = 4
LONGEST_OFFER = 128


class Misunderstanding:
    """Makes the answer to a line that was not understood."""

    __slots__ = ("_low", "_raw", "_visible", "_vocabulary")

    def __init__(
        self,
        raw: list[str],
        low: list[str],
        vocabulary: Vocabulary,
        visible: frozenset[RobotId],
    ) -> None:
        self._raw = raw
        self._low = low
        self._vocabulary = vocabulary
        self._visible = visible

    def nothing_said(self) -> Misunderstood:
        """The line has only words that mean nothing here."""
        return Misunderstood(said("Say help for what can be said."), ("help",))

    def too_many_words(self, most: int) -> Misunderstood:
        """The line is longer than any command."""
        return Misunderstood(
            said(
                "That line has {low} words; I read at most {most}. Nothing was done.",
                low=len(self._low),
                most=most,
            )
        )

    def two_readings(self, callee: Callee, at: int, readings: tuple[str, ...]) -> Misunderstood:
        """A number may mean two."""
        name = _shown(callee)
        return Misunderstood(
            said(
                "{name}: {quote} may mean {listed}. Nothing was done.",
                name=name,
                quote=quote(self._raw[at]),
                listed=listed(readings),
            ),
            self._offers(at, readings),
        )

    def no_such_skill(self, callee: Callee, at: int, *, chosen: bool = False) -> Misunderstood:
        """A robot or group has no skill of that name.

        Args:
            callee: Who was asked.
            at: Place of the word.
            chosen: The robot was not named; the word may be another robot's or a verb.
        """
        if (stop := self._stop_inside(callee.name)) is not None:
            return stop
        sentence = (
            said("Nobody in {name} has {quote}.", name=callee.name, quote=quote(self._raw[at]))
            if callee.group
            else said("{shown} has no {quote}.", shown=_shown(callee), quote=quote(self._raw[at]))
        )
        close = _one_each(did_you_mean(self._low[at], _phrases(callee)), _skills(callee))
        if not close and chosen:
            return self._guess(at, sentence)
        if not close:
            return Misunderstood(
                said("{sentence} Say help {name}.", sentence=sentence, name=callee.name),
                (f"help {callee.name}",),
            )
        prefix = f"{callee.name} " if chosen else ""
        offers = tuple([prefix + offer for offer in self._offers(at, close)])
        return Misunderstood(
            said("{sentence} Did you mean {listed}?", sentence=sentence, listed=listed(close)),
            offers,
        )

    def no_such_robot(self, at: int) -> Misunderstood:
        """A name names nobody the person may see."""
        close = did_you_mean(self._low[at], self._callees())
        close = _one_each(close, self._vocabulary.callees)
        sentence = said("I know no robot {quote}.", quote=quote(self._raw[at]))
        if not close:
            return Misunderstood(
                said("{sentence} Say robots for those you may use.", sentence=sentence), ("robots",)
            )
        return Misunderstood(
            said("{sentence} Did you mean {listed}?", sentence=sentence, listed=listed(close)),
            self._offers(at, close),
        )

    def nothing_known(self, at: int) -> Misunderstood:
        """The line begins with nothing that is known."""
        if (stop := self._stop_inside("")) is not None:
            return stop
        return self._guess(at, said("I do not know {quote}.", quote=quote(self._raw[at])))

    def which_robot(
        self, chosen: Callee | None, phrase: str, at: int, able: list[RobotId]
    ) -> Misunderstood:
        """Several robots can do it, and none was named; or one that is not the chosen one."""
        robots = self._vocabulary.robots
        groups = [
            group
            for group in robots[able[0]].profile.groups
            if self._seen_members(group) == set(able)
        ]
        some = (*groups, *able)[:MOST_OFFERS]
        more = len(groups) + len(able) > len(some)
        rest = " ".join(self._raw[at:]).replace(" = ", "=")
        has_not = (
            said("{shown} has no {quote}. ", shown=_shown(chosen), quote=quote(phrase))
            if chosen is not None
            else ""
        )
        return Misunderstood(
            said(
                "{has_not}Which robot is to {phrase}: {listed}?",
                has_not=has_not,
                phrase=phrase,
                listed=listed((*some, said("another")) if more else some),
            ),
            tuple([f"{name} {rest}" for name in some if len(rest) <= LONGEST_OFFER]),
        )

    def _seen_members(self, group: str) -> set[RobotId]:
        return set(self._vocabulary.members(group)) & self._visible

    def _stop_inside(self, name: str) -> Misunderstood | None:
        """A stop among other words: say how to be sure of it."""
        if "stop" not in self._low:
            return None
        offers = (f"stop {name}", "stop") if name else ("stop",)
        return Misunderstood(said("To stop, send stop in a line of its own."), offers)

    def _guess(self, at: int, sentence: str) -> Misunderstood:
        word = self._low[at]
        hint = HINTS.get(word)
        close = (hint,) if hint else did_you_mean(word, self._first_words())
        close = _one_each(close, self._vocabulary.callees)
        if not close:
            return Misunderstood(
                said("{sentence} Say help for what can be said.", sentence=sentence), ("help",)
            )
        return Misunderstood(
            said("{sentence} Did you mean {listed}?", sentence=sentence, listed=listed(close)),
            self._offers(at, close),
        )

    def _first_words(self) -> Iterator[str]:
        """Yield what a line may begin with for this person, up to some hundred words."""
        yield from sorted(VERBS)
        yield from self._callees()
        robots = self._vocabulary.robots
        for robot in islice(self._visible, MOST_CANDIDATES):
            if robot in robots:
                yield from robots[robot].phrases

    def _callees(self) -> Iterator[str]:
        """Yield what names somebody visible, up to some hundred robots."""
        robots = self._vocabulary.robots
        for robot in islice(self._visible, MOST_CANDIDATES // 4):
            if robot in robots:
                yield from robots[robot].names

    def _offers(self, at: int, words: tuple[str, ...]) -> tuple[str, ...]:
        """Return the line with other words in place of one."""
        before, after = self._raw[:at], self._raw[at + 1 :]
        lines = (" ".join([*before, word, *after]).replace(" = ", "=") for word in words)
        return tuple([line for line in lines if len(line) <= LONGEST_OFFER])[:MOST_OFFERS]


def _shown(callee: Callee) -> str:
    return callee.name if callee.group else callee.robots[0].shown


def _one_each(words: tuple[str, ...], meanings: Mapping[str, object]) -> tuple[str, ...]:
    """Return the words without those that mean the same as an earlier one."""
    kept: dict[int, str] = {}
    for word in words:
        kept.setdefault(id(meanings.get(word, word)), word)
    return tuple(kept.values())


def _skills(callee: Callee) -> dict[str, CompiledSkill]:
    return callee.robots[0].phrases


def _phrases(callee: Callee) -> Iterator[str]:
    for robot in callee.robots:
        yield from robot.phrases
