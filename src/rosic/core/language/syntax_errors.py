"""What to say when a line was not understood: why, and what may have been meant.

Only here more than the words themselves is looked at, and at most some hundred names. Robots that
the person may not see are neither named nor hinted at.
"""

from __future__ import annotations

from itertools import islice
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.language.ast import Misunderstood
from rosic.core.language.command import VERBS
from rosic.core.language.keywords import FILLERS, HINTS, SOFT_FILLERS
from rosic.core.language.sanitise import quote
from rosic.core.language.stop_detection import resembles_stop, speaks_of_stop
from rosic.core.language.suggestions import MOST_CANDIDATES, did_you_mean, listed, one_each

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from rosic.core.language.compiled import CompiledSkill, NameTarget
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot.profile import RobotId

MOST_OFFERS = 4
LONGEST_OFFER = 128


class SyntaxErrorBuilder:
    """Makes the answer to a line that was not understood.

    A word is proposed only where the whole line can be read with it: a button that is refused
    helps nobody.

    Args:
        words: Those of the line as typed, and in small letters.
        vocabulary: What can be said.
        visible: The robots that this person may see.
        reads: Whether a line would be read to its end; None where nothing is to be proposed.
    """

    __slots__ = ("_low", "_raw", "_reads", "_visible", "_vocabulary")

    def __init__(
        self,
        words: tuple[list[str], list[str]],
        vocabulary: Vocabulary,
        visible: frozenset[RobotId],
        reads: Callable[[str], bool] | None,
    ) -> None:
        self._raw, self._low = words
        self._vocabulary = vocabulary
        self._visible = visible
        self._reads = reads

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

    def two_readings(self, callee: NameTarget, at: int, readings: tuple[str, ...]) -> Misunderstood:
        """A number may mean two."""
        name = _shown(callee)
        return Misunderstood(
            said(
                "{name}: {quote} may mean {listed}. Nothing was done.",
                name=name,
                quote=quote(self._raw[at]),
                listed=listed(readings),
            ),
            tuple(self._mended(at, readings).values()),
        )

    def no_such_skill(self, callee: NameTarget, at: int, *, chosen: bool = False) -> Misunderstood:
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
        if offered := self._reordered(callee, at):
            return _meant(sentence, offered)
        close = one_each(self._close(at, _phrases(callee)), _skills(callee))
        prefix = f"{callee.name} " if chosen else ""
        mended = self._mended(at, close, prefix)
        if not mended and chosen:
            return self._guess(at, sentence)
        if not mended:
            return Misunderstood(
                said("{sentence} Say help {name}.", sentence=sentence, name=callee.name),
                (f"help {callee.name}",),
            )
        return _meant(sentence, mended)

    def _reordered(self, callee: NameTarget, at: int) -> dict[str, str]:
        """Return the lines that say it with what was left out, or the other way round.

        ``omni forward 1 m`` names a direction but no skill; ``omni picture`` a command that begins
        with itself.
        """
        if self._reads is None:
            return {}
        lines = [" ".join((word, callee.name, *self._raw[at + 1 :])) for word in self._commands(at)]
        for first in (at, at + 1)[: len(self._low) - at]:
            lines += [
                " ".join((callee.name, skill.spoken, *self._raw[first:])).replace(" = ", "=")
                for skill in islice(callee.robots[0].skills.values(), MOST_CANDIDATES // 8)
                if self._low[first] in skill.words
            ]
        read = self._read(line for line in lines if len(line) <= LONGEST_OFFER)
        return {line: line for line in islice(read, MOST_OFFERS)}

    def _commands(self, at: int) -> tuple[str, ...]:
        """Return the command that a word behind a name is, if it is one that asks for a name."""
        if self._low[at] in FILLERS or self._low[at] in SOFT_FILLERS:
            return ()  # omni um 30 Grad: no command of that name is meant
        word = self._vocabulary.commands.aliases.get(self._low[at], self._low[at])
        return (word,) if word in self._vocabulary.commands.words else ()

    def no_such_robot(self, at: int) -> Misunderstood:
        """A name names nobody the person may see."""
        close = self._close(at, self._alike(at, self._callees()))
        mended = self._mended(at, one_each(close, self._vocabulary.callees))
        sentence = said("I know no robot {quote}.", quote=quote(self._raw[at]))
        if not mended:
            return Misunderstood(
                said("{sentence} Say robots for those you may use.", sentence=sentence), ("robots",)
            )
        return _meant(sentence, mended)

    def nothing_known(self, at: int) -> Misunderstood:
        """The line begins with nothing that is known."""
        if (stop := self._stop_inside("")) is not None:
            return stop
        sentence = said("I do not know {quote}.", quote=quote(self._raw[at]))
        if len(self._low) == at + 1 and resembles_stop(self._low[at]):
            return self._stop_first(at, sentence)
        return self._guess(at, sentence)

    def which_robot(
        self, chosen: NameTarget | None, phrase: str, at: int, able: list[RobotId]
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
        lines = self._read(
            [f"{name} {rest}" for name in some] if len(rest) <= LONGEST_OFFER else []
        )
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
            tuple(lines),
        )

    def _seen_members(self, group: str) -> set[RobotId]:
        return set(self._vocabulary.members(group)) & self._visible

    def _stop_inside(self, name: str) -> Misunderstood | None:
        """A stop among other words: say how to be sure of it."""
        if not speaks_of_stop(" ".join(self._raw), self._vocabulary.known):
            return None
        offers = (f"stop {name}", "stop") if name else ("stop",)
        return Misunderstood(said("To stop, send stop in a line of its own."), offers)

    def _stop_first(self, at: int, sentence: str) -> Misunderstood:
        """A line of one word that resembles a stop: that is offered before anything else."""
        close = (
            word for word in did_you_mean(self._low[at], self._first_words()) if word != "stop"
        )
        return _meant(sentence, {"stop": "stop", **self._mended(at, tuple(close))})

    def _guess(self, at: int, sentence: str) -> Misunderstood:
        word = self._low[at]
        hint = HINTS.get(word)
        close = (hint,) if hint else self._close(at, self._alike(at, self._first_words()))
        mended = self._mended(at, one_each(close, self._vocabulary.callees))
        if not mended:
            return Misunderstood(
                said("{sentence} Say help for what can be said.", sentence=sentence), ("help",)
            )
        return _meant(sentence, mended)

    def _close(self, at: int, candidates: Iterable[str]) -> tuple[str, ...]:
        """Return what may have been meant by a word, where anything is to be proposed at all."""
        return did_you_mean(self._low[at], candidates) if self._reads is not None else ()

    def _read(self, lines: Iterable[str]) -> Iterator[str]:
        """Yield those lines that would be read to their end."""
        if self._reads is not None:
            yield from filter(self._reads, lines)

    def _alike(self, at: int, candidates: Iterable[str]) -> Iterator[str]:
        """Yield what a word can have been meant for: with a number it names one, and no group."""
        numbered = any(letter.isdigit() for letter in self._low[at])
        callees = self._vocabulary.callees
        for candidate in candidates:
            callee = callees.get(candidate)
            if not (numbered and callee is not None and callee.group):
                yield candidate

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

    def _mended(self, at: int, words: tuple[str, ...], prefix: str = "") -> dict[str, str]:
        """Return the words that make a whole line in the place of one, with those lines.

        Args:
            at: Place of the word.
            words: What may have been meant.
            prefix: What the line begins with: the name of a chosen robot.
        """
        before, after = self._raw[:at], self._raw[at + 1 :]
        lines = {
            word: prefix + " ".join([*before, word, *after]).replace(" = ", "=") for word in words
        }
        read = set(self._read(line for line in lines.values() if len(line) <= LONGEST_OFFER))
        return {word: line for word, line in lines.items() if line in read}


def _meant(sentence: str, mended: dict[str, str]) -> Misunderstood:
    """Return a sentence with what may have been meant, and the lines to tap."""
    return Misunderstood(
        said("{sentence} Did you mean {listed}?", sentence=sentence, listed=listed(tuple(mended))),
        tuple(mended.values())[:MOST_OFFERS],
    )


def _shown(callee: NameTarget) -> str:
    return callee.name if callee.group else callee.robots[0].shown


def _skills(callee: NameTarget) -> dict[str, CompiledSkill]:
    return callee.robots[0].phrases


def _phrases(callee: NameTarget) -> Iterator[str]:
    for robot in callee.robots:
        yield from robot.phrases
