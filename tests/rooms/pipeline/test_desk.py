"""Questions that move nothing, and what robots say of their own accord."""

from __future__ import annotations

from rosic.app.placing.people import Seed
from rosic.core.identity import Address
from tests.rooms.pipeline.place import BO, VI, Place


async def test_status_says_who_has_what_and_what_it_does() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni move 1 m")
        await place.say("stop kuka1")
        told = await place.say("status")
        assert "omni: doing move · taken by Ada" in told
        assert "kuka1: stopped by Ada" in told
        assert "cf1: at rest · free" in told


async def test_status_of_one_robot_and_of_one_that_is_away() -> None:
    async with Place().open() as place:
        place.robot("omni").online = False
        assert (
            await place.say("status omni") == "omni: not there, last heard 0 s ago · at rest · free"
        )


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


async def test_help_names_what_can_be_asked_for_beside_orders_by_whoever_may() -> None:
    async with Place().open() as place:
        admins = await place.say("help")
        assert all(verb in admins for verb in ("/book", "/wish", "/role", "/ask", "/plan", "/lock"))
        operators = await place.say("help", account=BO, chat=BO)
        assert all(verb in operators for verb in ("/book", "/wish", "/role", "/ask"))
        assert "/plan" not in operators
        assert "/people" not in operators
        viewers = await place.say("help", account=VI, chat=VI)
        assert "/ask" in viewers
        assert "/wish" not in viewers, "they move nothing"


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
        bo = place.gateway.rooms.authoriser.directory.named("Bo")[0].id
        await place.gateway.revoke(bo, "test")
        before = len(place.chat.told)
        place.gateway._robot_says(place.robot("omni").profile, "hello")
        await place.quiet()
        assert len(place.chat.told) == before


async def test_a_restart_revives_nobody_and_takes_new_people_over() -> None:
    place = Place()
    async with place.open():
        bo = place.gateway.rooms.authoriser.directory.named("Bo")[0].id
        await place.gateway.revoke(bo, "test")
    again = Place(place.store, place.latch)
    new = Seed("Cy", (Address("memory", "4"),), ("operator",))
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
