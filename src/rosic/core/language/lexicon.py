"""What people write in a language for what profiles and ROSIC itself call in one word.

A lexicon is a file that a translator edits (``locale/de/lexicon.toml``, next to the catalogue of
sentences). All of them are compiled once into a `Phrasebook`. Nothing here is guessed from: a line
acts only if every one of its words stands in one lexicon, in the profile, or is a number.
"""

from __future__ import annotations

import re
import unicodedata
from enum import Enum
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.core.language.cancel_detection import is_cancel_word
from rosic.core.language.sanitise import normalised, quote
from rosic.core.language.stop_detection import is_stop_word
from rosic.core.language.suggestions import distance

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

# ---- the words of a line ----

THEN: Final = ";"
"""What a full stop or a semicolon between two clauses becomes."""

_LOOSE: Final = '¿¡"\u201c\u201d\u201e\u201a\u2018\u2019«»「」『』…'
_TRAILING: Final = ",.;:!?،。、"
# Pictures that only say how somebody feels, and what joins and colours them. Any other may say
# something of the line: an arrow, a cross, a thinking face.
_PICTURE: Final = re.compile(
    "[\u2600\u2615\u263a\u2728\u2764\ufe0f\u200d\U0001f308\U0001f31e\U0001f44b\U0001f44d\U0001f493-\U0001f49f"
    "\U0001f389\U0001f3fb-\U0001f3ff\U0001f600-\U0001f60e\U0001f642\U0001f64f\U0001f916\U0001f970]"
)
_QUESTIONS: Final = frozenset("?\uff1f\u061f")
_QUOTES: Final = frozenset('"“”„«»「」『』')
# A script without blanks between its words: each of its signs is a word.
_HAN: Final = "\u2e80-\u2fdf\u3005\u3007\u3040-\u30ff\u3400-\u9fff\uf900-\ufaff"
_WORDS: Final = re.compile(rf"[{_HAN}]|[=;]|[^\s=;{_HAN}]+")
_ELIDED: Final = re.compile(r"(?<![\w'])(jusqu|qu|[cdjlmnst])'(?=\w)", re.IGNORECASE)
_ELISION: Final = re.compile(r"(jusqu|qu|[cdjlmnst])'", re.IGNORECASE)
_OPENING: Final = re.compile(r"\s*[^\W\d_]+\s*[,!.]\s")
_HYPHEN: Final = re.compile(r"(?<=[^\W\d_])-(?=[^\W\d_])")
_APOSTROPHES: Final = str.maketrans(
    {"\u2019": "'", "\u2018": "'", "`": "'", "\u00b4": "'", "\u2212": "-"}
)


class SpokenLine(NamedTuple):
    """The words of a line, as a lexicon has them.

    Attributes:
        words: In small letters, without what parts sentences; each sign of a script that has no
            blanks is one.
        raw: The same as typed: of a unit the case may matter.
        asks: It ends with a question mark.
        answers: Words follow a question in it: ``1 m? no``.
        quotes: It repeats what somebody said, or holds a sign that numbers do not have in words.
        opens: Its first word stands by itself before a comma: ``right, move 1 m``.
    """

    words: tuple[str, ...]
    raw: tuple[str, ...]
    asks: bool
    answers: bool
    quotes: bool
    opens: bool


def spoken_line(text: str) -> SpokenLine:
    """Return the words of a line. Takes time linear in it."""
    asked = max(map(text.rfind, _QUESTIONS))
    answers = any(letter.isalnum() for letter in text[asked + 1 :]) if asked >= 0 else False
    quotes = not _QUOTES.isdisjoint(text) or any(
        sign.isnumeric()
        and not sign.isdecimal()
        and unicodedata.category(sign) == "No"
        and unicodedata.numeric(sign) >= 1
        for sign in text
    )
    text = normalised(text).translate(_APOSTROPHES).replace("_", " ")
    text = _HYPHEN.sub(" ", _ELIDED.sub(r"\1' ", text))
    if not text.isascii():
        text = _PICTURE.sub(" ", text)
    words: list[str] = []
    for word in _WORDS.findall(text):
        whole = word == THEN or _ELISION.fullmatch(word)
        bare = word if whole else word.lstrip(_LOOSE).rstrip(_LOOSE + _TRAILING)
        if bare:
            words.append(bare)
        if word[-1] in ".。" and words and words[-1] != THEN:
            words.append(THEN)
    while words and words[-1] == THEN:
        words.pop()
    low = tuple([word.casefold() for word in words])
    opens = bool(_OPENING.match(text))
    return SpokenLine(low, tuple(words), asked >= 0, answers, quotes, opens)


def phrase_key(text: str) -> str:
    """Return a phrase as it is looked up: its words, with single blanks."""
    return " ".join(spoken_line(text).words)


