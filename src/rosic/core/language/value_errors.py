"""Why a value cannot be used, in one sentence, and what to say instead."""

from __future__ import annotations

from itertools import chain
from math import isfinite
from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said, titled
from rosic.core.language.common_names import known_name
from rosic.core.language.formatting import show_bound, show_number, shown_bound, usual_values
from rosic.core.language.sanitise import quote
from rosic.core.language.skill_values import fits, place_value
from rosic.core.language.suggestions import AND, did_you_mean, listed, one_each
from rosic.core.language.values import AmbiguousNumber, ValueReader
from rosic.core.order import SpokenValue
from rosic.errors import NotUnderstood, OutOfBounds, Refusal

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.language.numbers import Unit
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument


# ---- what numbers measure ----

_DIMENSIONS = {
    "length": said("a length"),
    "angle": said("an angle"),
    "time": said("a time"),
    "speed": said("a speed"),
    "turning speed": said("a turning speed"),
    "acceleration": said("an acceleration"),
    "turning acceleration": said("a turning acceleration"),
    "force": said("a force"),
    "torque": said("a torque"),
    "mass": said("a mass"),
    "share": said("a share"),
    "frequency": said("a frequency"),
    "voltage": said("a voltage"),
    "current": said("a current"),
    "power": said("a power"),
    "energy": said("an energy"),
    "pressure": said("a pressure"),
    "volume": said("a volume"),
    "area": said("an area"),
    "temperature": said("a temperature"),
}


def article(noun: str) -> str:
    """Put the article before a noun."""
    return said("an {noun}", noun=noun) if noun[:1] in "aeiou" else said("a {noun}", noun=noun)


def kind_of(dimension: str) -> str:
    """Return what a unit measures, as a thing: ``a length``."""
    return _DIMENSIONS.get(dimension) or article(dimension)


def kinds(parameters: tuple[CompiledParameter, ...]) -> tuple[str, ...]:
    """Return what numbers measure, each once: ``a length (m)``."""
    kinds = dict.fromkeys(
        said("{dimension} ({symbol})", dimension=kind_of(p.unit.dimension), symbol=p.unit.symbol)
        if p.unit.dimension
        else said("a plain number")
        for p in parameters
    )
    return tuple(kinds)


# ---- why a value cannot be used ----

MOST_OFFERS = 4
# Parameters that say how much of the skill itself: "one move may be at most 5 m".
_EXTENTS = frozenset({"angle", "distance", "duration"})
_NOTHING_DONE = said("Nothing was done.")
# A bound whose number in somebody's unit lies beyond these is said in the unit of the profile.
LEAST_SAID, MOST_SAID = 0.1, 10_000.0


