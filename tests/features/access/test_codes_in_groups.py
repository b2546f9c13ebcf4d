"""A code where many can read it: burnt, told to the admins, and nobody learns if it was good."""

from __future__ import annotations

import asyncio
import re
import time
from random import Random

import pytest
from msgspec.structs import replace

from rosic.authoriser import messages
from rosic.authoriser.invitations import InvitationState
from rosic.authoriser.invite_codes import ALPHABET, SEARCHED_AT_MOST
from rosic.core.identity import Address
from rosic.core.message import Chat, ChatKind, MessageValidity
from tests.features.access.access_handlers import ADA, BO, CY, DI, BrokenStore, a_hall
from tests.gateway.place import Place
from tests.pace import SAMPLE_S, pace, sample_of_work_s

CODE = re.compile(r"\b[0-9A-Z]{4}-[0-9A-Z]{4}\b")


async def test_a_code_in_a_group_is_burnt_and_the_admins_are_told() -> None:
    async with a_hall() as hall:
        code = await hall.invited("operator kuka1 for 2h")
        said = await hall.in_group(CY, f"Di, this is for you: {code}")
        assert said == messages.IN_GROUP
        alarm = (
            "A code for operator on kuka1 for 2 hours was shown in a group. It is not good any "
            "more. Invite again, and send the code to one person."
        )
        assert hall.last(ADA).text == hall.last(BO).text == alarm
        assert hall.last(ADA).urgent
        assert await hall.say(DI, code) == messages.NOT_GOOD
        assert hall.counters["code-in-group"] == 1


async def test_every_code_of_a_message_in_a_group_is_burnt() -> None:
    async with a_hall() as hall:
        codes = [await hall.invited("viewer") for _ in range(3)]
        await hall.in_group("88", " or ".join(codes))
        assert not hall.enrolment.invitations.open()
        found = [hall.enrolment.invitations.find(code) for code in codes]
        assert [made.state for made in found if made] == [InvitationState.BURNT] * 3
        assert hall.told(ADA).count("was shown in a group") == 3


@pytest.mark.parametrize("standing", [s for s in MessageValidity if s is not MessageValidity.FRESH])
async def test_a_code_is_burnt_however_a_group_came_to_read_it(standing: MessageValidity) -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        assert await hall.in_group(CY, f"for Di: {code}", standing=standing) == messages.IN_GROUP
        assert "was shown in a group" in hall.told(ADA)
        assert await hall.say(DI, code) == messages.NOT_GOOD


async def test_what_is_no_code_and_not_followed_gets_no_answer_and_counts_as_no_guess() -> None:
    async with a_hall() as hall:
        said = await hall.in_group(CY, "/start ABCD-0000", standing=MessageValidity.FORWARDED)
        assert said == "(Start)", "nobody is told anything about codes"
        assert not hall.counters.by_kind()


async def test_a_code_in_a_private_message_that_is_forwarded_stays_good() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        await hall.say(DI, code, standing=MessageValidity.FORWARDED)
        assert hall.labels(DI) == []
        await hall.say(DI, code)
        assert "Join" in hall.labels(DI)


async def test_a_code_is_found_behind_much_text_and_among_much_that_looks_like_one() -> None:
    async with a_hall() as hall:
        for before in ("The plan for today. " * 50, "2026-2027 2027-2028 " * 50, "\u2014 "):
            code = (await hall.invited("viewer")).replace("-", "\u2013")
            await hall.in_group(CY, before + code)
            assert not hall.enrolment.invitations.open(), before[:20]


async def test_a_group_does_not_learn_which_codes_are_good() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        assert await hall.in_group(DI, "/start ABCD-0000") == messages.IN_GROUP
        assert await hall.in_group(DI, f"/start {code}") == messages.IN_GROUP
        # A button would let somebody in whom the group sees.
        assert hall.labels("g") == []


async def test_people_who_talk_in_a_group_are_left_alone() -> None:
    async with a_hall() as hall:
        for text in ("join tomorrow at 5", "left-hand", "let us start now", "omni-move"):
            assert await hall.in_group(DI, text) == "", text
        assert not hall.counters.by_kind()


async def test_a_code_in_a_group_is_burnt_with_the_disk_full() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        code = await hall.invited("viewer")
        store.broken = True
        assert await hall.in_group(CY, code) == messages.IN_GROUP
        assert await hall.say(DI, code) == messages.NOT_GOOD


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


