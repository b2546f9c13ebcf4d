"""Questions that move nothing, and what robots say of their own accord."""

from __future__ import annotations

import pytest

from rosic.app.people import ConfiguredPerson
from rosic.core.identity import Address
from tests.gateway.place import ADA, BO, VI, Place


async def test_status_says_who_has_what_and_what_it_does() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m")
        await place.say("stop kuka1")
        told = await place.say("status")
        assert "omni: doing move · taken by you" in told
        assert "kuka1: stopped by you" in told
        assert "cf1: at rest · free" in told


async def test_status_of_one_robot_and_of_one_that_is_away() -> None:
    async with Place().open() as place:
        place.robot("omni").online = False
        assert await place.say("status omni") == "omni: not there, last heard 0 s ago · free"


async def test_a_robot_is_not_called_free_in_somebodys_time() -> None:
    async with Place().open() as place:
        assert (await place.say("status omni")).endswith(" · free")
        assert "omni is yours" in await place.say("/book omni now 1h", account=BO, chat=BO)
        assert (await place.say("status omni")).endswith(" · taken by Bo")


async def test_a_robot_that_is_away_is_sent_nothing() -> None:
    async with Place().open() as place:
        place.robot("omni").online = False
        told = await place.say("omni move 1 m")
        assert "omni is not there. Nothing was sent." in told
        assert place.acted() == 0


async def test_help_names_skills_and_bounds() -> None:
    async with Place().open() as place:
        told = await place.say("help omni")
        assert "move: direction (forward, back, left), distance 0.01 to 5 m" in told
        assert "Say stop at any time" in await place.say("help")


@pytest.mark.parametrize("word", ["menu", "Menü", "Menu!", "/menu", "hauptmenü"])
async def test_menu_shows_what_the_button_of_that_name_shows(word: str) -> None:
    async with Place().open() as place:
        told = await place.say(word)
        assert told.endswith("Which robot?")
        labels = [b.label for row in place.last()[1].buttons for b in row]
        assert labels == ["cf1", "cf2", "kuka1", "omni"]


PAGES = ("move", "see", "share", "fleet", "alarms")


async def test_help_is_a_menu_of_what_one_may_and_has_no_empty_line() -> None:
    async with Place().open() as place:
        pages: dict[str, str] = {}
        for who in (ADA, BO, VI):
            told = [await place.say(f"help {page}", account=who, chat=who) for page in ("", *PAGES)]
            for text in told:
                assert all(line.strip() for line in text.splitlines()), text
                assert not text.rstrip().endswith(":"), text
            pages[who] = "\n".join(told)
        wanted = (
            "/book",
            "/wish",
            "/role",
            "/ask",
            "/plan ·",
            "/lock",
            "/fleet",
            "/task",
            "/alerts",
        )
        assert all(verb in pages[ADA] for verb in wanted)
        assert all(verb in pages[BO] for verb in ("/book", "/wish", "/resume", "/ask"))
        assert "/plan ·" not in pages[BO]
        assert "/role" not in pages[BO], "who gives no rights is refused there"
        assert "/resume" not in pages[VI]
        assert "/people" not in pages[BO]
        assert "/ask" in pages[VI]
        assert "/wish" not in pages[VI], "they move nothing"
        assert "move 0.5 m" not in pages[VI]
        await place.say("help")
        labels = [button.label for row in place.last()[1].buttons for button in row]
        assert labels[:5] == ["Move", "See", "Share", "Fleet", "Alarms"]
        await place.tap(*place.button("Alarms"))
        assert place.last()[1].text.startswith("Alarms:")


async def test_examples_of_help_may_be_sent_as_they_are() -> None:
    async with Place().open() as place:
        told = await place.say("help move") + await place.say("help fleet")
        examples = [line.strip() for line in told.splitlines() if line.startswith(("  cf", "  sw"))]
        assert examples == ["cf1 move 0.5 m", "swarm move 0.5 m"]
        for example in examples:
            assert "moved" in await place.say(example) or place.acted("cf1")
        assert place.acted("cf1") == 2


async def test_robots_lists_them_and_a_name_alone_shows_its_buttons() -> None:
    async with Place().open() as place:
        await place.say("stop kuka1")
        told = await place.say("robots")
        assert "kuka1: stopped by you · free" in told
        assert "omni: at rest · free" in told
        await place.say("omni")
        shown = place.last()[1]
        labels = [button.label for row in shown.buttons for button in row]
        assert shown.text.startswith("omni can:")
        assert {"Move", "Wave", "STOP"} <= set(labels)
        told = await place.say("swarm")
        assert told.startswith("cf1, cf2 can:")
        assert told.count("can:") == 1


async def test_a_robots_own_words_reach_whoever_spoke_to_it_last_and_are_inert() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", account=BO, chat="2")
        await place.say("status", account=VI, chat="3")
        before = len(place.chat.told)
        place.gateway._robot_says(place.robot("omni").profile, "stuck\u202e at aisle 4\x00")
        await place.quiet()
        told = list(place.chat.told)[before:]
        assert [(one.outbound.chat.id, one.outbound.text) for one in told] == [
            ("2", "omni: stuck at aisle 4")
        ]


async def test_whoever_may_not_see_a_robot_any_more_does_not_hear_it() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", account=BO, chat="2")
        await place.revoke("Bo")
        before = len(place.chat.told)
        place.gateway._robot_says(place.robot("omni").profile, "hello")
        await place.quiet()
        assert len(place.chat.told) == before


async def test_a_restart_revives_nobody_and_takes_new_people_over() -> None:
    place = Place()
    async with place.open():
        await place.revoke("Bo")
    again = Place(place.store, place.latch)
    new = ConfiguredPerson("Cy", (Address("memory", "4"),), ("operator",))
    again.gateway._settings = type(again.gateway._settings)(
        profiles=again.gateway._settings.profiles,
        people=(*again.gateway._settings.people, new),
        limit=again.gateway._settings.limit,
    )
    async with again.open():
        told = await again.say("omni move 1 m", account=BO, chat="2", message="a")
        assert told == "Your access here has ended. The admin of this place can renew it."
        await again.say("omni move 1 m", account="4", chat="4", message="b")
        assert again.acted() == 1
