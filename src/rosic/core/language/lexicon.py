"""What people write in a language for what profiles and ROSIC itself call in one word.

A lexicon is a file that a translator edits (``locale/de/lexicon.toml``, next to the catalogue of
sentences). All of them are compiled once into a `Phrasebook`. Nothing here is guessed from: a line
acts only if every one of its words stands in one lexicon, in the profile, or is a number.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.language.suggestions import distance

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

# ---- what a phrase means ----


class SenseKind(Enum):
    """What sort of thing a phrase says."""

    __hash__ = object.__hash__

    SKILL = "skill"
    """A skill, by the name that profiles use for it."""
    VERB = "verb"
    """Moves in a way that the rest of the line says; by itself, the skill it names."""
    CHOICE = "choice"
    COMBINED = "combined"
    """The words say a skill and a choice in one, and mean nothing without the choice."""
    PARAMETER = "parameter"
    UNIT = "unit"
    NUMBER = "number"
    ONE = "one"
    """1 before a unit, else nothing."""
    HALF_MORE = "half more"
    POINT = "point"
    JOINER = "joiner"
    MINUS = "minus"
    COUNTER = "counter"
    AMOUNT = "amount"
    """A number with its unit: ``0.25 turn``."""
    KIND = "kind"
    """A robot that has a skill, and with ``all`` each of them."""
    KINDS = "kinds"
    """All robots that have a skill."""
    NOTHING = "nothing"
    BEFORE_NUMBER = "before number"
    REQUEST = "request"
    THEN = "then"
    BLOCKED = "blocked"
    """Whoever writes it gives no order: a denial, a condition, a report, an alternative."""
    TIME = "time"
    """When something is to be done."""
    PLACE = "place"
    """Beside the name of a place: that it is kept here, or that somebody goes there."""
    VAGUE = "vague"
    QUESTION = "question"
    MANNER = "manner"
    OWN_SKILL = "own skill"
    """A skill of this robot, by its id."""
    OWN_PARAMETER = "own parameter"
    OWN_CHOICE = "own choice"
    """A choice of this robot, as its profile spells it."""
    OWN_PLACE = "own place"
    """A place that people have kept for this robot."""


ARTICLE: Final = "article"
NEGATION: Final = "negation"
OPENING: Final = "opening"
"""Blocks only as the first word of a line: ``se cf1 pousar``."""


class Sense(NamedTuple):
    """One meaning of a phrase."""

    kind: SenseKind
    value: str


CONTENT: Final = frozenset(
    {SenseKind.SKILL, SenseKind.CHOICE, SenseKind.UNIT, SenseKind.NUMBER, SenseKind.AMOUNT}
)
"""What an order is made of: a phrase may mean only one of them in all languages together."""


class Numerals(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How numbers are put together in a language.

    Attributes:
        compound: How a ten and a unit become one word: ``{one}und{ten}``.
        units: The words for 1 to 9 in it.
        positional: Tens and hundreds follow what counts them, as in Chinese.
        joiner: Stands between the parts of a number.
        minus: Stands before a number below zero.
        half_more: Adds one half to the number before it, or to its unit.
        point: Stands before decimals.
        one: Is 1 before a unit, and nothing elsewhere.
        counters: Stand between a number and what is counted.
    """

    compound: str = ""
    units: tuple[str, ...] = ()
    positional: bool = False
    joiner: tuple[str, ...] = ()
    minus: tuple[str, ...] = ()
    half_more: tuple[str, ...] = ()
    point: tuple[str, ...] = ()
    one: tuple[str, ...] = ()
    counters: tuple[str, ...] = ()


