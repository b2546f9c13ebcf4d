"""A plan is shown first, and stands only by a tap of whoever asked, as it was shown."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.core.message import ChatKind
from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules, SkillPrecondition
from rosic.features.scheduled_orders.schedule import IN_ALL_AT_MOST, OF_ONE_AT_MOST, fact_of
from rosic.stores.memory import MemoryStore
from tests.features.scheduled_orders.planning import (
    HOUR_S,
    MINUTE_S,
    lab,
    later,
    plan,
    quick,
    schedule,
)
from tests.gateway.place import BO, VI, Place


async def test_a_plan_is_shown_and_stands_only_once_it_is_tapped() -> None:
    async with lab().open() as here:
        shown = await here.say("/at tomorrow 8:00 omni move 1 m; wave then kuka1 wave")
        assert shown == (
            "Tomorrow 08:00 (Europe/Berlin):\n"
            "1. omni: move, 1.00 m forward\n"
            "2. omni: wave\n"
            "3. kuka1: wave\n"
            "As you, if you may then."
        )
        assert not schedule(here).orders
        assert await here.say("/planned") == "You have planned nothing."
        await here.say("/at tomorrow 8:00 omni move 1 m")
        told = await here.tap(*here.button("Plan it"))
        assert told == "Planned as 1: tomorrow 08:00."
        assert "1: tomorrow 08:00: omni move 1 m" in await here.say("/planned")
        await here.say("/at 15:00 omni wave")
        assert await here.tap(*here.button("Leave it")) == "Nothing was done."
        assert len(schedule(here).orders) == 1


async def test_a_plan_stands_by_the_same_person_once_and_not_by_words() -> None:
    async with lab().open() as here:
        await here.say("/at 15:00 omni wave")
        button, under = here.button("Plan it")
        await here.tap(button, under, account=BO)
        assert not schedule(here).orders, "somebody else"
        typed = button.command.split()[-1]
        told = await here.say(f"/planned keep {typed}")
        assert told == "That is planned by the button beneath the plan. Nothing was planned."
        await here.tap(button, under)
        await here.tap(button, under)
        assert len(schedule(here).orders) == 1


async def test_a_question_that_was_settled_or_withdrawn_plans_nothing() -> None:
    async with lab().open() as here:
        await here.say("/at 15:00 omni wave")
        button, under = here.button("Plan it")
        await here.say("cancel")
        await here.clock.advance(1)
        told = await here.tap(button, under)
        assert told == "That question is settled already. Nothing was planned."
        assert not schedule(here).orders


async def test_whoever_taps_agrees_to_what_was_shown_under_the_same_rules() -> None:
    async with lab().open() as here:
        await here.say("/at 15:00 omni wave")
        button, under = here.button("Plan it")
        await here.say("/grant Vi operator omni for 2h")
        told = await here.tap(button, under)
        assert "would be something else by now. Nothing was planned. Say it again." in told
        assert not schedule(here).orders


async def test_a_time_that_is_over_when_it_is_tapped_is_not_planned() -> None:
    async with lab().open() as here:
        await here.say("/in 20 s omni wave")
        button, under = here.button("Plan it")
        await here.clock.advance(21)
        assert await here.tap(button, under) == "That time is over. Nothing was planned."


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("/at omni wave", "I read no time in that. Say when, and what: /at tomorrow 8:00"),
        ("/at 15:00", "Say what is to be done then. Nothing was planned."),
        ("/in 5 min", "Say what is to be done then."),
        ("/at 15:00 omni mvoe 1 m", 'omni has no "mvoe". Did you mean move?'),
        ("/at 15:00 omni move 40 m", "omni: one move may be at most 5 m. Nothing was done."),
        ("/at 15:00 omni wave; /me", "Only orders to robots can be planned, and this is none: "),
        ("/at 2026-11-20 8:00 omni wave", "That time is over. Nothing was planned."),
        ("/at now omni wave", "That time is over. Nothing was planned."),
        ("/every monday until 2026-11-22 8:00 omni wave", "I read no time in that."),
        ("/in 400 days omni wave", "That is further away than a year. Nothing was planned."),
        ("/in 0 min omni wave", "That time is over. Nothing was planned."),
        (
            "/at 15:00 " + "; ".join(["omni wave"] * 21),
            "That has more than 20 steps. Nothing was planned.",
        ),
        ("/at 15:00 omni move " + "1" * 1000, "characters; I read at most 1000."),
        ("/unplan 7", "You have planned nothing like that: 7."),
        ("/cancel planned 7", "You have planned nothing like that: 7."),
        ("cancel planned dance", "You have planned nothing like that: dance."),
        ("/planned go 7", "You have planned nothing like that: 7."),
        ("/unplan", "You have planned nothing."),
    ],
)
async def test_what_cannot_be_planned_is_said_in_one_sentence(line: str, sentence: str) -> None:
    async with lab().open() as here:
        assert sentence in await here.say(line)
        assert not schedule(here).orders
        assert not here.gateway.rooms.linker.queues["omni"].current


async def test_what_could_be_said_instead_is_offered_as_a_whole() -> None:
    async with lab().open() as here:
        await here.say("/at 15:00 omni wave; mvoe 1 m")
        button, under = here.button("/at 15:00 omni wave; omni move 1 m")
        assert "2. omni: move, 1.00 m forward" in await here.tap(button, under)
        await here.say("/every day 18:30 omni move 40 m")
        here.button("/at every day 18:30 omni move 5 m")


async def test_whoever_may_not_do_it_cannot_plan_it() -> None:
    async with lab().open() as here:
        told = await here.say("/at 15:00 omni wave", account=VI, chat=VI)
        assert "Ada can give it" in told or "may not" in told, told
        assert not schedule(here).orders


class Careful(Place):
    rulebook = RoleRules(
        roles=DEFAULT_ROLES, care=(SkillPrecondition(scopes=("omni:wave",), confirm=True),)
    )


async def test_what_wants_a_tap_each_time_cannot_be_planned() -> None:
    async with lab(place=Careful).open() as here:
        told = await here.say("/at 15:00 omni wave")
        assert told == "omni does this only when somebody confirms it: Wave. It cannot be planned."


async def test_one_person_plans_so_much_and_no_more() -> None:
    async with lab().open() as here:
        for _ in range(OF_ONE_AT_MOST):
            await plan(here, "/at 15:00 omni wave")
        told = await here.say("/at 15:00 omni wave")
        assert "You have planned 20 times already. Cancel some first." in told
        assert len(schedule(here).orders) == OF_ONE_AT_MOST
        assert "Planned as 21" in await plan(here, "/at 15:00 omni wave", BO)
        await here.say("/unplan 3")
        await here.say("/at 15:00 omni wave")
        first = here.button("Plan it")
        await here.say("/at 15:00 omni wave")
        second = here.button("Plan it")
        assert "Planned as 22" in await here.tap(*first), "no number is given twice"
        assert "You have planned 20 times already" in await here.tap(*second)


async def test_all_together_plan_so_much_and_no_more() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni wave")
        kept = schedule(here)
        for number in range(2, IN_ALL_AT_MOST + 1):
            order = replace(kept.orders["1"], author=f"p{number}")
            kept.apply(fact_of(str(number), order, kept.texts["1"]))
        told = await here.say("/at 15:00 omni wave", account=BO, chat=BO)
        assert told == "2000 times are planned here already. Nothing was planned."


async def test_it_is_cancelled_by_its_number_by_words_and_by_a_button() -> None:
    async with lab().open() as here:
        for line in (
            "/at 15:00 omni wave",
            "/every monday 8:00 omni move 1 m",
            "/at 16:00 cf1 wave",
        ):
            await plan(here, line)
        told = await here.say("/planned")
        assert told == (
            "1: 15:00: omni wave\n"
            "3: 16:00: cf1 wave\n"
            "2: every Mon 08:00, next Mon 23 Nov 08:00: omni move 1 m"
        )
        told = await here.say("cancel planned wave")
        assert told.startswith("That may be several of them: wave. Which one?\n1: 15:00")
        assert len(schedule(here).orders) == 3
        assert await here.say("cancel planned monday order") == (
            "Planned order 2 is taken back: omni move 1 m."
        )
        await here.say("/planned")
        assert await here.tap(*here.button("Cancel 1")) == (
            "Planned order 1 is taken back: omni wave."
        )
        assert "Planned order 3 is taken back" in await here.say("/cancel planned 3")
        assert not schedule(here).orders
        await later(here, 6 * HOUR_S)
        assert here.acted() == here.acted("cf1") == 0


async def test_others_see_and_cancel_nothing_but_whoever_assigns_tasks_may() -> None:
    async with lab().open() as here:
        await plan(here, "/at 15:00 omni wave", BO)
        await plan(here, "/at 15:00 omni wave")
        assert "1:" not in await here.say("/planned")
        assert "Ada has planned that" in await here.say("/unplan 2", account=BO, chat=BO)
        assert len(schedule(here).orders) == 2
        told = await here.say("/unplan 1")
        assert "Planned order 1 is taken back: omni wave." in told
        assert "Ada has taken your planned order 1 back: omni wave." in told


async def test_words_of_people_who_talk_to_each_other_plan_nothing_and_are_not_answered() -> None:
    async with lab().open() as here:
        await here.say("use omni")
        group = {"kind": ChatKind.GROUP, "chat": "-5"}
        for line in (
            "in 10 min I am there",
            "every day the same",
            "in any case 5 of us come",
            "in the end omni was slow",
            "every day omni moves",
        ):
            assert await here.say(line, **group) == ""
        assert "I read no time" in await here.say("/in a while I am there", **group)
        assert "no" in await here.say("in 10 min omni dances", **group)
        told = await here.say("in 10 min omni wave", **group)
        assert told.endswith("As you, if you may then.")


async def test_the_times_of_a_plan_are_those_of_whoever_plans() -> None:
    async with lab().open() as here:
        await here.say("/settings zone Asia/Tokyo", account=BO, chat=BO)
        told = await here.say("/at 20:00 omni wave", account=BO, chat=BO)
        assert told.startswith("20:00 (Asia/Tokyo):\n")
        await here.tap(*here.button("Plan it"), account=BO)
        [order] = schedule(here).orders.values()
        assert (
            order.when.at_ns == here.clock.wall_ns() // 10**9 // 3600 * 3600 * 10**9 + 3600 * 10**9
        )


async def test_a_delay_is_to_the_second() -> None:
    async with lab().open() as here:
        quick(here)
        await here.clock.advance(17.25)
        await plan(here, "in 1 min 30 s omni wave")
        assert await later(here, 1.5 * MINUTE_S - 5) == ""
        assert "omni: wave · planned 1" in await later(here, 6)


async def test_a_number_without_a_unit_is_asked_of_whoever_reads_feet() -> None:
    async with lab().open() as here:
        await here.say("/settings units imperial")
        told = await here.say("/at 15:00 omni move 2")
        assert "Say the unit of 2" in told
        here.button("/at 15:00 omni move 2 m")


async def test_erased_words_take_their_plans_along() -> None:
    store = MemoryStore()
    async with lab(store).open() as here:
        await plan(here, "/at 15:00 omni wave", BO)
        await here.say("/forget me", account=BO, chat=BO)
        for _ in range(3):
            rows = here.last()[1].buttons
            if not rows:
                break
            await here.tap(rows[0][0], here.last()[0], account=BO)
        assert not schedule(here).orders
    async with lab(store).open() as here:
        assert not schedule(here).orders


async def test_a_german_reads_and_says_it_in_german() -> None:
    async with lab().open() as here:
        await here.say("/settings language de")
        told = await here.say("/um morgen 8:00 omni move 1 m; wave")
        assert told == (
            "Morgen 08:00 (Europe/Berlin):\n"
            "1. omni: move, 1,00 m vorwärts\n"
            "2. omni: wave\n"
            "In deinem Namen, wenn du es dann darfst."
        )
        await here.tap(*here.button("Einplanen"))
        told = await here.say("/jeden montag 8:00 omni wave")
        assert "Jeden Mo 08:00, nächstes Mal Mo 23 Nov. 08:00" in told, told
        await here.tap(*here.button("Einplanen"))
        assert "1: morgen 08:00: omni move 1 m" in await here.say("/geplant")
        assert "zurückgenommen" in await here.say("/geplant absagen montag")
        assert len(schedule(here).orders) == 1
