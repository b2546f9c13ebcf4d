"""Why a value cannot be used, in one sentence, and what to say instead."""

from __future__ import annotations

from itertools import chain
from math import isfinite
from typing import TYPE_CHECKING

from rosic.core.language.cleaning import quote
from rosic.core.language.showing import show_bound, show_number, usual_values
from rosic.core.language.suggestions import did_you_mean, listed
from rosic.core.order import Spoken
from rosic.errors import NotUnderstood, OutOfBounds, Refusal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.language.units import Unit
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot import RobotId
    from rosic.core.skill import Argument

MOST_OFFERS = 4
# Parameters that say how much of the skill itself: "one move may be at most 5 m".
_EXTENTS = frozenset({"angle", "distance", "duration"})
_NOTHING_DONE = "Nothing was done."


class Objection:
    """Finds out what is wrong with values that could not be bound."""

    __slots__ = ("_addressee", "_compiled", "_robot", "_spoken", "_units")

    def __init__(
        self,
        vocabulary: Vocabulary,
        robot: RobotId,
        compiled: CompiledSkill,
        spoken: tuple[Spoken, ...],
        addressee: str,
    ) -> None:
        self._units = vocabulary.units
        self._robot = vocabulary.robots[robot].shown
        self._compiled = compiled
        self._spoken = spoken
        self._addressee = addressee

    def missing(self, parameter: CompiledParameter) -> Refusal:
        """A parameter has no value and no default."""
        if parameter.text:
            return self._refuse(f"write the {parameter.shown} after {self._compiled.spoken}.")
        what = f"{self._compiled.spoken} needs {_article(parameter.shown)}"
        if parameter.words is not None:
            choices = tuple(dict.fromkeys(parameter.words.values()))
            offers = [self._command(extra=choice.replace("_", " ")) for choice in choices]
            return self._refuse(f"{what}: {listed(_few(choices))}.", offers)
        low, high = (
            show_bound(parameter.low, parameter.high, parameter.unit, upper=upper)
            for upper in (False, True)
        )
        return self._refuse(
            f"{what}, from {low} to {high} {parameter.unit.symbol}".rstrip() + ".",
            [self._command(extra=said) for said in self._usual(parameter)],
        )

    def _usual(self, parameter: CompiledParameter) -> list[str]:
        """Return values for a number as they are said; by name where the unit says too little."""
        unit = parameter.unit
        alike = [p for p in self._compiled.numbers if p.unit.dimension == unit.dimension]
        name = "" if unit.dimension and len(alike) == 1 else f"{parameter.name}="
        return [f"{name}{value} {unit.symbol}".rstrip() for value in usual_values(parameter)]

    def to(self, at: int, given: Mapping[str, Argument]) -> Refusal:
        """The value at a place could not be used after those that are given."""
        value = self._spoken[at]
        if not value.name:
            return self._to_unnamed(at, value, given)
        parameter = self._compiled.by_name.get(value.name)
        if parameter is None:
            return self._unknown_parameter(at, value)
        if parameter.name in given:
            return self._refuse(f"{parameter.shown} is given twice. {_NOTHING_DONE}")
        return self._to_number(at, value, parameter)

    # ---- values without a name ----

    def _to_unnamed(self, at: int, value: Spoken, given: Mapping[str, Argument]) -> Refusal:
        if value.number is None:
            return self._unknown_word(at, value)
        unit = self._units.find(value.word) if value.word else None
        if value.word and unit is None:
            return self._unknown_unit(at, value)
        fitting = [
            p for p in self._compiled.numbers if unit is None or p.unit.dimension == unit.dimension
        ]
        free = [p for p in fitting if p.name not in given]
        if free:
            return self._to_number(at, value, free[0])
        if fitting or not self._compiled.numbers or unit is None:
            return self._no_place(value)
        return self._wrong_dimension(value, unit, self._compiled.numbers)

    def _no_place(self, value: Spoken) -> Refusal:
        skill, said = self._compiled.spoken, _said(value)
        if not self._compiled.numbers:
            return self._refuse(f"{skill} takes no number, so {said} has no place. {_NOTHING_DONE}")
        names = tuple(p.shown for p in self._compiled.numbers)
        return self._refuse(
            f"{skill} takes {_count(len(names))}, {listed(_few(names), 'and')}; "
            f"{said} is one too many. {_NOTHING_DONE}"
        )

    def _unknown_word(self, at: int, value: Spoken) -> Refusal:
        word = value.word
        knowing = [p for p in self._compiled.choices if p.words and word in p.words]
        if knowing:
            return self._refuse(f"{knowing[0].shown} is given twice. {_NOTHING_DONE}")
        return self._guess(at, word, chain(self._compiled.words, self._compiled.by_name))

    def _unknown_unit(self, at: int, value: Spoken) -> Refusal:
        dimensions = dict.fromkeys(p.unit.dimension for p in self._compiled.numbers)
        units = chain.from_iterable(self._units.of(d) for d in dimensions if d)
        return self._guess(at, value.word, chain(self._compiled.words, units))

    def _guess(self, at: int, word: str, candidates: chain[str]) -> Refusal:
        if any(value.word == "stop" for value in self._spoken):
            stops = [f"stop {self._addressee}", "stop"]
            return self._refuse(f"to stop, send stop in a line of its own. {_NOTHING_DONE}", stops)
        close = did_you_mean(word, candidates)
        sentence = f"{self._compiled.spoken} does not know {quote(word)}."
        if not close:
            return self._refuse(f"{sentence} {_NOTHING_DONE}")
        value = self._spoken[at]
        offers = [self._command(at, Spoken(value.name, value.number, other)) for other in close]
        return self._refuse(f"{sentence} Did you mean {listed(close)}?", offers)

    def _unknown_parameter(self, at: int, value: Spoken) -> Refusal:
        names = tuple(p.name for p in self._compiled.parameters)
        close = did_you_mean(value.name, names)
        sentence = f"{self._compiled.spoken} has no {quote(value.name)}."
        if close:
            offers = [self._command(at, Spoken(name, value.number, value.word)) for name in close]
            return self._refuse(f"{sentence} Did you mean {listed(close)}?", offers)
        takes = f"It takes {listed(_few(names), 'and')}." if names else "It takes nothing."
        return self._refuse(f"{sentence} {takes}")

    # ---- values that have a place ----

    def _to_number(self, at: int, value: Spoken, parameter: CompiledParameter) -> Refusal:
        """Say what is wrong with a value for a parameter."""
        if value.number is None:
            return self._wrong_word(at, value, parameter)
        if not parameter.is_number:
            return self._not_a_word(at, value, parameter)
        unit = self._units.find(value.word) if value.word else parameter.unit
        if unit is None:
            return self._unknown_unit(at, value)
        if unit.dimension != parameter.unit.dimension:
            return self._wrong_dimension(value, unit, (parameter,))
        if not isfinite(value.number * unit.factor + unit.offset):
            return self._refuse(f"{parameter.shown} takes a finite number. {_NOTHING_DONE}")
        return self._out_of_bounds(at, value, parameter, unit)

    def _wrong_word(self, at: int, value: Spoken, parameter: CompiledParameter) -> Refusal:
        if not value.word:
            return self._refuse(f"{parameter.shown} has no value. {_NOTHING_DONE}")
        if parameter.is_number:
            return self._refuse(
                f"{parameter.shown} takes a number, not {quote(value.word)}. {_NOTHING_DONE}"
            )
        return self._not_a_word(at, value, parameter)

    def _not_a_word(self, at: int, value: Spoken, parameter: CompiledParameter) -> Refusal:
        if parameter.words is None:
            return self._refuse(f"{parameter.shown} is empty. {_NOTHING_DONE}")
        choices = tuple(dict.fromkeys(parameter.words.values()))
        close = did_you_mean(value.word, parameter.words) if value.number is None else ()
        offers = [self._command(at, Spoken(value.name, None, word)) for word in close or choices]
        return self._refuse(
            f"{parameter.shown} is one of {listed(_few(choices))}, not {_said(value)}.", offers
        )

    def _wrong_dimension(
        self, value: Spoken, unit: Unit, parameters: tuple[CompiledParameter, ...]
    ) -> Refusal:
        wanted = dict.fromkeys(
            f"{_article(p.unit.dimension)} ({p.unit.symbol})"
            if p.unit.dimension
            else "a plain number"
            for p in parameters
        )
        taker = parameters[0].shown if len(parameters) == 1 else self._compiled.spoken
        return self._refuse(
            f"{_said(value)} is {_article(unit.dimension)}; {taker} takes "
            f"{listed(_few(tuple(wanted)))}. {_NOTHING_DONE}"
        )

    def _out_of_bounds(
        self, at: int, value: Spoken, parameter: CompiledParameter, unit: Unit
    ) -> Refusal:
        si = (value.number or 0.0) * unit.factor + unit.offset
        upper = si > parameter.high
        if parameter.low <= si <= parameter.high:
            return self._refuse(
                f"{parameter.shown} must be a whole number, not {_said(value)}. {_NOTHING_DONE}"
            )
        subject = parameter.shown
        if parameter.name in _EXTENTS:
            subject = f"one {self._compiled.spoken}"
        if si < 0 <= parameter.low:
            return self._refuse(
                f"{parameter.shown} cannot be negative. {_NOTHING_DONE}", kind=OutOfBounds
            )
        bound = show_bound(parameter.low, parameter.high, unit, upper=upper)
        offer = self._command(at, Spoken(value.name, float(bound), value.word or unit.symbol))
        limit = "may be at most" if upper else "must be at least"
        return self._refuse(
            f"{subject} {limit} {bound} {unit.symbol}".rstrip() + f". {_NOTHING_DONE}",
            [offer],
            kind=OutOfBounds,
        )

    # ---- sentences and commands ----

    def _refuse(
        self,
        sentence: str,
        offers: list[str] | None = None,
        *,
        kind: type[NotUnderstood | OutOfBounds] = NotUnderstood,
    ) -> Refusal:
        return kind(f"{self._robot}: {sentence}", offers=tuple(offers or ())[:MOST_OFFERS])

    def _command(self, at: int = -1, instead: Spoken | None = None, extra: str = "") -> str:
        """Return the command with another value at one place, or with one more word."""
        values = [
            instead if instead is not None and place == at else value
            for place, value in enumerate(self._spoken)
        ]
        parts = [self._addressee, self._compiled.spoken, *map(_typed, values), extra]
        return " ".join(part for part in parts if part)


def _typed(value: Spoken) -> str:
    """Return a value as a person would type it."""
    name = f"{value.name}=" if value.name else ""
    if value.number is None:
        return f"{name}{value.word}"
    return f"{name}{value.number:.12g} {value.word}".rstrip()


def _said(value: Spoken) -> str:
    if value.number is None:
        return quote(value.word)
    return f"{show_number(value.number)} {value.word[:16]}".rstrip()


def _article(noun: str) -> str:
    return f"an {noun}" if noun[:1] in "aeiou" else f"a {noun}"


def _count(number: int) -> str:
    return "one number" if number == 1 else f"{number} numbers"


def _few(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return at most eight of the words, so that a sentence stays one."""
    return words if len(words) <= 8 else (*words[:7], "others")  # noqa: PLR2004
