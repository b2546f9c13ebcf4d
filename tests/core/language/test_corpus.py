"""Phrases as people write them, in six languages: what each comes to, and none acts wrongly."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.app.features import command_table
from rosic.config.lexicons import known_phrases
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import (
    Answered,
    CommandLine,
    Do,
    Help,
    LineContext,
    Misunderstood,
    Robots,
    Status,
    Vocabulary,
    hears_stop,
    understand,
)
from rosic.core.language.arguments import bind
from rosic.core.language.cancel_detection import hears_cancel
from rosic.errors import Refusal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language import Line
    from rosic.core.robot.skill import Argument

FOLDER = Path(__file__).with_name("corpus")
LANGUAGES = ("de", "en", "es", "fr", "pt", "zh")
ROBOTS = ("omni", "kuka1", "yumi", "cf1", "cf2", "cf3")
VOCABULARY = Vocabulary.build(
    tuple(load_profile(shipped_profiles()[name]) for name in ROBOTS),
    known_units(),
    command_table(),
    known_phrases(),
)
LABELS = frozenset({"act", "propose", "ask", "answer", "stop", "end", "still"})
SCHEDULED = re.compile(r"/schedule .*?(?=omni|kuka1|yumi|cf\d)")
CHOSEN = re.compile(r"\[(\w+)\]")
WANTED = 0.9
"""So much of it is to be understood as it is labelled; what is not stays in these files."""
# A command of the same meaning, which asks before anything moves.
ASKS = frozenset({"again", "undo", "continue"})


class Phrase(NamedTuple):
    """One line of the corpus; see its README."""

    text: str
    selected: str
    label: str
    meaning: str


def phrases(language: str) -> list[Phrase]:
    found = []
    for line in (FOLDER / f"{language}.txt").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue
        text, arrow, wanted = line.partition(" => ")
        label, _, meaning = wanted.partition(": ")
        assert arrow, line
        assert label in LABELS, line
        selected = CHOSEN.search(text)
        text = CHOSEN.sub("", text).strip()
        found.append(Phrase(text, selected[1] if selected else "", label, meaning))
    return found


def read(text: str, selected: str) -> Line:
    return understand(text, VOCABULARY, LineContext(selected, frozenset(VOCABULARY.profiles)))[0]


def acts(text: str, selected: str) -> list[tuple[str, str, Mapping[str, Argument]]]:
    """Return what a text lets robots do at once."""
    line = read(text, selected)
    found: list[tuple[str, str, Mapping[str, Argument]]] = []
    if isinstance(line, Do):
        for robot, skill in zip(line.robots, line.skills, strict=True):
            try:
                values = bind(VOCABULARY, robot, skill, line.spoken, group=line.group)
            except Refusal:
                continue
            found.append((robot, skill.id, values))
    return found


def offers(text: str, selected: str) -> tuple[str, ...]:
    """Return what is offered instead of what a text does not do."""
    line = read(text, selected)
    if isinstance(line, Misunderstood):
        return line.offers
    if isinstance(line, Do):
        try:
            bind(VOCABULARY, line.robots[0], line.skills[0], line.spoken, group=line.group)
        except Refusal as why:
            return why.offers
    return ()


def is_proposed(phrase: Phrase) -> bool:
    """Whether the first proposal is what is wanted, or a plan that begins with it."""
    line = read(phrase.text, phrase.selected)
    if isinstance(line, CommandLine):
        return line.verb in ASKS
    first = offers(phrase.text, phrase.selected)[:2]
    if first and first[0].startswith("/task "):
        first = first[1:]
    if first and first[0].startswith("/schedule "):
        return phrase.meaning in first[0] or begins(SCHEDULED.sub("", first[0]), phrase.meaning)
    return bool(first) and (first[0].startswith(phrase.meaning) or begins(first[0], phrase.meaning))


def begins(line: str, wanted: str) -> bool:
    """Whether a line asks the same of the same robot, in whatever order and units."""
    found, meant = acts(line, ""), acts(wanted, "")
    if found and found == meant:
        return True
    robot, *rest = wanted.split()
    return line.split(maxsplit=1)[0] == robot and all(
        word in line.replace("=", " ").split() for word in rest if word.isalpha() and len(word) > 2
    )


def is_answered(phrase: Phrase) -> bool:
    line = read(phrase.text, phrase.selected)
    what, _, robot = phrase.meaning.partition(" ")
    if what in {"hello", "thanks", "self", "never"}:
        return isinstance(line, Answered) and line.what.startswith(what)
    if what in {"help", "skills"}:
        return isinstance(line, Help) and line.topic == robot
    if what == "robots":
        return isinstance(line, Robots)
    if what == "status":
        return isinstance(line, Status) and line.robots == (robot,)
    return isinstance(line, CommandLine) and (line.verb, line.rest or robot) == (what, robot)


def is_as_labelled(phrase: Phrase) -> bool:
    stops = hears_stop(phrase.text, VOCABULARY.known) is not None
    if stops or phrase.label == "stop":
        return stops and phrase.label == "stop"
    if phrase.label == "end":
        return hears_cancel(phrase.text, VOCABULARY.known) is not None
    if phrase.label == "act":
        return acts(phrase.text, phrase.selected) == acts(phrase.meaning, "") != []
    if phrase.label == "answer":
        return is_answered(phrase)
    if phrase.label == "still":
        return not acts(phrase.text, phrase.selected)
    return is_proposed(phrase)


@pytest.mark.parametrize("language", LANGUAGES)
def test_nothing_is_acted_on_otherwise_than_it_is_meant(language: str) -> None:
    wrong = []
    for phrase in phrases(language):
        if hears_stop(phrase.text, VOCABULARY.known) is not None:
            continue  # nothing moves because of it, whatever else it says
        found = acts(phrase.text, phrase.selected)
        meant = acts(phrase.meaning, "") if phrase.label == "act" else []
        if found and found != meant:
            wrong.append((phrase, found))
    assert wrong == []


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_people_write_is_understood_as_they_mean_it(language: str) -> None:
    every = phrases(language)
    missed = [phrase for phrase in every if not is_as_labelled(phrase)]
    assert len(missed) <= (1 - WANTED) * len(every), missed


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_stop_is_one_and_no_order_is(language: str) -> None:
    for text, _, label, _ in phrases(language):
        stops = hears_stop(text, VOCABULARY.known) is not None
        assert not (stops and label in {"act", "propose", "ask", "end"}), text


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_meant_to_act_can_be_done(language: str) -> None:
    for phrase in phrases(language):
        if phrase.label == "act":
            assert acts(phrase.meaning, ""), phrase


def test_the_corpus_is_large_enough_to_tell() -> None:
    every = [phrase for language in LANGUAGES for phrase in phrases(language)]
    assert len(every) >= 1_500
    assert sum(phrase.label == "still" for phrase in every) >= 350
    assert len({(phrase.text, phrase.selected) for phrase in every}) > len(every) - 30


def test_the_page_says_how_large_it_is() -> None:
    every = [phrase for language in LANGUAGES for phrase in phrases(language)]
    still = sum(phrase.label == "still" for phrase in every)
    page = Path(__file__).parents[3].joinpath("docs/language.md").read_text(encoding="utf-8")
    assert f"{len(every):,} phrases as people write them, {still} of them" in page
