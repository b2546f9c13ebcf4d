"""Shared data between containers: lent by name, to a person or a robot, for a while or for good."""

from __future__ import annotations

import pytest

from rosic.core.message import ChatKind
from tests.features.personal_data.data_gateway import a_ward
from tests.gateway.place import ADA, BO, VI


async def test_what_is_lent_is_read_by_whom_it_was_lent_to_and_by_nobody_else() -> None:
    async with a_ward() as ward:
        await ward.said("data", "bay = four", account=BO)
        await ward.said("data", "safe = 0815", account=BO)
        reply = await ward.ask("share", "bay with Vi", account=BO)
        assert reply.text == 'Vi can read "bay" until you take it back.'
        await ward.quiet()
        told = ward.chat.told[-1].outbound
        assert (told.chat.id, told.text) == (VI, 'Bo shares "bay" with you: /shelf shows it.')
        assert await ward.said("shelf", account=VI) == (
            "Shared with you:\n  bay: four (Bo, 0 s ago)"
        )
        assert "four" not in await ward.said("shelf", account=ADA)
        mine = await ward.ask("shelf", account=BO)
        assert mine.text == (
            "You keep:\n  bay: four (Bo, 0 s ago)\n  safe: 0815 (Bo, 0 s ago)\n"
            "  (2 of 64 names, 15 bytes of 64 KiB)\nYou share:\n  bay with Vi"
        )
        (back,) = mine.buttons[0]
        assert back.label == "Take back from Vi"
        verb, _, rest = back.command.removeprefix("/").partition(" ")
        assert "yours alone again" in await ward.said(verb, rest, account=BO)
        assert (await ward.said("shelf", account=VI)).startswith("You keep nothing, and nobody")


async def test_lent_to_a_robot_is_lent_to_whoever_sees_it_and_for_two_hours() -> None:
    async with a_ward() as ward:
        await ward.said("data", "bay = four", account=BO)
        assert (await ward.said("share", "bay with omni for 2h", account=BO)).startswith(
            'omni can read "bay" until '
        )
        assert "bay: four" in await ward.said("shelf", account=VI)
        await ward.said("data", "bay = five", account=BO)
        assert "bay: five" in await ward.said("shelf", account=VI)
        ward.clock.jump_wall(7_201)
        assert "five" not in await ward.said("shelf", account=VI)
        assert "You share" not in await ward.said("shelf", account=BO)


@pytest.mark.parametrize(
    ("rest", "answer"),
    [
        ("", "Write what and with whom: /share bay with Bo"),
        ("bay", "Write what and with whom"),
        ("bay with", "Write what and with whom"),
        ("bay with Zeno", 'I know nobody and no robot called "Zeno".'),
        ("key with Vi", 'You keep nothing called "key". Nothing was shared.'),
        ("bay with Vi for ever", "Say for how long as 30 min, 2h or 3 days"),
        ("bay with Vi for 0 h", "Say for how long"),
        ("bay with Bo", "That is yours already."),
        ("back bay", 'You share nothing called "bay" so.'),
        ("back bay from Vi", 'You share nothing called "bay" so.'),
        ("x" * 400, "That line has 400 characters; I read at most 300."),
    ],
)
async def test_what_cannot_be_shared(rest: str, answer: str) -> None:
    async with a_ward() as ward:
        await ward.said("data", "bay = four", account=BO)
        assert (await ward.said("share", rest, account=BO)).startswith(answer)
        assert not ward.shelf.lending.by(ward.id_of(BO))


async def test_of_one_s_own_is_spoken_in_private_alone_and_it_ends_with_its_owner() -> None:
    async with a_ward() as ward:
        await ward.said("data", "bay = four", account=BO)
        for verb, rest in (("share", "bay with Vi"), ("shelf", "")):
            said = await ward.said(verb, rest, account=BO, kind=ChatKind.GROUP)
            assert said == "Ask me that in a private chat with me, please."
        await ward.said("share", "bay with Vi", account=BO)
        await ward.sure("forget", "me", account=BO)
        assert "four" not in await ward.said("shelf", account=VI)
        assert not ward.shelf.lending._at


async def test_typed_in_a_chat_it_goes_the_whole_way() -> None:
    async with a_ward() as ward:
        await ward.say("/data bay = four", account=BO, chat=BO)
        await ward.say("/share bay with Vi for 2h", account=BO, chat=BO)
        assert "bay: four (Bo" in str(await ward.say("/shelf", account=VI, chat=VI))