WRITTEN = (
    "Hi Di:\njoin {bare}",
    "Hi Di:\njoin {code}",
    "Di, type: join {bare}",
    "Di, type /start {bare}",
    "`/start {bare}`",
    "_{code}_",
    "||{code}||",
    "Di: {first}\u2010{last}",
    "{first}\u2011{last}",
    "{first} - {last}",
    "Di: {first} {last}",
    "Di: {spaced}",
    "join{bare}",
    "{first}\n{last}",
    "https://t.me/lab_bot?start={first}%2D{last}",
    "\u00fcber{bare}",
)


@pytest.mark.parametrize("way", WRITTEN)
async def test_a_code_is_burnt_however_it_is_written(way: str) -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        first, last = code.split("-")
        bare = first + last
        text = way.format(code=code, bare=bare, first=first, last=last, spaced=" ".join(bare))
        hall.chat.say(text, account=CY, chat="g", kind=ChatKind.GROUP)
        await hall.quiet()
        found = hall.enrolment.invitations.find(code)
        assert found is not None
        assert found.state is InvitationState.BURNT
        assert hall.last("g").text == messages.IN_GROUP


@pytest.mark.parametrize("beside", ["links", "written"])
async def test_a_code_is_burnt_that_stands_beside_the_text(beside: str) -> None:
    """Behind a word that is a link; or in a line that is for another bot."""
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        said = hall.chat.say("hello", account=CY, chat="g", kind=ChatKind.GROUP)
        said = replace(said, message="m-beside")
        link = f"https://t.me/lab_bot?start={code}"
        hall.chat.deliver(
            replace(said, links=("https://a.b/c", link))
            if beside == "links"
            else replace(said, text="hello\n", written=f"hello\n@other_bot {code}")
        )
        await hall.quiet()
        assert not hall.enrolment.invitations.open()


async def test_a_message_is_searched_for_codes_within_a_step() -> None:
    async with a_hall() as hall:
        code = await hall.invited("viewer")
        took = []
        for seed in range(5):
            chance = Random(seed)  # noqa: S311 - a seed makes it repeatable
            drawn = chance.choices(ALPHABET, k=SEARCHED_AT_MOST)  # no eight of them twice
            text = f"{''.join(drawn)[: SEARCHED_AT_MOST - 10]} {code}"
            start = time.thread_time()
            shown = hall.enrolment.shown_in(text)
            took.append((time.thread_time() - start) / sample_of_work_s())
            assert shown == (code.replace("-", ""),)
            assert hall.enrolment.shown_in(text) == shown
        assert min(took) * SAMPLE_S < 0.02


@pytest.mark.parametrize(
    "said",
    [
        "omni status\nomni help {code}",
        "stop omni {code}",
        "stop omni\n{code}",
        "omni say {bare}",
        "start {bare}",
    ],
)
async def test_a_whole_gateway_burns_a_code_whatever_else_is_said(said: str) -> None:
    """By somebody who is known: each line may be one that is followed."""
    async with Place().open() as place:
        await place.say("/invite viewer for 2h", chat="1")
        found = None
        async with asyncio.timeout(60 * pace()):
            while found is None:  # a thread draws the picture of its link
                await asyncio.sleep(0.001)
                found = CODE.search("\n".join(told.outbound.text for told in place.chat.told))
        text = said.format(code=found[0], bare=found[0].replace("-", ""))
        place.chat.say(text, account="1", chat="g", kind=ChatKind.GROUP)
        await place.quiet()
        there = [told.outbound.text for told in place.chat.told if told.outbound.chat.id == "g"]
        assert messages.IN_GROUP in there


@pytest.mark.parametrize(
    ("kind", "standing"),
    [*((ChatKind.GROUP, s) for s in MessageValidity), (ChatKind.CHANNEL, MessageValidity.CHANNEL)],
)
async def test_a_whole_gateway_burns_a_code_that_many_read(
    kind: ChatKind, standing: MessageValidity
) -> None:
    async with Place().open() as place:
        await place.say("/invite viewer for 2h", chat="1")
        found = None
        async with asyncio.timeout(60 * pace()):
            while found is None:  # a thread draws the picture of its link
                await asyncio.sleep(0.001)
                found = CODE.search("\n".join(told.outbound.text for told in place.chat.told))
        place.chat.say(f"for Di: {found[0]}", account="2", chat="g", kind=kind, standing=standing)
        await place.quiet()
        there = [told.outbound.text for told in place.chat.told if told.outbound.chat.id == "g"]
        assert there == ([] if kind is ChatKind.CHANNEL else [messages.IN_GROUP])
        assert any("was shown in a group" in told.outbound.text for told in place.chat.told)
