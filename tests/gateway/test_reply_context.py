"""A reply to a robot's message means that robot; a topic may be about one."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace

from rosic.core.message import Chat, ChatKind
from rosic.gateway.reply_context import REMEMBERED
from tests.gateway.place import ADA, BO, VI, Place

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


# ---- what is forgotten ----

WHERE = {"in a group": LAB, "in private": {"chat": ADA, "kind": ChatKind.PRIVATE}}


async def _reply(place: Place, text: str, answers: str, where: dict[str, Any]) -> None:
    """Reply to a message that an earlier run has sent; its messenger still says whose it was."""
    chat = Chat("memory", where["chat"], where["kind"])
    inbound = place.chat._inbound(ADA, chat, f"new-{text}", None)
    ours = {"answers": answers, "answers_us": True, "addressed": True}
    place.chat.deliver(replace(inbound, text=text, **ours))
    await place.quiet()


@pytest.mark.parametrize("where", WHERE.values(), ids=WHERE)
async def test_a_reply_to_a_life_of_an_earlier_run_asks_which_robot(where: dict[str, Any]) -> None:
    first = Place()
    async with first.open() as place:
        await place.say("omni move 1 m", **where)
        life = place.last()[0]
        await place.say("use kuka1", **where)
    async with Place(first.store, first.latch, clock=first.clock).open() as place:
        await _reply(place, "wave", life, where)
        told, asked = place.last()
        assert place.acted() == 0
        assert asked.text.startswith("Which robot is to")
        labels = [button.label for row in asked.buttons for button in row]
        assert "omni wave" in labels
        assert all(label.split()[0] in {"cf1", "cf2", "kuka1", "omni"} for label in labels)
        await _reply(place, "omni wave", told, where)
        assert (place.acted("omni"), place.acted("kuka1")) == (1, 0)


async def test_so_does_one_to_a_life_that_many_others_came_after() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m", **LAB)
        life = place.last()[0]
        await place.say("use kuka1", **LAB)
        targets = place.gateway.pipeline._chat_sender.reply_targets
        for number in range(2 * REMEMBERED):
            targets.note("memory", Chat("memory", VI), f"later-{number}", "omni")
        await place.say("wave", answers=life, **LAB)
        assert place.acted("kuka1") == 0
        assert place.last()[1].text.startswith("Which robot is to")


async def test_a_reply_to_what_a_person_wrote_asks_whether_the_chosen_robot_is_meant() -> None:
    async with Place().open() as place:
        await place.say("use kuka1", **LAB)
        await place.say("hello there", account=BO, message="of-bo", **LAB)
        told = await place.say("wave", answers="of-bo", **LAB)
        assert told == "kuka1: wave? People talk here, so it moves only if you confirm it."
        assert place.acted("kuka1") == 0
        await place.tap(*place.button("Do it"))
        assert place.acted("kuka1") == 1


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
