"""A reply to a robot's message means that robot; a topic may be about one."""

from __future__ import annotations

from rosic.core.message import ChatKind
from tests.gateway.place import BO, VI, Place

LAB = {"chat": "-5", "kind": ChatKind.GROUP}


async def test_a_reply_to_a_life_means_its_robot_whatever_was_chosen() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", **LAB)
        life = place.last()[0]
        await place.say("use kuka1", **LAB)
        await place.say("move 1 m", answers=life, **LAB)
        assert (place.acted("omni"), place.acted("kuka1")) == (2, 0)
        await place.say("move 1 m", **LAB)
        assert (place.acted("omni"), place.acted("kuka1")) == (2, 1)


async def test_a_reply_to_what_a_robot_was_chosen_with_means_it_too() -> None:
    async with Place().open() as place:
        await place.say("use kuka1", **LAB)
        chosen = place.last()[0]
        await place.say("use omni", **LAB)
        await place.say("wave", answers=chosen, account=BO, **LAB)
        assert (place.acted("omni"), place.acted("kuka1")) == (0, 1)


async def test_a_name_that_is_said_counts_more() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", **LAB)
        await place.say("kuka1 wave", answers=place.last()[0], **LAB)
        assert (place.acted("omni"), place.acted("kuka1")) == (1, 1)


async def test_a_reply_gives_no_right() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", **LAB)
        told = await place.say("wave", answers=place.last()[0], account=VI, **LAB)
        assert "needs the right" in told
        assert place.acted() == 1


async def test_the_same_number_in_another_chat_is_another_message() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", **LAB)
        life = place.last()[0]
        await place.say("wave", answers=life, account=BO, chat="2")
        assert place.acted() == 1


# ---- topics ----


async def test_what_is_chosen_in_a_topic_holds_there_alone() -> None:
    async with Place().open() as place:
        await place.say("use omni", topic="7", **LAB)
        assert place.last()[1].chat.topic == "7"
        await place.say("use kuka1", topic="8", **LAB)
        await place.say("wave", topic="7", **LAB)
        assert place.last()[1].chat.topic == "7"
        assert (place.acted("omni"), place.acted("kuka1")) == (1, 0)
        await place.say("wave", **LAB)
        assert (place.acted("omni"), place.acted("kuka1")) == (1, 0)


async def test_an_admin_makes_a_topic_mean_a_robot_for_everybody_over_a_restart() -> None:
    first = Place()
    async with first.open() as place:
        assert "about omni" in await place.say("/topic omni", topic="7", **LAB)
        await place.say("wave", topic="7", account=BO, **LAB)
        assert place.acted() == 1
        await place.say("wave", topic="8", account=BO, **LAB)
        assert place.acted() == 1
        assert "needs the right" in await place.say("wave", topic="7", account=VI, **LAB)
    async with Place(first.store, first.latch, clock=first.clock).open() as place:
        assert "about omni" in await place.say("/topic", topic="7", **LAB)
        await place.say("/topic nothing", topic="7", **LAB)
        await place.say("wave", topic="7", account=BO, **LAB)
        assert place.acted() == 0


async def test_who_may_not_or_cannot_is_told() -> None:
    async with Place().open() as place:
        assert "Only an admin" in await place.say("/topic omni", topic="7", account=BO, **LAB)
        assert "no robot nobot" in await place.say("/topic nobot", topic="7", **LAB)
        assert "in a topic" in await place.say("/topic omni", **LAB)
        assert "about no robot" in await place.say("/topic", topic="7", **LAB)