class ValueErrorBuilder:
    """Finds out what is wrong with values that could not be bound."""

    __slots__ = ("_addressee", "_compiled", "_phrases", "_robot", "_skill", "_spoken", "_units")

    def __init__(
        self,
        vocabulary: Vocabulary,
        robot: RobotId,
        compiled: CompiledSkill,
        spoken: tuple[SpokenValue, ...],
        addressee: str,
    ) -> None:
        self._units = vocabulary.units
        self._phrases = vocabulary.phrases
        self._robot = vocabulary.robots[robot].shown
        self._compiled = compiled
        self._skill = titled(compiled.spoken, compiled.skill.titles)
        self._spoken = spoken
        self._addressee = addressee

    def missing(self, parameter: CompiledParameter) -> Refusal:
        """A parameter has no value and no default."""
        if parameter.text:
            return self._refuse(
                said(
                    "write the {shown} after {spoken}.",
                    shown=parameter.shown,
                    spoken=self._skill,
                )
            )
        what = said(
            "{spoken} needs {article}",
            spoken=self._skill,
            article=article(parameter.shown),
        )
        if parameter.words is not None:
            choices = tuple(dict.fromkeys(parameter.words.values()))
            offers = [self._command(extra=choice.replace("_", " ")) for choice in choices]
            names = listed(_few(_shown(choices)))
            return self._refuse(joined("", (what, ": ", names, ".")), offers)
        low, high = (
            shown_bound(parameter.low, parameter.high, parameter.unit, upper=upper, with_unit=upper)
            for upper in (False, True)
        )
        return self._refuse(
            said("{what}, from {low} to {high}.", what=what, low=low, high=high),
            [self._command(extra=given) for given in self._usual(parameter)],
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
            return self._twice(parameter)
        return self._to_number(at, value, parameter)

    def _twice(self, parameter: CompiledParameter) -> Refusal:
        return self._refuse(
            said("{shown} is given twice. Nothing was done.", shown=parameter.shown)
        )

    # ---- values without a name ----

    def _to_unnamed(self, at: int, value: SpokenValue, given: Mapping[str, Argument]) -> Refusal:
        if value.number is None:
            return self._unknown_word(at, value, given)
        unit = self._units.find(value.word) if value.word else None
        if value.word and unit is None:
            return self._unknown_unit(at, value)
        fitting = [
            p for p in self._compiled.numbers if unit is None or p.unit.dimension == unit.dimension
        ]
        free = [p for p in fitting if p.name not in given]
        if free:
            return self._to_number(at, value, free[0])
        if fitting and unit is not None:
            return self._twice(fitting[0])
        if not self._compiled.numbers or unit is None:
            return self._no_place(value)
        return self._wrong_dimension(value, unit, self._compiled.numbers)

    def _no_place(self, value: SpokenValue) -> Refusal:
        skill, given = self._skill, _said(value)
        if not self._compiled.numbers:
            return self._refuse(
                said(
                    "{skill} takes no number, so {rest} has no place. Nothing was done.",
                    skill=skill,
                    rest=given,
                )
            )
        names = tuple(p.shown for p in self._compiled.numbers)
        return self._refuse(
            said(
                "{skill} takes {count}, {listed}; {rest} is one too many. Nothing was done.",
                skill=skill,
                count=_count(len(names)),
                listed=listed(_few(names), AND),
                rest=given,
            )
        )

    def _unknown_word(self, at: int, value: SpokenValue, given: Mapping[str, Argument]) -> Refusal:
        word = value.word
        knowing = [p for p in self._compiled.choices if p.words and word in p.words]
        if knowing:
            return self._twice(knowing[0])
        unsaid = [p.words for p in self._compiled.choices if p.words and p.name not in given]
        takes = _shown(dict.fromkeys(unsaid[0].values())) if unsaid else ()
        close = did_you_mean(word, chain(self._compiled.words, self._compiled.by_name))
        return self._guess(at, word, close, takes)

    def _unknown_unit(self, at: int, value: SpokenValue) -> Refusal:
        dimensions = dict.fromkeys(p.unit.dimension for p in self._compiled.numbers)
        # No other unit for a symbol that nobody knows: it would be another quantity.
        close = (
            *did_you_mean(value.word, self._compiled.words),
            *self._units.misspelt(value.word, dimensions),
        )
        return self._guess(at, value.word, close, kinds(self._compiled.numbers))

    def _guess(self, at: int, word: str, close: tuple[str, ...], takes: tuple[str, ...]) -> Refusal:
        if any(value.word == "stop" for value in self._spoken):
            stops = [f"stop {self._addressee}", "stop"]
            return self._refuse(
                said(
                    "to stop, send stop in a line of its own. Nothing was done.",
                ),
                stops,
            )
        sentence = said("{spoken} does not know {quote}.", spoken=self._skill, quote=quote(word))
        value = self._spoken[at]
        meanings = dict(item for p in self._compiled.choices for item in (p.words or {}).items())
        others = {
            other: SpokenValue(value.name, value.number, other)
            for other in one_each(close, meanings)
        }
        if (meant := self._meant(sentence, at, others)) is not None:
            return meant
        known = [said("It takes {listed}.", listed=listed(_few(takes)))] if takes else []
        return self._refuse(joined(" ", (sentence, *known, _NOTHING_DONE)), self._without_words())

    def _without_words(self) -> list[str]:
        """Return the commands that are left without the words that the skill does not know.

        None where such a word says that it is not to be done, or may be a choice that nobody knows,
        or where more than one value is missing then.
        """
        known = [v for v in self._spoken if v.number is not None or v.word in self._compiled.words]
        others = {value.word for value in self._spoken if value not in known}
        given: dict[str, Argument] = {}
        for value in known:
            placed = place_value(self._compiled, given, value, self._units)
            if placed is None:
                return []
            given[placed[0].name] = placed[1]
        if any(p.name not in given for p in self._compiled.choices):
            return []
        missing = [
            p for p in self._compiled.parameters if p.default is None and p.name not in given
        ]
        if len(missing) > 1 or any(self._phrases.blocks(word) for word in others):
            return []
        said_so = " ".join(map(_typed, known))
        ends = self._usual(missing[0]) if missing and missing[0].is_number else [""]
        lines = [" ".join(filter(None, (said_so, end))) for end in ends]
        named = (self._addressee, self._compiled.spoken)
        return [" ".join(filter(None, (*named, line))) for line in lines if not missing or line]

    def _meant(self, sentence: str, at: int, others: Mapping[str, SpokenValue]) -> Refusal | None:
        """Return the refusal that proposes something else at a place; None if nothing would do.

        Args:
            sentence: What is wrong.
            at: The place.
            others: What may have been meant, as it is said, and the value that it would be.
        """
        lines = {word: self._command(at, other) for word, other in others.items()}
        words = tuple([word for word, line in lines.items() if line])
        if not words:
            return None
        return self._refuse(
            said("{sentence} Did you mean {listed}?", sentence=sentence, listed=listed(words)),
            list(lines.values()),
        )

    def _unknown_parameter(self, at: int, value: SpokenValue) -> Refusal:
        names = tuple(p.name for p in self._compiled.parameters)
        close = did_you_mean(value.name, names)
        sentence = said("{spoken} has no {quote}.", spoken=self._skill, quote=quote(value.name))
        others = {name: SpokenValue(name, value.number, value.word) for name in close}
        if (meant := self._meant(sentence, at, others)) is not None:
            return meant
        takes = (
            said("It takes {listed}.", listed=listed(_few(_shown(names)), AND))
            if names
            else said("It takes nothing.")
        )
        return self._refuse(joined(" ", (sentence, takes)))

    # ---- values that have a place ----

    def _to_number(self, at: int, value: SpokenValue, parameter: CompiledParameter) -> Refusal:
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
        if not isfinite(unit.to_si(value.number)):
            return self._refuse(
                said(
                    "{shown} takes a finite number. Nothing was done.",
                    shown=parameter.shown,
                )
            )
        return self._out_of_bounds(at, value, parameter, unit)

    def _wrong_word(self, at: int, value: SpokenValue, parameter: CompiledParameter) -> Refusal:
        if not value.word:
            return self._refuse(
                said(
                    "{shown} has no value. Nothing was done.",
                    shown=parameter.shown,
                )
            )
        if parameter.is_number:
            return self._refuse(
                said(
                    "{shown} takes a number, not {quote}. Nothing was done.",
                    shown=parameter.shown,
                    quote=quote(value.word),
                )
            )
        return self._not_a_word(at, value, parameter)

    def _not_a_word(self, at: int, value: SpokenValue, parameter: CompiledParameter) -> Refusal:
        if parameter.words is None:
            return self._refuse(
                said(
                    "{shown} is empty. Nothing was done.",
                    shown=parameter.shown,
                )
            )
        choices = tuple(dict.fromkeys(parameter.words.values()))
        close = did_you_mean(value.word, parameter.words) if value.number is None else ()
        offers = [
            self._command(at, SpokenValue(value.name, None, word)) for word in close or choices
        ]
        return self._refuse(
            said(
                "{shown} is one of {listed}, not {rest}.",
                shown=parameter.shown,
                listed=listed(_few(_shown(choices))),
                rest=_said(value),
            ),
            offers,
        )

    def _wrong_dimension(
        self, value: SpokenValue, unit: Unit, parameters: tuple[CompiledParameter, ...]
    ) -> Refusal:
        taker = parameters[0].shown if len(parameters) == 1 else self._skill
        return self._refuse(
            said(
                "{rest} is {article}; {taker} takes {listed}. Nothing was done.",
                rest=_said(value),
                article=kind_of(unit.dimension),
                taker=taker,
                listed=listed(_few(kinds(parameters))),
            )
        )

    def _out_of_bounds(
        self, at: int, value: SpokenValue, parameter: CompiledParameter, unit: Unit
    ) -> Refusal:
        si = unit.to_si(value.number or 0.0)
        upper = si > parameter.high
        if parameter.low <= si <= parameter.high:
            return self._refuse(
                said(
                    "{shown} must be a whole number, not {rest}. Nothing was done.",
                    shown=parameter.shown,
                    rest=_said(value),
                )
            )
        subject = parameter.shown
        if parameter.name in _EXTENTS:
            subject = said("one {spoken}", spoken=self._skill)
        if si < 0 <= parameter.low:
            return self._refuse(
                said(
                    "{shown} cannot be negative. Nothing was done.",
                    shown=parameter.shown,
                ),
                kind=OutOfBounds,
            )
        word = value.word or unit.symbol
        bound = show_bound(parameter.low, parameter.high, unit, upper=upper)
        if unit != parameter.unit and not LEAST_SAID <= abs(float(bound)) <= MOST_SAID:
            # Nobody says 0.005 km.
            unit, word = parameter.unit, parameter.unit.symbol
            bound = show_bound(parameter.low, parameter.high, unit, upper=upper)
        offer = self._command(at, SpokenValue(value.name, float(bound), word))
        parts = {
            "subject": subject,
            "bound": shown_bound(parameter.low, parameter.high, unit, upper=upper),
        }
        limit = (
            said("{subject} may be at most {bound}. Nothing was done.", **parts)
            if upper
            else said("{subject} must be at least {bound}. Nothing was done.", **parts)
        )
        return self._refuse(
            limit,
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
        return kind(
            joined(": ", (self._robot, sentence)),
            offers=tuple(filter(None, offers or ()))[:MOST_OFFERS],
        )

    def _command(self, at: int = -1, instead: SpokenValue | None = None, extra: str = "") -> str:
        """Return the command with another value at one place, or with one more word.

        Empty where not every value of it has a place then: what would be refused is not offered.
        """
        values = [
            instead if instead is not None and place == at else value
            for place, value in enumerate(self._spoken)
        ]
        said_so = " ".join(filter(None, (*map(_typed, values), extra)))
        if not self._reads(said_so):
            return ""
        return " ".join(filter(None, (self._addressee, self._compiled.spoken, said_so)))

    def _reads(self, values: str) -> bool:
        """Whether values, typed so, would all find a place."""
        if self._compiled.text is not None:
            return True
        raw = values.replace("=", " = ").split()
        low = [word.casefold() for word in raw]
        try:
            spoken = ValueReader(raw, low, 0, self._compiled, self._units).read()
        except AmbiguousNumber:
            return False
        return fits(self._compiled, spoken, self._units)


def _typed(value: SpokenValue) -> str:
    """Return a value as a person would type it."""
    name = f"{value.name}=" if value.name else ""
    if value.number is None:
        return f"{name}{value.word}"
    return f"{name}{value.number:.12g} {value.word}".rstrip()


def _said(value: SpokenValue) -> str:
    if value.number is None:
        return quote(value.word)
    return f"{show_number(value.number)} {value.word[:16]}".rstrip()


def _shown(names: Iterable[str]) -> tuple[str, ...]:
    return tuple(map(known_name, names))


def _count(number: int) -> str:
    return said("one number") if number == 1 else said("{number} numbers", number=number)


def _few(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return at most eight of the words, so that a sentence stays one."""
    return words if len(words) <= 8 else (*words[:7], said("others"))  # noqa: PLR2004
