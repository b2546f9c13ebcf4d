"""In German nothing stays English: titles, choices, states, and the words of commands."""

from __future__ import annotations

import asyncio
import re
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.features import command_table
from rosic.config.plugins import catalogue
from rosic.config.profiles import known_units, load_profile, shipped_profiles
from rosic.core.i18n import ImperialCatalogue, in_language
from rosic.core.language import (
    CommandLine,
    Do,
    Help,
    LineContext,
    Vocabulary,
    hears_stop,
    understand,
)
from rosic.core.language.cancel_detection import hears_cancel
from rosic.core.language.command import VERBS
from rosic.core.language.keywords import HELP_PAGES, PAGE_ALIASES
from rosic.core.messages import button_label
from rosic.core.policy.roles import DEFAULT_ROLES
from rosic.core.role_names import TYPED as TYPED_ROLES
from rosic.core.role_names import role_shown, role_typed
from rosic.core.units import in_units_of
from rosic.features.booking.book import BOOKINGS
from rosic.gateway.order_label import label_of
from tests.gateway.place import FLEET, VI, Place
from tests.pace import patience
from tests.texts import read

if TYPE_CHECKING:
    from rosic.core.i18n import Catalogue

GERMAN = catalogue("de")
TABLE = command_table()
ALIASES, COMMANDS = TABLE.aliases, TABLE.words
TYPED = {command.name: command.typed for command in TABLE if command.typed}
EXPLAINED = {command.name for command in TABLE if command.explained}
PAGE_OF = {
    command.name: page
    for command in TABLE
    if (page := command.page or (command.help and command.help.page))
    and not command.explained
    and command.name not in {"stop", "use", "cancel booking"}
}
VOCABULARY = Vocabulary.build(FLEET, known_units(), command_table())
SHIPPED = Vocabulary.build(
    [load_profile(shipped_profiles()["omni"])], known_units(), command_table()
)


def meant(line: str) -> object:
    everything = frozenset(profile.id for profile in FLEET)
    return understand(line, VOCABULARY, LineContext("", everything))


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
        [asked] = understand(german, VOCABULARY, LineContext("", frozenset()))
        assert isinstance(asked, CommandLine)
        assert asked.verb == "cancel"
        assert asked.rest in BOOKINGS
        assert hears_cancel(german) is None
        return
    assert meant(german) == meant(f"/{name}")
    assert meant(german.removeprefix("/").capitalize()) == meant(name)
    assert meant(f"{german} omni") == meant(f"/{name} omni")


@pytest.mark.parametrize("name", TYPED)
@pytest.mark.parametrize("language", [None, GERMAN])
def test_what_help_says_to_type_with_a_slash_is_one_link(
    name: str, language: Catalogue | None
) -> None:
    typed = in_language(TYPED[name], language)
    assert re.fullmatch(r"/[a-z0-9_]{1,32}|[^/]+", typed), typed


def test_other_words_for_commands_mean_one_each_and_take_no_name_away() -> None:
    assert set(ALIASES.values()) <= COMMANDS | VERBS
    assert set(PAGE_ALIASES.values()) == HELP_PAGES
    assert set(ALIASES).isdisjoint(COMMANDS | VERBS)
    assert all(hears_stop(word) is None for word in (*ALIASES, *PAGE_ALIASES))


def test_no_sentence_says_to_say_an_english_word_for_which_there_is_a_german_one() -> None:
    english = "|".join(sorted({*ALIASES.values(), "stop"}))
    says = re.compile(rf"\b[Ss]ag (?:jederzeit )?(?:{english})\b")
    forms = [
        form
        for message in read("de")
        for form in ([message.string] if isinstance(message.string, str) else message.string or ())
    ]
    assert "Sag hilfe, dann hörst du, was geht." in forms
    assert [form for form in forms if says.search(form)] == []


def test_roles_are_read_in_german_and_may_be_typed_so() -> None:
    assert {in_language(role_shown(name), GERMAN).casefold(): name for name in DEFAULT_ROLES} == {
        **TYPED_ROLES,
        "admin": "admin",
    }
    assert all(role_typed(word, DEFAULT_ROLES) == name for word, name in TYPED_ROLES.items())
    assert role_typed("bediener", {"bediener", "operator"}) == "bediener"
    assert role_typed("bediener", {"chief"}) == "bediener"


async def test_a_german_name_of_a_role_invites_and_is_a_part_of_another() -> None:
    async with Place().open() as place:
        await place.say("/language de")
        invited = await place.say("/invite bediener omni for 2h")
        assert "Bediener für omni für 2 Stunden" in invited
        assert "Zuschauer" in await place.say("/role zuschauer")
        assert "gast" in await place.say("/role gast may zuschauer, omni:wave")
        await place.tap(*place.button("So machen"))
        assert "gast (in einem Chat gemacht): Zuschauer, omni:wave" in await place.say("/role gast")
        await place.say("/language de", account=VI, chat=VI)
        assert '"Bediener"' in await place.say("omni move 1 m", account=VI, chat=VI)


