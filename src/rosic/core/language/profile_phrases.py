"""Whether what a profile lets be said in a language, and takes for a reverse, makes sense there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.language.cancel_detection import is_cancel_word
from rosic.core.language.lexicon import CONTENT, Sense, SenseKind
from rosic.core.language.line_words import phrase_key
from rosic.core.language.numbers import read_numeral
from rosic.core.language.phrase_words import phrases_of
from rosic.core.language.sanitise import quote
from rosic.core.language.stop_detection import is_stop_word
from rosic.core.language.wait_detection import hears_wait
from rosic.core.robot.skill import LANGUAGE_CODE

if TYPE_CHECKING:
    from rosic.core.language.compiled import CompiledRobot, CompiledSkill
    from rosic.core.language.lexicon import LexiconTable, Phrasebook
    from rosic.core.language.phrase_words import ProfilePhrase

_NO_ORDER: Final = frozenset(
    {
        *(SenseKind.BLOCKED, SenseKind.NUMBER, SenseKind.NOTHING, SenseKind.REQUEST),
        *(SenseKind.THEN, SenseKind.ONE, SenseKind.MINUS, SenseKind.VAGUE, SenseKind.TIME),
    }
)


def _is_meant_by(said: ProfilePhrase, sense: Sense, robot: CompiledRobot) -> bool:
    """Whether a sense of a lexicon is what the profile means, or nothing of this robot."""
    if sense.kind is SenseKind.SKILL:
        other = robot.phrases.get(sense.value)
        return other is None or (other is said.skill and said.parameter is None)
    if sense.kind is SenseKind.CHOICE and said.parameter is not None:
        return (said.parameter.words or {}).get(sense.value, said.choice) == said.choice
    return False


def check_phrases(robot: CompiledRobot, book: Phrasebook) -> None:
    """See that what a profile lets be said means nothing else in any language.

    Raises:
        ValueError: It does. The sentence names robot, skill, phrase and language.
    """
    for skill in robot.skills.values():
        _check_reverse(robot, skill)
        for said in phrases_of(skill):
            _check(robot, said, book)


def _check(robot: CompiledRobot, said: ProfilePhrase, book: Phrasebook) -> None:
    where = f"robot {robot.id}, skill {said.skill.skill.id!r}: {quote(said.phrase)}"
    key = phrase_key(said.phrase)
    if not LANGUAGE_CODE.fullmatch(said.language):
        raise ValueError(f"{where} is said in {quote(said.language)}, which is no language's code")
    waits = hears_wait(said.phrase)
    if (
        not key
        or waits
        or is_stop_word(key.split(" ")[0])
        or is_cancel_word(key)
        or read_numeral(key)
    ):
        raise ValueError(f"{where} cannot be said: it means something else everywhere")
    for table in book.tables:
        if table.language == said.language and _denies(key, table):
            raise ValueError(f"{where} cannot be said: it orders nothing in {said.language}")
        for sense in table.senses.get(key, ()):
            if sense.kind in _NO_ORDER and table.language == said.language:
                raise ValueError(f"{where} cannot be said: it orders nothing in {said.language}")
            if sense.kind in CONTENT and not _is_meant_by(said, sense, robot):
                raise ValueError(
                    f"{where} means {sense.kind.value} {sense.value} in {table.language}"
                )


def _denies(key: str, table: LexiconTable) -> bool:
    """Whether a phrase holds words that make any line no order."""
    words = key.split(" ")
    parts = (
        " ".join(words[begin:end])
        for begin in range(len(words))
        for end in range(begin + 1, len(words) + 1)
    )
    return any(
        sense.kind is SenseKind.BLOCKED for part in parts for sense in table.senses.get(part, ())
    )


def _check_reverse(robot: CompiledRobot, skill: CompiledSkill) -> None:
    """See that what undoes a skill is there: another skill, or a choice for a choice."""
    reverse = skill.skill.reverse
    where = f"robot {robot.id}, skill {skill.skill.id!r}: its reverse"
    if isinstance(reverse, str):
        if reverse not in robot.skills:
            raise ValueError(f"{where} is {quote(reverse)}, which it cannot do")
        return
    for name, choices in reverse.items():
        parameter = skill.by_name.get(name)
        known = (parameter.words if parameter is not None else None) or {}
        for choice in (*choices, *choices.values()):
            if choice not in known:
                raise ValueError(f"{where} names {quote(choice)}, which is no {name} of it")
