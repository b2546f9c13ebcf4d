from __future__ import annotations

import pytest

from rosic.config.profiles import known_units
from rosic.container.messages import HOW_FAST
from rosic.container.preferences import ENGLISH, KIND, UNSET, PreferenceBook, SpeedLimits
from rosic.core.policy.limits import unit_converter
from rosic.core.policy.permissions import Permissions
from rosic.core.policy.roles import Grant, Role, RoleRules
from rosic.core.policy.scope import Fleet
from rosic.core.records import Fact, Letter
from rosic.core.robot.skill import Parameter, Skill
from rosic.errors import NotUnderstood, OutOfBounds, Refusal
from rosic.testing.clock import ManualClock

ADA, BO = "p-ada", "p-bo"
DRIVE = Skill(
    id="drive", parameters={"speed": Parameter(unit="m/s", min=0.05, max=0.8, default=0.25)}
)
TURN = Skill(id="turn", parameters={"speed": Parameter(unit="deg/s", min=1, max=90)})
WAVE = Skill(id="wave")
SKILLS = {"omni": {"drive": DRIVE, "turn": TURN}, "arm": {"wave": WAVE}}
LANGUAGES = {**ENGLISH, "de": ("Deutsch", "German")}


def a_book() -> PreferenceBook:
    caps = SpeedLimits(SKILLS, unit_converter(known_units()))
    return PreferenceBook(ManualClock(), caps, LANGUAGES)


def make_so(book: PreferenceBook, facts: tuple[Fact, ...]) -> Fact:
    (fact,) = facts
    book.apply(fact)
    return fact


def sentence(book: PreferenceBook, setter: str, said: str, *more: object) -> str:
    with pytest.raises(Refusal) as refused:
        getattr(book, setter)(ADA, said, *more)
    assert book.of(ADA) == UNSET
    return str(refused.value)


@pytest.mark.parametrize("said", ["de", "DE", " Deutsch ", "german"])
def test_a_language_is_set_by_its_code_or_its_name(said: str) -> None:
    book = a_book()
    make_so(book, book.set_language(ADA, said))
    assert book.of(ADA).language == "de"
    assert book.of(BO) == UNSET


def test_a_language_that_is_not_spoken_is_refused_with_those_that_are() -> None:
    book = a_book()
    said = sentence(book, "set_language", "klingon")
    assert said == 'I do not speak "klingon". I speak English or Deutsch.'
    assert sentence(book, "set_language", "") == "I speak English or Deutsch."


@pytest.mark.parametrize(
    ("said", "units"),
    [("Imperial", "imperial"), ("feet", "imperial"), ("si", "metric"), ("metres", "metric")],
)
def test_units(said: str, units: str) -> None:
    book = a_book()
    make_so(book, book.set_units(ADA, said))
    assert book.of(ADA).units == units


def test_units_that_are_none() -> None:
    said = sentence(a_book(), "set_units", "cubits")
    assert said == "Lengths and speeds can be shown in metric or in imperial units. Say which."


def test_only_a_robot_that_is_seen_can_be_the_usual_one_and_none_undoes_it() -> None:
    book = a_book()
    said = sentence(book, "set_robot", "arm", frozenset({"omni"}))
    assert said == 'You see no robot "arm".'
    make_so(book, book.set_robot(ADA, "OMNI", frozenset({"omni"})))
    assert book.usual == {ADA: "omni"}
    assert book.of(ADA).robot == "omni"
    taken_back = make_so(book, book.set_robot(ADA, "none", frozenset()))
    assert book.usual == {}
    assert book.of(ADA) == UNSET
    assert taken_back.body == b""


def test_a_speed_limits_every_skill_that_has_such_a_speed_and_no_other() -> None:
    book = a_book()
    make_so(book, book.set_speed(ADA, "0.2 m/s"))
    assert book.limits(ADA) == ("omni:drive speed <= 0.2 m/s",)
    make_so(book, book.set_speed(ADA, "20 deg/s"))
    assert book.limits(ADA) == ("omni:turn speed <= 20 deg/s",)
    make_so(book, book.set_speed(ADA, "off"))
    assert book.limits(ADA) == ()
    assert book.limits(BO) == ()


@pytest.mark.parametrize(
    ("said", "sentence_"),
    [
        ("fast", "Say how fast you want to go at most, with its unit: 0.2 m/s. Or say none."),
        ("0.2", "Say how fast you want to go at most, with its unit: 0.2 m/s. Or say none."),
        ("0 m/s", "A highest speed must be above 0. To go nowhere, say stop."),
        ("-1 m/s", "A highest speed must be above 0. To go nowhere, say stop."),
        (
            "3 kg",
            f'No robot here is given a speed in "kg". {HOW_FAST}',
        ),
    ],
)
def test_what_is_no_speed(said: str, sentence_: str) -> None:
    assert sentence(a_book(), "set_speed", said) == sentence_


def test_a_speed_is_in_force_in_the_rights_it_is_given_to() -> None:
    book = a_book()
    make_so(book, book.set_speed(ADA, "0.2 m/s"))
    rulebook = RoleRules(roles={"driver": Role(scopes=("*:*",))})
    held = {who: (Grant(role="driver", limits=book.limits(who)),) for who in (ADA, BO)}
    convert = unit_converter(known_units())
    rights = Permissions.draw_up(1, rulebook, Fleet(skills=SKILLS), held, convert)
    limits = {
        who: [limit.max for way, _ in rights.ways(who, "omni", "drive") for limit in way.limits]
        for who in (ADA, BO)
    }
    assert limits[ADA] == [pytest.approx(0.2)]
    assert limits[BO] == []
    assert rights.holds(ADA, "omni", "turn", 1)  # an angular speed is not touched


