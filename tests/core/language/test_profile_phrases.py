"""What a profile lets be said in a language is used in it, and means nothing else anywhere."""

from __future__ import annotations

import pytest

from rosic.app.features import command_table
from rosic.config.lexicons import known_phrases
from rosic.config.profile_validation import clash
from rosic.config.profiles import known_units
from rosic.core.language import Do, LineContext, Misunderstood, Vocabulary, understand
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill

MOVE = Skill(id="move", parameters={"distance": Parameter(unit="m", min=0, max=5)})
SIDE = Parameter(choices={"left": (), "right": ()}, say={"left": {"de": ("backbord",)}})


def mower(**how: object) -> Profile:
    mow = Skill(id="mow", parameters={"side": SIDE}, **how)  # type: ignore[arg-type]
    return Profile(id="mower", link=Link(kind="memory"), skills={"mow": mow, "move": MOVE})


def vocabulary_of(profile: Profile) -> Vocabulary:
    return Vocabulary.build((profile,), known_units(), command_table(), known_phrases())


def read(profile: Profile, text: str) -> object:
    [line] = understand(text, vocabulary_of(profile), LineContext("", frozenset({"mower"})))
    return line


def test_what_a_profile_says_is_understood_in_its_language() -> None:
    mine = mower(say={"de": ("mäh",), "fr": ("tonds",)})
    for text in ("mower mäh backbord", "mäh mower bitte backbord", "mower backbord mäh"):
        line = read(mine, text)
        assert isinstance(line, Do), text
        assert line.skills[0].id == "mow"
        assert [value.word for value in line.spoken] == ["left"]
    assert isinstance(read(mine, "mower tonds gauche"), Do)


def test_it_is_understood_in_no_other_language() -> None:
    mine = mower(say={"fr": ("tonds",)})
    assert isinstance(read(mine, "mower tonds bitte links"), Misunderstood)


WRONG = (
    ({"say": {"de": ("stopp",)}}, "means something else everywhere"),
    ({"say": {"de": ("abbrechen",)}}, "means something else everywhere"),
    ({"say": {"de": ("12",)}}, "means something else everywhere"),
    ({"say": {"de": ("",)}}, "means something else everywhere"),
    ({"say": {"de": ("nicht",)}}, "orders nothing in de"),
    ({"say": {"de": ("zwei",)}}, "orders nothing in de"),
    ({"say": {"de": ("bitte",)}}, "orders nothing in de"),
    ({"say": {"fr": ("avance",)}}, "means skill move in es"),
    ({"say": {"de": ("avanza",)}}, "means skill move in es"),
    ({"say": {"deutsch": ("mäh",)}}, "no language's code"),
    ({"reverse": "unmow"}, "which it cannot do"),
    ({"reverse": {"side": {"left": "up"}}}, "which is no side of it"),
    ({"reverse": {"depth": {"left": "right"}}}, "which is no depth of it"),
)


@pytest.mark.parametrize(("how", "sentence"), WRONG)
def test_what_means_something_else_is_refused(how: dict[str, object], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence) as told:
        vocabulary_of(mower(**how))
    assert "robot mower, skill 'mow'" in str(told.value)
    assert sentence in clash([mower(**how)], known_units())  # as `rosic robot check` says it


def test_a_choice_that_means_another_is_refused() -> None:
    side = Parameter(choices={"left": (), "right": ()}, say={"left": {"de": ("rechts",)}})
    mow = Skill(id="mow", parameters={"side": side})
    profile = Profile(id="mower", link=Link(kind="memory"), skills={"mow": mow})
    with pytest.raises(ValueError, match="means choice right in de"):
        vocabulary_of(profile)


def test_what_is_said_for_no_choice_is_refused() -> None:
    with pytest.raises(ValueError, match="say must have the same words as choices"):
        Parameter(choices={"left": ()}, say={"up": {"de": ("hoch",)}})
