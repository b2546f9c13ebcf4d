"""From the files of all languages to what lines are read by, checked against each other."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.language.cancel_detection import is_cancel_word
from rosic.core.language.lexicon import (
    ARTICLE,
    CONTENT,
    GAP,
    NEGATION,
    OPENING,
    SHORTEST_MENDED,
    GappedPhrase,
    LexiconTable,
    Phrasebook,
    Sense,
    SenseKind,
    left_out,
    longest_by_first_word,
)
from rosic.core.language.line_words import phrase_key, spoken_line, without_accents
from rosic.core.language.sanitise import quote
from rosic.core.language.stop_detection import is_stop_word

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.core.language.lexicon import Lexicon

# Of one phrase with these two senses each reads as the line needs it.
_TOGETHER: Final = frozenset({SenseKind.SKILL, SenseKind.CHOICE, SenseKind.VERB})


def compile_lexicons(lexicons: Mapping[str, Lexicon]) -> Phrasebook:
    """Compile the lexicons of all languages, and check them against each other.

    Args:
        lexicons: By the language's code.

    Raises:
        ValueError: A phrase means two things, in one language or in two, or it stops or cancels.
            The sentence names the phrase, and the languages.
    """
    for language, lexicon in lexicons.items():
        _check_keys(language, lexicon)
        _check_questions(language, lexicons)
    tables = tuple([_table(language, lexicon) for language, lexicon in lexicons.items()])
    _check_against_each_other(tables)
    kinds: dict[str, dict[str, None]] = {}
    for lexicon in lexicons.values():
        for skill, phrases in lexicon.kinds.items():
            kinds.setdefault(skill, {}).update(dict.fromkeys(map(phrase_key, phrases)))
    denial = Sense(SenseKind.BLOCKED, NEGATION)
    minus = Sense(SenseKind.BEFORE_NUMBER, "")  # menos 90 grados
    denials = frozenset(
        key
        for table in tables
        for key, senses in table.senses.items()
        if denial in senses and minus not in senses
    )
    return Phrasebook(tables, {skill: tuple(names) for skill, names in kinds.items()}, denials)


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
        (SenseKind.PLACE, lexicon.places),
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
            both = (Sense(SenseKind.SKILL, skill), Sense(SenseKind.CHOICE, choice))
            yield phrase, (*both, Sense(SenseKind.COMBINED, choice))
    numerals, words = lexicon.numerals, lexicon.words
    for kind, phrases in (
        (SenseKind.HALF_MORE, numerals.half_more),
        (SenseKind.POINT, numerals.point),
        (SenseKind.JOINER, numerals.joiner),
        (SenseKind.MINUS, numerals.minus),
        (SenseKind.COUNTER, numerals.counters),
        (SenseKind.ONE, numerals.one),
        (SenseKind.NOTHING, words.nothing),
        (SenseKind.NOTHING, words.article),
        (SenseKind.BEFORE_NUMBER, words.before_number),
        (SenseKind.REQUEST, words.request),
        (SenseKind.THEN, words.then),
    ):
        for phrase in phrases:
            yield phrase, (Sense(kind, ARTICLE if phrases is words.article else ""),)


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


_KEYS: Final = {
    "places": frozenset({"keep", "to"}),
    "blocked": frozenset({NEGATION, OPENING, "condition", "report", "alternative"}),
    "manners": frozenset({"hello", "bye", "thanks", "praise", "never_mind"}),
    "vague": frozenset(
        ["little", "much", "faster", "slower", "more", "again", "other", "undo", "instead", "place"]
    ),
    "times": frozenset(
        [
            *[
                "at",
                "in",
                "every",
                "today",
                "tomorrow",
                "day",
                "noon",
                "oclock",
                "min",
                "h",
                "am",
                "pm",
            ],
            *["monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday"],
            *("half past", "half to", "quarter past", "quarter to"),
        ]
    ),
}
"""What may stand on the left of a section, where that is not for profiles to say."""


def _check_keys(language: str, lexicon: Lexicon) -> None:
    """See that what phrases stand for is something that lines are read by."""
    for section, known in _KEYS.items():
        for meant in getattr(lexicon, section).keys() - known:
            raise ValueError(
                f"{language}: [{section}] has no {quote(meant)}; it has {', '.join(sorted(known))}"
            )
    for number in (*lexicon.numbers, *[amount.partition(" ")[0] for amount in lexicon.amounts]):
        try:
            float(number)
        except ValueError:
            raise ValueError(f"{language}: {quote(number)} is no number, such as 0.5") from None
    for amount in lexicon.amounts:
        if not amount.partition(" ")[2]:
            raise ValueError(f"{language}: {quote(amount)} has no unit, as in 90 deg")
    try:
        lexicon.numerals.compound.format(one="", ten="")
    except (KeyError, IndexError, ValueError):
        wrong = quote(lexicon.numerals.compound)
        raise ValueError(
            f"{language}: compound is made of {{one}} and {{ten}}, not {wrong}"
        ) from None


def _check_questions(language: str, lexicons: Mapping[str, Lexicon]) -> None:
    """See that what is asked is something that is asked in another language as well, if there are.

    Most of it are commands, which are declared elsewhere.
    """
    others = {
        asked for other in lexicons if other != language for asked in lexicons[other].questions
    }
    for asked in lexicons[language].questions.keys() - others if others else ():
        raise ValueError(f"{language}: [questions] has {quote(asked)}, which no other language has")


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