def test_a_speed_limits_whatever_is_one_however_it_is_called_and_both_ways() -> None:
    go = Skill(
        id="go",
        parameters={
            "linear": Parameter(unit="m/s", min=-0.8, max=0.8, default=0),
            "lateral": Parameter(unit="m/s", min=-0.8, max=0.8, default=0),
            "angular": Parameter(unit="deg/s", min=-90, max=90, default=0),
            "duration": Parameter(unit="s", min=0.1, max=5),
        },
    )
    skills, convert = {"omni": {"go": go}}, unit_converter(known_units())
    book = PreferenceBook(ManualClock(), SpeedLimits(skills, convert), LANGUAGES)
    make_so(book, book.set_speed(ADA, "20 cm/s"))
    held = {ADA: (Grant(role="driver", limits=book.limits(ADA)),)}
    rulebook = RoleRules(roles={"driver": Role(scopes=("*:*",))})
    rights = Permissions.draw_up(1, rulebook, Fleet(skills=skills), held, convert)
    [(way, _)] = rights.ways(ADA, "omni", "go")
    bounds = {limit.parameter: (limit.min, limit.max) for limit in way.limits}
    assert bounds == {  # type: ignore[comparison-overlap]
        "linear": (pytest.approx(-0.2), pytest.approx(0.2)),
        "lateral": (pytest.approx(-0.2), pytest.approx(0.2)),
    }
    slow = SpeedLimits(skills, convert).slowest()
    assert slow == (
        "omni:go linear <= 0.08 m/s",
        "omni:go lateral <= 0.08 m/s",
        "omni:go angular <= 9 deg/s",
    )


def test_zones_are_asked_of_whoever_knows_them() -> None:
    def name_of(said: str) -> str:
        if said != "Europe/Vienna":
            raise OutOfBounds("no such zone")
        return said

    book = a_book()
    assert sentence(book, "set_zone", "Atlantis", name_of) == "no such zone"
    assert sentence(book, "set_zone", " ", name_of).startswith("Say the time zone of the place")
    make_so(book, book.set_zone(ADA, "Europe/Vienna", name_of))
    assert book.of(ADA).zone == "Europe/Vienna"
    make_so(book, book.set_zone(ADA, "none", name_of))
    assert book.of(ADA) == UNSET


def test_deciding_changes_nothing_and_a_restart_knows_everything() -> None:
    book = a_book()
    facts = book.set_units(ADA, "imperial")
    assert book.of(ADA) == UNSET
    last = make_so(book, facts)
    last = make_so(book, book.set_speed(ADA, "0.2 m/s"))
    again = a_book()
    again.restore((last,))
    assert again.of(ADA) == book.of(ADA)
    assert again.limits(ADA) == book.limits(ADA)


def test_in_the_open_stands_nothing_that_was_set() -> None:
    book = a_book()
    fact = make_so(book, book.set_language(ADA, "de"))
    make_so(book, book.set_robot(ADA, "omni", frozenset({"omni"})))
    assert fact.letter is not None
    assert fact.letter.container == ADA
    assert b"de" not in fact.body
    assert fact.kind == KIND


@pytest.mark.parametrize("letter", [None, Letter(ADA, b"\xc1"), Letter(ADA, b"")])
def test_whoever_set_what_cannot_be_read_goes_slowly(
    letter: Letter | None, caplog: pytest.LogCaptureFixture
) -> None:
    book = a_book()
    fact = make_so(book, book.set_speed(ADA, "0.2 m/s"))
    book.apply(Fact(kind=KIND, key=ADA, body=fact.body, letter=letter))
    assert book.of(ADA) == UNSET
    assert book.damaged() == (ADA,)
    assert book.limits(ADA) == ("omni:drive speed <= 0.08 m/s", "omni:turn speed <= 9 deg/s")
    assert "cannot be read" in caplog.text

    said = sentence(book, "set_units", "metric")
    assert said.startswith("Your settings cannot be read any more"), "that would undo the cap"
    make_so(book, book.set_speed(ADA, "none"))
    assert (book.limits(ADA), book.damaged()) == ((), ())
    make_so(book, book.set_units(ADA, "metric"))


def test_damaged_settings_are_forgotten_with_their_owner() -> None:
    book = a_book()
    book.apply(Fact(kind=KIND, key=ADA, body=b"1"))
    make_so(book, book.unset(ADA))
    assert (book.limits(ADA), book.damaged()) == ((), ())


def test_unsetting_takes_everything_back() -> None:
    book = a_book()
    assert book.unset(ADA) == ()
    make_so(book, book.set_units(ADA, "si"))
    make_so(book, book.unset(ADA))
    assert book.of(ADA) == UNSET


def test_no_setting_is_a_refusal_of_the_wrong_kind() -> None:
    with pytest.raises(NotUnderstood) as refused:
        a_book().set_units(ADA, "cubits")
    assert refused.value.offers == ("/settings units metric", "/settings units imperial")
