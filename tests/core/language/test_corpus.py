"""Phrases as people write them, in six languages: none is acted on otherwise than it is meant."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import pytest

from rosic.app.features import command_table
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import Do, LineContext, Vocabulary, hears_stop, understand
from rosic.core.language.arguments import bind
from rosic.core.language.cancel_detection import hears_cancel
from rosic.errors import Refusal

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.skill import Argument

FOLDER = Path(__file__).with_name("corpus")
LANGUAGES = ("de", "en", "es", "fr", "pt", "zh")
ROBOTS = ("omni", "kuka1", "yumi", "cf1", "cf2", "cf3")
VOCABULARY = Vocabulary.build(
    tuple(load_profile(shipped_profiles()[name]) for name in ROBOTS), known_units(), command_table()
)
LABELS = frozenset({"act", "propose", "ask", "answer", "stop", "end", "still"})
CHOSEN = re.compile(r"\[(\w+)\]")


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


def acts(text: str, selected: str) -> list[tuple[str, str, Mapping[str, Argument]]]:
    """Return what a text lets robots do at once."""
    found: list[tuple[str, str, Mapping[str, Argument]]] = []
    for line in understand(text, VOCABULARY, LineContext(selected, frozenset(VOCABULARY.profiles))):
        if isinstance(line, Do):
            for robot, skill in zip(line.robots, line.skills, strict=True):
                try:
                    values = bind(VOCABULARY, robot, skill, line.spoken)
                except Refusal:
                    continue
                found.append((robot, skill.id, values))
    return found


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
def test_every_stop_is_one_and_no_order_is(language: str) -> None:
    for text, _, label, _ in phrases(language):
        stops = hears_stop(text, VOCABULARY.known) is not None
        assert stops or label != "stop", text
        assert not (stops and label in {"act", "propose", "ask", "end"}), text
        if label == "end":
            assert hears_cancel(text, VOCABULARY.known) is not None, text


@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_meant_to_act_can_be_done(language: str) -> None:
    for phrase in phrases(language):
        if phrase.label == "act":
            assert acts(phrase.meaning, ""), phrase


def test_the_corpus_is_large_enough_to_tell() -> None:
    every = [phrase for language in LANGUAGES for phrase in phrases(language)]
    assert len(every) >= 600
    assert sum(phrase.label == "still" for phrase in every) >= 100
    assert len({(phrase.text, phrase.selected) for phrase in every}) > len(every) - 10
