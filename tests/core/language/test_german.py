"""What people type in German for names that many profiles use means what the profile says."""

from __future__ import annotations

import pytest

from rosic.app.features import command_table
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.language import CommandLine, Do, LineContext, Vocabulary, hears_stop, understand
from rosic.core.language.arguments import bind
from rosic.core.language.cancel_detection import hears_cancel
from rosic.core.language.common_names import TYPED
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill

FLEET = tuple(load_profile(shipped_profiles()[name]) for name in ("kuka1", "omni", "cf1"))
VOCABULARY = Vocabulary.build(FLEET, known_units(), command_table())


def meant(line: str, vocabulary: Vocabulary = VOCABULARY) -> object:
    [found] = understand(line, vocabulary, LineContext("", frozenset(vocabulary.profiles)))
    if not isinstance(found, Do):
        return found
    [robot], [skill] = found.robots, found.skills
    return robot, skill.id, bind(vocabulary, robot, skill, found.spoken)


@pytest.mark.parametrize(
    ("german", "english"),
    [
        ("omni fahre links 50 cm", "omni move left 50 cm"),
        ("omni fahre 0,5 m nach rechts mit 0,4 m/s", "omni move right 0.5 m speed=0.4"),
        ("omni fahr bitte 1 m zurück", "omni move back 1 m"),
        ("fahre vor strecke=2 tempo=0,3", "move forward distance=2 speed=0.3"),
        ("omni drehe um 90 grad nach links", "omni turn left 90 deg"),
        ("omni fahre zu x=1 y=2 ausrichtung=90", "omni goto x=1 y=2 yaw=90"),
        ("omni arm grundstellung", "omni arm home"),
        ("kuka1 greife kraft=20", "kuka1 grasp force=20"),
        ("kuka1 loslassen", "kuka1 release"),
        ("kuka1 grundstellung", "kuka1 home"),
        ("cf1 abheben höhe=1 m", "cf1 takeoff 1 m"),
        ("cf1 lande", "cf1 land"),
        ("omni FAHRE Links 50 cm", "omni move left 50 cm"),
    ],
)
def test_german_means_the_same(german: str, english: str) -> None:
    assert meant(german) == meant(english)


@pytest.mark.parametrize(
    ("typed", "verb"), [("weiter", "continue"), ("buchen omni", "book"), ("pausieren", "pause")]
)
def test_german_commands(typed: str, verb: str) -> None:
    found = meant(typed)
    assert isinstance(found, CommandLine)
    assert found.verb == verb


def own(name: str, **skills: Skill) -> Vocabulary:
    profile = Profile(id=name, link=Link(kind="memory"), skills=skills)
    return Vocabulary.build((profile,), known_units(), command_table())


def test_what_a_profile_says_comes_first() -> None:
    go = Skill(id="go", words=("fahre",), parameters={"to": Parameter(choices={"nach": ()})})
    vocabulary = own("rover", go=go, move=Skill(id="move"))
    assert meant("rover fahre nach", vocabulary) == ("rover", "go", {"to": "nach"})
    assert meant("rover fahren", vocabulary) == ("rover", "move", {})
    assert meant("fahren", own("fahren", move=Skill(id="move"))) != ("fahren", "move", {})


def test_what_would_leave_a_doubt_means_nothing() -> None:
    sides: dict[str, tuple[str, ...]] = {"back": (), "backward": ()}
    vocabulary = own("rover", shift=Skill(id="shift", parameters={"to": Parameter(choices=sides)}))
    assert meant("rover shift back", vocabulary) == ("rover", "shift", {"to": "back"})
    [found] = understand("rover shift zurück", vocabulary, LineContext("", frozenset({"rover"})))
    assert isinstance(found, Do)
    with pytest.raises(Exception, match='does not know "zurück"'):
        bind(vocabulary, "rover", found.skills[0], found.spoken)


@pytest.mark.parametrize("word", sorted({word for words in TYPED.values() for word in words}))
def test_no_word_takes_a_stop_or_a_cancel_away(word: str) -> None:
    assert hears_stop(word) is None, "nobody who meant to stop is understood to move"
    assert hears_cancel(word) is None
    for said in (f"stopp {word}", f"halt {word}"):
        assert hears_stop(said, VOCABULARY.known) is not None, said
