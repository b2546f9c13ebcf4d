"""A mission is put together in a chat: each line is a step, and no robot does any of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.fleet.mission import Mission, MissionPart
from rosic.core.fleet.task import TaskState
from rosic.core.message import ChatKind
from rosic.core.order import OrderEnding
from rosic.core.records import Fact
from rosic.features.fleet import FleetFeature
from rosic.features.fleet.mission_book import DRAFT, SAVED
from rosic.features.fleet.mission_builder import OF_ONE_AT_MOST, STEPS_AT_MOST
from tests.features.fleet.test_tasks import heard, tasks, worker
from tests.features.scheduled_orders.planning import Recording
from tests.features.scheduled_orders.planning import lab as place_of_workers
from tests.gateway.place import BO, FLEET, VI, Place, profile

if TYPE_CHECKING:
    from rosic.stores.memory import MemoryStore

LOUD = Mission(name="loud", do=(MissionPart(on="omni", steps=("wave",)),))


def lab(store: MemoryStore | None = None) -> Place:
    here = place_of_workers(store, zone="UTC")
    here.gateway._settings = replace(here.gateway._settings, missions=(LOUD,))
    return here


def acted(here: Place) -> int:
    return sum(here.acted(profile.id) for profile in FLEET)


async def test_lines_become_steps_and_are_saved_and_started() -> None:
    async with lab().open() as here:
        told = await here.say("/mission new dance")
        assert told == (
            "dance, which you put together. No robot does any of it now:\n"
            "Type the next step, as you would say it."
        )
        await here.say("omni move 1 m")
        await here.say("use omni")
        await here.say("wave")
        told = await here.say("swarm wave")
        assert told == (
            "dance, which you put together. No robot does any of it now:\n"
            "1. omni: move, 1.00 m forward\n"
            "2. omni: wave\n"
            "3. swarm (cf1, cf2): wave\n"
            "Type the next step, as you would say it."
        )
        assert acted(here) == 0
        told = await here.tap(*here.button("Save"))
        assert told == "dance is saved, for you. What you type is an order again."
        assert acted(here) == 0
        told = await here.tap(*here.button("Start dance"))
        assert "dance is begun as dance-1" in told
        assert (here.acted(), here.acted("cf1")) == (1, 0)
        for _ in range(2):
            worker(here, "omni").end(OrderEnding.DONE)
            await heard(here)
        assert (here.acted(), here.acted("cf1"), here.acted("cf2")) == (2, 1, 1), "all of a group"
        for name in ("cf1", "cf2"):
            worker(here, name).end(OrderEnding.DONE)
        await heard(here)
        assert {task.state for task in tasks(here).values()} == {TaskState.DONE}
        await here.say("omni wave")
        assert here.acted() == 3, "what is typed is an order again"


async def test_a_step_is_undone_and_a_draft_is_left() -> None:
    async with lab().open() as here:
        await here.say("/mission new dance")
        await here.say("omni move 1 m")
        await here.say("omni wave")
        told = await here.tap(*here.button("Undo"))
        assert "1. omni: move" in told
        assert "2." not in told
        told = await here.tap(*here.button("Leave it"))
        assert told == "dance is left. What you type is an order again."
        assert "I know no mission called dance" in await here.say("/mission start dance")
        await here.say("omni wave")
        assert acted(here) == 1


async def test_only_orders_typed_there_by_the_same_person_are_steps() -> None:
    async with lab().open() as here:
        await here.say("/mission new dance")
        await here.say("omni wave", account=BO, chat=BO)
        assert here.acted() == 1, "somebody else's is an order"
        await here.say("cf1 wave", chat="-5", kind=ChatKind.GROUP)
        assert here.acted("cf1") == 1, "elsewhere it is an order"
        assert "1: " not in await here.say("/tasks")
        await here.say("stop omni")
        assert here.gateway.rooms.stops["omni"].latched, "a stop is a stop"
        assert "No robot does any of it now" in await here.say("kuka1 wave")
        assert here.acted("kuka1") == 0


async def test_a_draft_goes_on_over_a_restart_and_what_is_typed_is_no_order() -> None:
    store = Recording()
    async with lab(store).open() as here:
        await here.say("/mission new dance")
        await here.say("omni move 1 m")
    async with lab(store).open() as here:
        told = await here.say("omni wave")
        assert "2. omni: wave" in told
        assert acted(here) == 0
        await here.say("/mission save")
    for record in store.written:
        if isinstance(record, Fact) and record.kind in {SAVED, DRAFT}:
            assert b"dance" not in record.body
            assert "dance" not in record.key
    async with lab(store).open() as here:
        assert "1. omni: move 1 m; wave" in await here.say("/mission dance")
        assert "dance is begun" in await here.say("/mission start dance")
        assert acted(here) == 1


async def test_what_was_left_lying_takes_no_line_in_and_does_none() -> None:
    async with lab().open() as here:
        await here.say("/mission new dance")
        here.clock.jump_wall(31 * 60)
        told = await here.say("omni wave")
        assert "is left, and this line was not done either." in told
        assert acted(here) == 0
        await here.say("omni wave")
        assert acted(here) == 1


async def test_a_mission_is_its_authors_or_with_the_right_everybodys() -> None:
    async with lab().open() as here:
        await here.say("/mission new dance", account=BO, chat=BO)
        await here.say("omni wave", account=BO, chat=BO)
        told = await here.say("/mission share", account=BO, chat=BO)
        assert told.startswith("Only whoever may assign tasks here saves missions for everybody.")
        await here.say("/mission save", account=BO, chat=BO)
        assert "dance" in await here.say("/missions", account=BO, chat=BO)
        assert "dance" not in await here.say("/missions")
        assert "I know no mission called dance" in await here.say("/mission start dance")
        await here.say("/mission new walk")
        await here.say("omni move 1 m")
        told = await here.tap(*here.button("Save for everybody"))
        assert told == "walk is saved for everybody. What you type is an order again."
        assert "walk" in await here.say("/missions", account=BO, chat=BO)
        told = await here.say("/mission start walk", account=VI, chat=VI)
        assert "Nothing was begun." in told
        assert acted(here) == 0, "whoever starts it needs the rights"
        assert "walk is begun" in await here.say("/mission start walk", account=BO, chat=BO)
        assert acted(here) == 1


async def test_what_was_saved_is_forgotten_by_its_author_alone() -> None:
    async with lab().open() as here:
        await here.say("/mission new walk")
        await here.say("omni move 1 m")
        await here.say("/mission share")
        told = await here.say("/mission forget walk", account=BO, chat=BO)
        assert told == "You have saved no mission called walk."
        assert await here.say("/auftrag vergessen walk") == "walk is forgotten."
        assert "I know no mission called walk" in await here.say("/mission start walk")


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("/mission new", "A mission is called by one word"),
        ("/mission new two words", "A mission is called by one word"),
        ("/mission new save", "A mission is called by one word"),
        ("/mission new start", "A mission is called by one word"),
        ("/mission new resume", "A mission is called by one word"),
        ("/mission new loud", "There is a mission called loud already."),
        ("/mission add omni wave", "You put no mission together now."),
        ("/mission save", "You put no mission together now."),
        ("/mission undo", "You put no mission together now."),
        ("/mission forget dance", "You have saved no mission called dance."),
    ],
)
async def test_what_cannot_be_done_is_said_in_one_sentence(line: str, sentence: str) -> None:
    async with lab().open() as here:
        assert sentence in await here.say(line)
        assert acted(here) == 0


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("/mission new other", "You are putting dance together. Save it or leave it first."),
        ("/mission save", "It has no steps yet"),
        ("/mission add /me", "Only orders to robots are steps, and this is none"),
        ("/mission add omni mvoe 1 m", 'omni has no "mvoe". Did you mean move?'),
        ("omni move 40 m", "omni: one move may be at most 5 m."),
        ("omni move", ""),
    ],
)
async def test_a_line_that_is_no_step_changes_nothing(line: str, sentence: str) -> None:
    async with lab().open() as here:
        await here.say("/mission new dance")
        assert sentence in await here.say(line)
        book = here.gateway.features.get(FleetFeature).book
        [draft] = book.drafts.values()
        assert not draft.steps
        assert acted(here) == 0


async def test_nobody_puts_together_what_they_may_not_let_robots_do() -> None:
    async with lab().open() as here:
        await here.say("/mission new dance", account=VI, chat=VI)
        told = await here.say("omni wave", account=VI, chat=VI)
        assert "You may not let omni do this: Wave." in told


async def test_there_are_so_many_steps_and_missions_and_no_more() -> None:
    async with lab().open() as here:
        await here.say("/mission new long")
        for _ in range(STEPS_AT_MOST):
            await here.say("omni wave")
        assert "It has 30 steps already." in await here.say("omni wave")
        await here.say("/mission save")
        for number in range(OF_ONE_AT_MOST - 1):
            await here.say(f"/mission new m{number}")
            await here.say("omni wave")
            await here.say("/mission save")
        told = await here.say("/mission new more")
        assert told.startswith("You have saved 20 missions already.")
        assert acted(here) == 0


async def test_values_are_kept_as_they_were_said() -> None:
    async with lab().open() as here:
        await here.say("/mission new dance")
        await here.say("omni move 100 cm left")
        await here.say("/mission save")
        assert "1. omni: move 100 cm left" in await here.say("/mission dance")


async def test_a_step_for_more_robots_than_a_mission_has_tasks_is_not_added() -> None:
    many = tuple(profile(f"r{number}", groups=("crowd",)) for number in range(110))
    here = place_of_workers(zone="UTC", fleet=(FLEET[0], *many))
    async with here.open():
        await here.say("/mission new dance")
        assert "1. crowd" in await here.say("crowd wave")
        told = await here.say("crowd wave")
        assert told == (
            "A mission has at most 200 tasks, one for each robot of a step. Nothing was added."
        )