class FunctionWords(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Words that say nothing about a robot.

    Attributes:
        nothing: Change nothing in an order.
        article: Makes a thing of a skill at the beginning of a line: ``the launch``.
        before_number: Change nothing before a number; elsewhere they mean what they mean.
        request: Make an order of what looks like a question.
        then: Part what is to be done one after the other.
    """

    nothing: tuple[str, ...] = ()
    article: tuple[str, ...] = ()
    before_number: tuple[str, ...] = ()
    request: tuple[str, ...] = ()
    then: tuple[str, ...] = ()


_Table = dict[str, tuple[str, ...]]


class Lexicon(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """One language, as its file has it: what is meant, and what is written for it.

    Attributes:
        combined: A skill and a choice in one: ``move back`` = ``recule``.
        amounts: A number and its unit in one: ``90 deg`` = ``quarter turn``.
        kinds: One robot, by the skill that robots of that kind have; ``all``.
        plurals: As ``kinds``, for all of them.
        blocked: By what makes an order no order: negation, condition, report, alternative; opening
            does so at the beginning of a line alone.
        times: By the word that the grammar has for a time or a part of one.
        places: What is said before the name of a place: ``keep``, the robot is there; ``to``, it
            goes there.
        questions: By what is answered.
    """

    skills: _Table = {}
    verbs: _Table = {}
    combined: _Table = {}
    choices: _Table = {}
    parameters: _Table = {}
    units: _Table = {}
    numbers: _Table = {}
    numerals: Numerals = Numerals()
    amounts: _Table = {}
    kinds: _Table = {}
    plurals: _Table = {}
    words: FunctionWords = FunctionWords()
    blocked: _Table = {}
    times: _Table = {}
    places: _Table = {}
    vague: _Table = {}
    questions: _Table = {}
    manners: _Table = {}


# ---- compiled ----


class GappedPhrase(NamedTuple):
    """A phrase with other words between its parts: ``pick … up``."""

    parts: tuple[tuple[str, ...], ...]
    senses: tuple[Sense, ...]


class LexiconTable(NamedTuple):
    """One language, compiled.

    Attributes:
        language: Its code.
        senses: Phrase to what it may mean.
        longest: First word to the number of words in the longest phrase.
        gapped: First word to the phrases with a gap.
        positional: As `Numerals.positional`.
        slips: Phrases of one word with a letter left out, to those words; for typing errors.
    """

    language: str
    senses: dict[str, tuple[Sense, ...]]
    longest: dict[str, int]
    gapped: dict[str, tuple[GappedPhrase, ...]]
    positional: bool
    slips: dict[str, tuple[str, ...]]

    def misspelt(self, word: str) -> tuple[str, ...]:
        """Return the words that one slip of a finger made this one of."""
        if len(word) < SHORTEST_MENDED or word in self.senses:
            return ()
        found = dict.fromkeys(
            known for left in (word, *left_out(word)) for known in self.slips.get(left, ())
        )
        return tuple([known for known in found if distance(word, known, 1) <= 1])


SHORTEST_MENDED: Final = 4
LONGEST_MENDED: Final = 24
GAP: Final = "…"


class Phrasebook(NamedTuple):
    """All languages.

    Attributes:
        tables: One for each.
        kinds: What a robot of a kind is called in any of them, by the skill it has.
        denials: Words that deny in one of them, so that no line with one acts in any other: ``no``.
    """

    tables: tuple[LexiconTable, ...]
    kinds: dict[str, tuple[str, ...]]
    denials: frozenset[str] = frozenset()

    def blocks(self, word: str) -> bool:
        """Whether a word makes a line no order, in any language."""
        return any(
            sense.kind is SenseKind.BLOCKED
            for table in self.tables
            for sense in table.senses.get(word, ())
        )


def longest_by_first_word(phrases: Iterable[str]) -> dict[str, int]:
    """Return, for each first word, how many words the longest phrase has."""
    longest: dict[str, int] = {}
    for phrase in phrases:
        words = phrase.split()
        longest[words[0]] = max(longest.get(words[0], 0), len(words))
    return longest


def left_out(word: str) -> Iterator[str]:
    """Yield a word with each of its letters left out in turn."""
    for at in range(min(len(word), LONGEST_MENDED)):
        yield word[:at] + word[at + 1 :]


NO_PHRASES: Final = Phrasebook((), {})
"""Where only the words of the grammar and of profiles are read."""