def without_accents(text: str) -> str:
    """Return a phrase as people type it who leave accents out."""
    if text.isascii():
        return text
    parts = unicodedata.normalize("NFD", text)
    return unicodedata.normalize("NFC", "".join([c for c in parts if not unicodedata.combining(c)]))


# ---- what a phrase means ----


class SenseKind(Enum):
    """What sort of thing a phrase says."""

    __hash__ = object.__hash__

    SKILL = "skill"
    """A skill, by the name that profiles use for it."""
    VERB = "verb"
    """Moves in a way that the rest of the line says; by itself, the skill it names."""
    CHOICE = "choice"
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
    VAGUE = "vague"
    QUESTION = "question"
    MANNER = "manner"
    OWN_SKILL = "own skill"
    """A skill of this robot, by its id."""
    OWN_PARAMETER = "own parameter"
    OWN_CHOICE = "own choice"
    """A choice of this robot, as its profile spells it."""


class Sense(NamedTuple):
    """One meaning of a phrase."""

    kind: SenseKind
    value: str


CONTENT: Final = frozenset(
    {SenseKind.SKILL, SenseKind.CHOICE, SenseKind.UNIT, SenseKind.NUMBER, SenseKind.AMOUNT}
)
"""What an order is made of: a phrase may mean only one of them in all languages together."""

# Of one phrase with these two senses each reads as the line needs it.
_TOGETHER: Final = frozenset({SenseKind.SKILL, SenseKind.CHOICE, SenseKind.VERB})


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
        before_number: Change nothing before a number; elsewhere they mean what they mean.
        request: Make an order of what looks like a question.
        then: Part what is to be done one after the other.
    """

    nothing: tuple[str, ...] = ()
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
        blocked: By what makes an order no order: negation, condition, report, alternative.
        times: By the word that the grammar has for a time or a part of one.
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
    """

    tables: tuple[LexiconTable, ...]
    kinds: dict[str, tuple[str, ...]]


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


def compile_lexicons(lexicons: Mapping[str, Lexicon]) -> Phrasebook:
    """Compile the lexicons of all languages, and check them against each other.

    Args:
        lexicons: By the language's code.

    Raises:
        ValueError: A phrase means two things, in one language or in two, or it stops or cancels.
            The sentence names the phrase, and the languages.
    """
    tables = tuple([_table(language, lexicon) for language, lexicon in lexicons.items()])
    _check_against_each_other(tables)
    kinds: dict[str, dict[str, None]] = {}
    for lexicon in lexicons.values():
        for skill, phrases in lexicon.kinds.items():
            kinds.setdefault(skill, {}).update(dict.fromkeys(map(phrase_key, phrases)))
    return Phrasebook(tables, {skill: tuple(names) for skill, names in kinds.items()})


NO_PHRASES: Final = Phrasebook((), {})
"""Where only the words of the grammar and of profiles are read."""


def _table(language: str, lexicon: Lexicon) -> LexiconTable:
    senses: dict[str, dict[Sense, None]] = {}
    gapped: dict[str, list[GappedPhrase]] = {}
    for phrase, several in _said(lexicon):
        if GAP in phrase:
            parts = tuple([spoken_line(part).words for part in phrase.split(GAP)])
            if not all(parts):
                raise ValueError(f"{language}: {quote(phrase)} has nothing before or after its gap")
            gapped.setdefault(parts[0][0], []).append(GappedPhrase(parts, several))
        else:
            key = phrase_key(phrase)
            _check_phrase(language, phrase, key, several[0])
            senses.setdefault(key, {}).update(dict.fromkeys(several))
    return LexiconTable(
        language,
        {key: tuple(several) for key, several in senses.items()},
        longest_by_first_word(senses),
        {first: tuple(rows) for first, rows in gapped.items()},
        lexicon.numerals.positional,
        _slips(senses),
    )


def _said(lexicon: Lexicon) -> Iterator[tuple[str, tuple[Sense, ...]]]:
    """Yield each phrase, with and without its accents, and its senses.

    What is written without its accents takes no other word's meaning away: no denial becomes an
    order, and no order a denial.
    """
    meanings = list(_meanings(lexicon))
    blocked = {phrase_key(text) for text, meant in meanings if meant[0].kind is SenseKind.BLOCKED}
    ordered = {
        phrase_key(phrase)
        for text, several in meanings
        if several[0].kind in CONTENT
        for phrase in _spellings(text)
    }
    for text, several in meanings:
        others = ordered if several[0].kind is SenseKind.BLOCKED else blocked
        for phrase in _spellings(text):
            if phrase == text or phrase_key(phrase) not in others:
                yield phrase, several


