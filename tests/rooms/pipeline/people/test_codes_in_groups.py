"""A code where many can read it: burnt, told to the admins, and nobody learns if it was good."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.authoriser import words_entry
from rosic.authoriser.invitation import State
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind
from tests.rooms.pipeline.people.hall import ADA, BO, CY, DI, BrokenStore, a_hall


async def test_a_code_in_a_group_is_burnt_and_the_admins_are_told() -> None:
    async with a_hall() as hall:
        code = await hall.invited("operator kuka1 for 2h")
        said = await hall.in_group(CY, f"Di, this is for you: {code}")
        assert said == words_entry.IN_GROUP
        alarm = (
            "A code for operator on kuka1 for 2 hours was shown in a group. It is not good any "
            "more. Invite again, and send the code to one person."
        )
        assert hall.last(ADA).text == hall.last(BO).text == alarm
        assert hall.last(ADA).urgent
        assert await hall.say(DI, code) == words_entry.NOT_GOOD
        assert hall.tally["code-in-group"] == 1


async def test_every_code_of_a_message_in_a_group_is_burnt() -> None:
    async with a_hall() as hall:
        codes = [await hall.invited("viewer") for _ in range(3)]
        await hall.in_group("88", " or ".join(codes))
        assert not hall.enrolment.invitations.open()
        found = [hall.enrolment.invitations.find(code) for code in codes]
        assert [made.state for made in found if made] == [State.BURNT] * 3
        assert hall.told(ADA).count("was shown in a group") == 3


async def test_a_group_does_not_learn_which_codes_are_good() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        assert await hall.in_group(DI, "/start ABCD-0000") == words_entry.IN_GROUP
        assert await hall.in_group(DI, f"/start {code}") == words_entry.IN_GROUP
        # A button would let somebody in whom the group sees.
        assert hall.labels("g") == []


async def test_people_who_talk_in_a_group_are_left_alone() -> None:
    async with a_hall() as hall:
        for text in ("join tomorrow at 5", "left-hand", "let us start now", "omni-move"):
            assert await hall.in_group(DI, text) == "", text
        assert not hall.tally.by_kind()


async def test_a_code_in_a_group_is_burnt_with_the_disk_full() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        code = await hall.invited("viewer")
        store.broken = True
        assert await hall.in_group(CY, code) == words_entry.IN_GROUP
        assert await hall.say(DI, code) == words_entry.NOT_GOOD


async def test_a_button_of_a_private_chat_is_dead_in_a_group() -> None:
    async with a_hall() as hall:
        await hall.say(DI, await hall.invited("viewer"))
        join, _ = hall.button(DI, "Join")
        group = Chat(hall.chat.platform, "g", ChatKind.GROUP)
        tap = hall.chat.say("", account=DI, chat="elsewhere")
        hall.chat.deliver(replace(tap, chat=group, message="t1", nonce=join.nonce, tap="t1"))
        await hall.quiet()
        assert hall.chat.answers[-1] == ("t1", "This question was asked of somebody else.")
        assert hall.directory.at(Address("telegram", DI)) is None