def test_every_skill_that_ships_has_a_german_title_that_may_be_typed() -> None:
    for path in shipped_profiles().values():
        profile = load_profile(path)
        vocabulary = Vocabulary.build((profile,), known_units(), command_table())
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
    assert in_units_of(said, ImperialCatalogue(None)) == read
    assert in_units_of(said, GERMAN) == said


@pytest.mark.parametrize(
    ("german", "english"),
    [
        ("noch einmal", "again"),
        ("Rückgängig", "undo"),
        ("wunsch omni 1h morgen 9:00 bis 17:00", "wish omni 1h morgen 9:00 bis 17:00"),
    ],
)
def test_what_a_german_button_says_is_understood_when_it_is_typed(
    german: str, english: str
) -> None:
    assert meant(german) == meant(english)
    assert isinstance(meant(german)[0], CommandLine)  # type: ignore[index]


async def test_a_right_is_asked_for_and_a_task_is_given_in_german_alone() -> None:
    async with Place().open() as place:
        await place.say("/language de", account=VI, chat=VI)
        told = await place.say("bitten omni move für 1h", account=VI, chat=VI)
        assert "Ich habe gefragt (Ada): move mit omni, für 1 h" in told
        place.robot("omni").work_s = 1.0
        await place.say("aufgabe omni fahre 1 m dann wave")
        await place.clock.advance(5.0)
        assert "fahre 1 m; wave" in await place.say("/tasks")


async def test_settings_roles_loans_and_conditions_may_be_said_in_german() -> None:
    async with Place(fleet=tuple(SHIPPED.profiles.values())).open() as place:
        for line, kept in (
            ("tempo 0,2 m/s", "Highest speed: 0.2 m/s"),
            ("Höchstgeschwindigkeit keine", "Highest speed: whatever each robot allows"),
            ("einheiten imperial", "Units: imperial"),
            ("einheiten metrisch", "Units: metric"),
            ("roboter omni", "Robot, when none is named: omni"),
            ("roboter keiner", "Robot, when none is named: none"),
            ("zeitzone Europe/Vienna", "Time zone: Europe/Vienna"),
        ):
            assert "Saved" in await place.say(f"/einstellungen {line}"), line
            assert kept in await place.say("/settings"), line
        assert "omni:move with speed <= 0.2 m/s" in await place.say(
            "/rolle gast darf omni:move mit tempo <= 0,2 m/s"
        )
        assert await place.say("/teilen bay mit Bo") == await place.say("/share bay with Bo")
        told = await place.say(
            "aufgabe omni fahre 1 m dann drehe links 90 grad priorität 2 akku 30 einmal"
        )
        assert "fahre 1 m; drehe links 90 grad" in told
        assert "battery at least 30 %" in told
        assert "never twice" in told


@pytest.mark.parametrize("name", sorted(EXPLAINED - HELP_PAGES))
def test_help_about_a_command_is_what_the_command_says_of_itself(name: str) -> None:
    alone = (CommandLine(name, ""),)
    assert meant(f"help {name}") == meant(f"/{name} help") == meant(f"{name} hilfe") == alone
    german = next((word for word, english in ALIASES.items() if english == name), name)
    assert meant(f"hilfe {german}") == alone


@pytest.mark.parametrize("name", sorted(PAGE_OF))
def test_help_about_another_command_is_its_page(name: str) -> None:
    assert meant(f"help {name}") == (Help(PAGE_OF[name]),)


@pytest.mark.parametrize(
    ("offer", "german", "in_feet"),
    [
        ("omni move 5 m", "omni fahre 5 m", "omni move 16.4 ft"),
        (
            "omni move distance=1 m speed=0.2 m/s",
            "omni fahre Strecke=1 m Tempo=0,2 m/s",
            "omni move distance=3.28 ft speed=0.66 ft/s",
        ),
        ("omni move left", "omni fahre links", "omni move left"),
        ("help omni", "hilfe omni", "help omni"),
        ("/settings units metric", "/einstellungen einheiten metrisch", "/settings units metric"),
        ("/task omni move 1 m", "/aufgabe omni fahre 1 m", "/task omni move 3.28 ft"),
        ("omni   MOVE left", "omni   MOVE left", "omni   MOVE left"),
    ],
)
def test_an_offer_reads_as_its_reader_would_type_it(offer: str, german: str, in_feet: str) -> None:
    label = label_of(offer, SHIPPED)
    assert (label, in_language(label, GERMAN)) == (offer, german)
    assert in_language(label, ImperialCatalogue(None)) == in_feet
    everything = LineContext("", frozenset(SHIPPED.profiles))
    [by_label] = understand(german, SHIPPED, everything)
    [by_offer] = understand(offer, SHIPPED, everything)
    if isinstance(by_offer, Do):
        assert isinstance(by_label, Do)
        assert (by_label.robots, by_label.skills) == (by_offer.robots, by_offer.skills)
        assert [(v.number, v.word.casefold()) for v in by_label.spoken if v.number] == [
            (v.number, v.word) for v in by_offer.spoken if v.number
        ]


