"""Each person reads their own language: what they chose, else what their messenger is set to."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.core.identity import Address
from rosic.core.message import Chat, Inbound
from rosic.features.access.access_messages import you_are_unlocked
from rosic.gateway.delivery.translation import ChatLanguages
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, STRANGER, VI, Place, line_by_line
from tests.gateway.tongue import Bracketed

MINE = {ADA: "1", BO: "2", VI: "3"}


async def ask(place: Place, account: str, text: str) -> str:
    return await place.say(text, account=account, chat=MINE[account])


def told_to(place: Place, account: str) -> str:
    """Return the newest message in somebody's own chat."""
    mine = [told for told in place.chat.told if told.outbound.chat.id == MINE[account]]
    return mine[-1].outbound.text


async def test_two_people_read_the_same_gateway_in_two_languages() -> None:
    async with Place().open() as place:
        assert await ask(place, ADA, "/language de") == "Gespeichert."
        assert "omni: steht still · frei" in await ask(place, ADA, "status")
        assert "omni: at rest · free" in await ask(place, BO, "status")
        assert "Es wurde nichts getan" in await ask(place, ADA, "omni move 9 m")
        assert "Nothing was done" in await ask(place, BO, "omni move 9 m")
        assert (await ask(place, ADA, "help")).startswith("Sag, was ein Roboter tun soll")
        assert (await ask(place, BO, "help")).startswith("Say what a robot should do")
        assert "omni gehört dir am" in await ask(place, ADA, "/book omni tomorrow 14:00 1h")
        taken = await ask(place, BO, "/book omni tomorrow 14:30 1h")
        assert taken.startswith("omni is taken by Ada from tomorrow 14:00 to tomorrow 15:00.")
        refused = await ask(place, ADA, "/book omni tomorrow 14:30 1h")
        assert refused.startswith("omni gehört dir schon von")


async def test_a_life_is_edited_in_the_language_of_its_author() -> None:
    async with Place().open() as place:
        await ask(place, ADA, "/language de")
        said = await ask(place, ADA, "omni wave")
        assert "angenommen" in said or "gesendet" in said, said
        assert told_to(place, ADA).splitlines()[-1] == "fertig 12:00:00"
        await ask(place, BO, "kuka1 wave")
        assert told_to(place, BO).splitlines()[-1] == "done 12:00:00"


async def test_a_life_line_by_line_as_well() -> None:
    async with Place(chat=line_by_line).open() as place:
        await ask(place, ADA, "/language de")
        told = await ask(place, ADA, "omni wave")
        assert "omni: wave: angenommen" in told
        assert told.endswith("omni: fertig 12:00:00")


async def test_a_stop_is_answered_in_the_language_of_whoever_stops() -> None:
    async with Place().open() as place:
        await ask(place, ADA, "/language de")
        stopped = await ask(place, ADA, "stop omni")
        assert "STOP geschickt an omni." in stopped
        assert "omni steht still" in stopped
        assert "omni ist angehalten, von dir, seit" in await ask(place, ADA, "omni wave")
        assert "omni is stopped, by Ada, since" in await ask(place, BO, "omni wave")
        assert "omni: angehalten von dir · frei" in await ask(place, ADA, "status omni")
        assert "omni: stopped by Ada · free" in await ask(place, BO, "status omni")
        assert await ask(place, ADA, "resume omni") == "omni ist wieder bereit."


async def test_whoever_is_told_reads_their_own_language() -> None:
    async with Place().open() as place:
        await ask(place, BO, "/language de")
        people = place.gateway.rooms.authoriser.directory
        both = [people.named(name)[0].id for name in ("Bo", "Vi")]
        await ask(place, ADA, "/lock Bo")
        await ask(place, ADA, "/unlock Bo")
        assert told_to(place, BO).startswith("Ada hat deine Sperre aufgehoben.")
        place.gateway.kernel.reach.tell(both, you_are_unlocked("Ada"))
        await place.quiet()
        assert told_to(place, VI).startswith("Ada unlocked you.")
        assert told_to(place, BO).startswith("Ada hat deine Sperre aufgehoben.")


async def test_what_the_messenger_says_is_only_the_default() -> None:
    async with Place().open() as place:
        await place.clock.advance(0.001)
        asked = place.chat.say("status", account=VI, chat="3")
        await place.quiet()
        place.chat.deliver(replace(asked, message="again", locale="de-AT"))
        await place.quiet()
        assert "steht still" in told_to(place, VI)
        assert await ask(place, VI, "/language en") == "Saved."
        place.chat.deliver(replace(asked, message="once more", locale="de"))
        await place.quiet()
        assert "at rest" in told_to(place, VI)


