"""In German nothing stays English: titles, choices, states, and the words of commands."""

from __future__ import annotations

import pytest

from rosic.app.documents.profiles import known_units, load_profile, shipped_profiles
from rosic.app.languages import catalogue
from rosic.core.language import Context, Errand, Vocabulary, hears_stop, understand
from rosic.core.language.cancelling import hears_cancel
from rosic.core.language.words import ALIASES, ERRANDS, HELP_PAGES, PAGE_ALIASES, VERBS
from rosic.core.measures import in_units_of
from rosic.core.saying import Imperial, in_language
from rosic.core.words import button_label
from rosic.pipeline.command_words import TYPED
from rosic.pipeline.times.cancelling import BOOKINGS
from tests.rooms.pipeline.place import FLEET

GERMAN = catalogue("de")
VOCABULARY = Vocabulary.build(FLEET, known_units())


def meant(line: str) -> object:
    everything = frozenset(profile.id for profile in FLEET)
    return understand(line, VOCABULARY, Context("", everything))


@pytest.mark.parametrize("name", TYPED)
def test_what_german_help_says_to_type_is_understood(name: str) -> None:
    german = in_language(TYPED[name], GERMAN)
    if name == "stop":
        assert hears_stop(german) == ()
        return
    if name == "cancel":
        assert hears_cancel(german) == ()
        return
    if name == "cancel booking":
        [asked] = understand(german, VOCABULARY, Context("", frozenset()))
        assert isinstance(asked, Errand)
        assert asked.verb == "cancel"
        assert asked.rest in BOOKINGS
        assert hears_cancel(german) is None
        return
    assert meant(german) == meant(f"/{name}")
    assert meant(german.removeprefix("/").capitalize()) == meant(name)
    assert meant(f"{german} omni") == meant(f"/{name} omni")


def test_other_words_for_commands_mean_one_each_and_take_no_name_away() -> None:
    assert set(ALIASES.values()) <= ERRANDS | VERBS
    assert set(PAGE_ALIASES.values()) == HELP_PAGES
    assert set(ALIASES).isdisjoint(ERRANDS | VERBS)
    assert all(hears_stop(word) is None for word in (*ALIASES, *PAGE_ALIASES))


def test_every_skill_that_ships_has_a_german_title_that_may_be_typed() -> None:
    for path in shipped_profiles().values():
        profile = load_profile(path)
        vocabulary = Vocabulary.build((profile,), known_units())
        for skill in profile.skills.values():
            german = skill.titles["de"]
            assert german in in_language(button_label(skill), GERMAN)
            assert vocabulary.skill(profile.id, german) is skill, (profile.id, german)


@pytest.mark.parametrize(
    ("said", "read"),
    [
        ("moved 1.52 m forward", "moved 4.99 ft forward"),
        ("0.5 m/s for 3 min", "1.64 ft/s for 3 min"),
        ("at -1.00 m, 10 cm up; 20 °C", "at -3.28 ft, 3.94 in up; 68 °F"),
        ("shelf 5 m2, v1.2 m, 90 deg", "shelf 5 m2, v1.2 m, 90 deg"),
    ],
)
def test_what_a_robot_says_is_read_in_ones_own_units(said: str, read: str) -> None:
    assert in_units_of(said, Imperial(None)) == read
    assert in_units_of(said, GERMAN) == said