async def test_the_right_to_resume_is_named_and_asked_for_in_german() -> None:
    async with Place().open() as place:
        await place.say("/language de", account=VI, chat=VI)
        await place.say("stop omni")
        told = await place.say("freigeben omni", account=VI, chat=VI)
        assert "Freigeben braucht das Recht" in told
        told = await place.say("bitten omni freigeben", account=VI, chat=VI)
        assert "Ich habe gefragt (Ada): freigeben mit omni, für 1 h" in told


@pytest.mark.parametrize(
    ("german", "english"),
    [
        ("/dateien senden plan.pdf an omni", "/files send plan.pdf to omni"),
        ("/dateien holen plan.pdf", "/files get plan.pdf"),
        ("/dateien löschen plan.pdf", "/files delete plan.pdf"),
        ("/dateien von omni", "/files from omni"),
        ("/auftrag starten restock", "/mission start restock"),
        ("/auftrag pausieren restock", "/mission pause restock"),
        ("/auftrag beenden restock", "/mission cancel restock"),
        ("/auftrag aus 1", "/mission off 1"),
        ("/wunsch aus 1", "/wish off 1"),
        ("/tafel aus", "/card off"),
        ("/tafel loslösen", "/card unpin"),
        ("/tafel bild omni", "/card picture omni"),
        ("/daten exportieren", "/mydata export"),
        ("/vergessen mich", "/forget me"),
        ("/werte omni", "/data omni"),
        ("/archiv ein 30 Tage", "/archive on 30 days"),
        ("/archiv an", "/archive on"),
        ("/archiv löschen", "/archive erase"),
        ("/archiv aus", "/archive off"),
        ("/robot deaktivieren omni", "/robot disable omni"),
        ("/robot aktivieren omni", "/robot enable omni"),
        ("/robot ausmustern omni", "/robot retire omni"),
        ("/robot aufnehmen omni", "/robot add omni"),
        ("/robot aufnehmen rover.yaml als fellow", "/robot add rover.yaml as fellow"),
        ("/quiet omni aus", "/quiet omni off"),
        ("/aufgabe abbrechen 7", "/task cancel 7"),
    ],
)
async def test_what_german_says_of_a_command_does_what_english_does(
    german: str, english: str
) -> None:
    told = []
    for line in (german, english):
        async with Place().open() as place:
            before = len(place.chat.told)
            said = await place.say(line)
            async with asyncio.timeout(30 * patience()):
                while len(place.chat.told) == before:  # noqa: ASYNC110 - a file is made in a thread
                    await asyncio.sleep(0)
            told.append(said or place.chat.told[-1].outbound.text)
    assert told[0] == told[1]


@pytest.mark.parametrize(
    ("offer", "german"),
    [
        ("/archive on", "/archiv ein"),
        ("/archive export text", "/archiv exportieren text"),
        ("/mydata export", "/daten exportieren"),
        ("/robot add omni", "/robot aufnehmen omni"),
        ("/card off", "/tafel aus"),
        ("/forget me", "/vergessen mich"),
        ("/data", "/werte"),
    ],
)
def test_what_a_button_says_behind_a_command_is_german_and_means_the_same(
    offer: str, german: str
) -> None:
    assert label_of(offer, VOCABULARY) == offer
    assert in_language(label_of(offer, VOCABULARY), GERMAN) == german


@pytest.mark.parametrize("word", ["aufnehmen", "bild"])
async def test_a_robot_that_is_called_as_a_german_verb_is_meant(word: str) -> None:
    called = replace(FLEET[0], id=word, title=word)
    async with Place(fleet=(*FLEET, called)).open() as place:
        assert (await place.say(f"/robot {word}")).startswith(f"{word} ")
        assert f"{word}:" in await place.say(f"/card {word}")


def test_a_german_word_of_ours_is_understood_where_a_skill_has_the_english_one() -> None:
    everybody = Vocabulary.build(
        [load_profile(shipped_profiles()[name]) for name in ("omni", "yumi")],
        known_units(),
        command_table(),
    )
    assert "handover" in everybody.longest_skill
    everything = LineContext("", frozenset(everybody.profiles))
    assert understand("übergeben Bo", everybody, everything) == (CommandLine("handover", "Bo"),)
    assert understand("/übergeben Bo", everybody, everything) == (CommandLine("handover", "Bo"),)
    [skill] = understand("handover", everybody, everything)
    assert isinstance(skill, Do)


@pytest.mark.parametrize(
    ("asked", "as_well"),
    [
        ("bild von omni", "picture omni"),
        ("karte vom omni", "map omni"),
        ("status von omni", "status omni"),
        ("hilfe zu omni", "help omni"),
        ("akku von omni", "status omni"),
    ],
)
async def test_what_stands_before_a_name_in_german_is_no_name(asked: str, as_well: str) -> None:
    async with Place().open() as place:
        meant = await place.say(as_well)
        assert await place.say(asked) == meant
        assert "I know no" not in meant


async def test_a_robot_is_taken_by_you_in_the_case_that_german_wants() -> None:
    async with Place().open() as place:
        await place.say("/language de")
        await place.say("omni move 1 m")
        assert "vergeben an dich" in await place.say("status omni")