async def test_a_stranger_is_turned_away_in_the_language_of_their_messenger() -> None:
    async with Place().open() as place:
        asked = place.chat.say("hello", account=STRANGER, chat=STRANGER)
        await place.quiet()
        await place.clock.advance(700.0)  # nobody is told so twice in ten minutes
        place.chat.deliver(replace(asked, message="again", locale="de"))
        await place.quiet()
        english, german = [told.outbound.text for told in place.chat.told]
        assert english.startswith("Hello. I work for people I know")
        assert german.startswith("Hallo. Ich arbeite für Leute, die ich kenne")


async def test_a_language_is_kept_over_a_restart() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        await ask(place, ADA, "/language de")
    async with Place(store).open() as place:
        assert "frei" in await place.say("status", message="after")


async def test_a_button_reads_as_its_owner_does_and_says_what_it_said() -> None:
    async with Place().open() as place:
        await ask(place, ADA, "/language de")
        await ask(place, ADA, "/settings")
        button, under = place.button("Imperial")
        assert await place.tap(button, under) == "Gespeichert."


async def test_lengths_are_read_in_the_units_somebody_chose() -> None:
    async with Place().open() as place:
        await ask(place, ADA, "/settings units imperial")
        assert "omni: one move may be at most 16.4 ft." in await ask(place, ADA, "omni move 9 m")
        assert "omni: one move may be at most 5 m." in await ask(place, BO, "omni move 9 m")
        await ask(place, ADA, "omni move 1 m")
        assert told_to(place, ADA).startswith("omni: move, 3.28 ft forward\n")
        await ask(place, ADA, "/language de")
        missing = await ask(place, ADA, "omni move")
        assert missing == "omni: move braucht Strecke, von 0,03281 bis 16,4 ft."
        await ask(place, BO, "cf1 move 1 m")
        assert told_to(place, BO).startswith("cf1: move, 1.00 m forward\n")


def a_message(locale: str) -> Inbound:
    return Inbound(
        sender=Address("memory", "9"),
        chat=Chat("memory", "9"),
        message="1",
        text="x",
        sent_ns=0,
        received_ns=0,
        locale=locale,
    )


def test_only_languages_that_there_are_are_ever_loaded() -> None:
    asked: list[str] = []
    there = Bracketed()

    def load(code: str) -> Bracketed:
        asked.append(code)
        return there

    languages = ChatLanguages(load, {"en": (), "de": ()})
    for locale in ("../../etc", "fr", "", "zz", "DE", "de_CH", "de-AT"):
        languages.hear("p", locale)
    assert asked == ["de"]
    assert languages.of("p") is there
    assert languages.of_sender(a_message("fr")) is None
    assert languages.of_sender(a_message("de")) is there
    languages.choose("p", "en")
    languages.hear("p", "de")
    assert languages.of("p") is there  # the double speaks English, too
    languages.choose("p", "")
    languages.hear("p", "fr")
    assert languages.of("p") is None


@pytest.mark.parametrize("locale", ["en", "en_US", "C", "POSIX", "fr"])
def test_a_browser_counts_where_a_messenger_asks_for_nothing_but_english(locale: str) -> None:
    there = Bracketed()
    languages = ChatLanguages(lambda _code: there, {"de": ()})
    languages.hear("p", locale)
    languages.suggest("p", "de-DE")
    assert languages.code("p") == "de"
    languages.hear("p", "")
    languages.hear("p", locale)
    assert languages.of("p") is there
    languages.choose("p", "en")
    assert (languages.code("p"), languages.of("p")) == ("en", None)


def test_a_messenger_that_is_set_to_german_counts_before_an_english_browser() -> None:
    languages = ChatLanguages(lambda _code: Bracketed(), {"de": ()})
    languages.suggest("p", "en-GB")
    languages.hear("p", "de")
    assert languages.code("p") == "de"


def test_what_messengers_say_is_kept_within_bounds() -> None:
    languages = ChatLanguages(lambda _code: Bracketed(), {"de": ()})
    for number in range(20_050):
        languages.hear(f"p{number}", "de")
    assert languages.of("p1") is None
    assert languages.of("p20049") is not None
