"""What is proposed instead is read to its end, and is no other quantity."""

from __future__ import annotations

import re
from random import Random
from typing import TYPE_CHECKING

import pytest

from rosic.core.language import Do, LineContext, Misunderstood, bind, understand
from rosic.errors import OutOfBounds, Refusal
from tests.core.language.test_total import COMMANDS
from tests.texts import LOCALE

if TYPE_CHECKING:
    from rosic.core.language import UnitTable, Vocabulary
    from tests.core.language.conftest import Means

LINES = 4_000
_UNIT_PRINTED = re.compile(
    r"(?:\{[^}]*\}|\d) ((?:Grad|Bogen|Umdrehung|\w*[Mm]eter|Sekunde|Minute|Stunde|Prozent)\w*)"
)


def _refusal(vocabulary: Vocabulary, everyone: frozenset[str], text: str) -> Refusal | None:
    """Return why a line is not carried out; None for what would be."""
    (line,) = understand(text, vocabulary, LineContext("", everyone))
    if isinstance(line, Misunderstood):
        return Refusal(line.sentence, offers=line.offers)
    if isinstance(line, Do):
        try:
            for robot, skill in zip(line.robots, line.skills, strict=True):
                bind(vocabulary, robot, skill, line.spoken, group=line.group)
        except Refusal as refusal:
            return refusal
    return None


def _slipped(random: Random, line: str) -> str:
    """Return a line with one or two slips of a finger, or with a word of another line."""
    words = line.split()
    for _ in range(random.randint(1, 2)):
        at = random.randrange(len(words))
        word = words[at]
        place = random.randrange(len(word))
        match random.randrange(4):
            case 0:
                words[at] = word[:place] + word[place + 1 :] or word
            case 1:
                words[at] = word[:place] + word[place : place + 2][::-1] + word[place + 2 :]
            case 2:
                words[at] = word[:place] + random.choice("aemnrst") + word[place:]
            case _:
                words[at] = random.choice(random.choice(COMMANDS).split())
    return " ".join(words)


def test_what_is_offered_is_read_to_its_end(
    vocabulary: Vocabulary, everyone: frozenset[str]
) -> None:
    random = Random("offers")  # noqa: S311
    lines, offered = COMMANDS, 0
    for _ in range(LINES):
        said = _slipped(random, random.choice(lines))
        refusal = _refusal(vocabulary, everyone, said)
        for offer in refusal.offers if refusal is not None else ():
            then = _refusal(vocabulary, everyone, offer)
            # What is outside its bounds, or not whole yet, leads on to a value that is right.
            on = (
                then is None or isinstance(then, OutOfBounds) or then.offers or "needs" in str(then)
            )
            assert on, (said, offer, str(then))
            assert not isinstance(then, Refusal) or "does not know" not in str(then), (said, offer)
            offered += 1
    assert offered > LINES / 10


@pytest.mark.parametrize(
    "said",
    ["omni drhee dich 5 grad", "omni mvoe 5 quux", "status omin and nobdy", "omin move 2 quux m"],
)
def test_a_mended_word_in_a_line_that_says_nothing_is_not_offered(means: Means, said: str) -> None:
    line = means(said)

    assert isinstance(line, Misunderstood)
    assert "Did you mean" not in line.sentence
    assert all(offer.startswith("help") or offer == "robots" for offer in line.offers)


def test_every_unit_that_german_sentences_print_is_understood(units: UnitTable) -> None:
    catalogue = (LOCALE / "de" / "LC_MESSAGES" / "rosic.po").read_text(encoding="utf-8")
    printed = {word for line in catalogue.splitlines() for word in _UNIT_PRINTED.findall(line)}

    assert {"Grad", "Sekunden", "Minuten", "Stunden"} <= printed
    assert {word for word in printed if units.find(word) is None} == set()