def _slips(senses: Mapping[str, Iterable[Sense]]) -> dict[str, tuple[str, ...]]:
    """Return the words of orders by what a letter left out makes of them."""
    slips: dict[str, list[str]] = {}
    for key, several in senses.items():
        orders = not CONTENT.isdisjoint(sense.kind for sense in several)
        if orders and " " not in key and len(key) >= SHORTEST_MENDED:
            for slip in (key, *left_out(key)):
                slips.setdefault(slip, []).append(key)
    return {slip: tuple(words) for slip, words in slips.items()}


def _spellings(text: str) -> Iterable[str]:
    """Return a phrase, and how it is typed without its accents."""
    return dict.fromkeys((text, without_accents(text)))


def _meanings(lexicon: Lexicon) -> Iterator[tuple[str, tuple[Sense, ...]]]:
    """Yield each phrase of a lexicon with what it means."""
    kinds = (
        (SenseKind.SKILL, lexicon.skills),
        (SenseKind.VERB, lexicon.verbs),
        (SenseKind.CHOICE, lexicon.choices),
        (SenseKind.PARAMETER, lexicon.parameters),
        (SenseKind.UNIT, lexicon.units),
        (SenseKind.NUMBER, {**lexicon.numbers, **_compounds(lexicon)}),
        (SenseKind.AMOUNT, lexicon.amounts),
        (SenseKind.KIND, lexicon.kinds),
        (SenseKind.KINDS, lexicon.plurals),
        (SenseKind.BLOCKED, lexicon.blocked),
        (SenseKind.TIME, lexicon.times),
        (SenseKind.VAGUE, lexicon.vague),
        (SenseKind.QUESTION, lexicon.questions),
        (SenseKind.MANNER, lexicon.manners),
    )
    for kind, table in kinds:
        for meant, phrases in table.items():
            for phrase in phrases:
                yield phrase, (Sense(kind, meant),)
    for meant, phrases in lexicon.combined.items():
        skill, _, choice = meant.partition(" ")
        for phrase in phrases:
            yield phrase, (Sense(SenseKind.SKILL, skill), Sense(SenseKind.CHOICE, choice))
    numerals, words = lexicon.numerals, lexicon.words
    for kind, phrases in (
        (SenseKind.HALF_MORE, numerals.half_more),
        (SenseKind.POINT, numerals.point),
        (SenseKind.JOINER, numerals.joiner),
        (SenseKind.MINUS, numerals.minus),
        (SenseKind.COUNTER, numerals.counters),
        (SenseKind.ONE, numerals.one),
        (SenseKind.NOTHING, words.nothing),
        (SenseKind.BEFORE_NUMBER, words.before_number),
        (SenseKind.REQUEST, words.request),
        (SenseKind.THEN, words.then),
    ):
        for phrase in phrases:
            yield phrase, (Sense(kind, ""),)


def _compounds(lexicon: Lexicon) -> dict[str, tuple[str, ...]]:
    """Return what is written in one word for 21 to 99."""
    if not lexicon.numerals.compound:
        return {}
    return {
        f"{ten + unit}.": tuple(
            [
                lexicon.numerals.compound.format(one=one, ten=word)
                for word in lexicon.numbers.get(str(ten), ())
            ]
        )
        for ten in range(20, 100, 10)
        for unit, one in enumerate(lexicon.numerals.units, 1)
    }


def _check_phrase(language: str, phrase: str, key: str, sense: Sense) -> None:
    words = key.split(" ")
    if not key:
        raise ValueError(f"{language}: an empty phrase stands for {sense.value}")
    kinds = {SenseKind.BLOCKED, SenseKind.MANNER, SenseKind.QUESTION, SenseKind.NOTHING}
    if sense.kind in kinds or len(words) > 1:
        return
    if is_stop_word(key) or is_cancel_word(key):
        raise ValueError(f"{language}: {quote(phrase)} stops a robot or ends its order everywhere")


def _check_against_each_other(tables: Iterable[LexiconTable]) -> None:
    meant: dict[str, tuple[str, frozenset[Sense]]] = {}
    for table in tables:
        for key, senses in table.senses.items():
            content = frozenset(sense for sense in senses if sense.kind in CONTENT)
            if not content:
                continue
            language, other = meant.setdefault(key, (table.language, content))
            if other.isdisjoint(content) and not _may_stand_together(content | other):
                shown = sorted(f"{sense.kind.value} {sense.value}" for sense in content | other)
                raise ValueError(
                    f"{quote(key)} means {' and '.join(shown)}, in {language} and {table.language}"
                )


def _may_stand_together(senses: frozenset[Sense]) -> bool:
    kinds = {sense.kind for sense in senses}
    return kinds <= _TOGETHER and len(kinds) > 1
