"""Where a platform takes only so much: the most important thing first, in its newest words."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING

from rosic.core.message import Chat, ChatKind, Outbound, SendPriority
from rosic.errors import MessengerFault
from rosic.gateway.delivery.chat_queue import (
    ANSWERS_AT_MOST,
    ASKERS_REMEMBERED,
    UNSAID_AT_MOST,
    ChatQueue,
    OutgoingMessage,
)
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from tests.gateway.place import ADA, BO, FLEET, Place

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    import pytest


class Paced(MemoryMessenger):
    """Takes something whenever the test says so.

    Attributes:
        breaks: What is sent arrives, and its sender is told that it may not have.
    """

    def __init__(self, clock: object) -> None:
        super().__init__("memory", clock=clock)  # type: ignore[arg-type]
        self.asked: list[tuple[SendPriority, asyncio.Future[None]]] = []
        self.breaks = False

    async def turn(self, chat: Chat, weight: SendPriority) -> None:
        del chat
        given = asyncio.get_running_loop().create_future()
        self.asked.append((weight, given))
        await given

    async def send(self, outbound: Outbound) -> str:
        message = await super().send(outbound)
        if self.breaks:
            fault = MessengerFault("It may or may not have arrived.")
            fault.perhaps_sent = True
            raise fault
        return message

    @property
    def waiting(self) -> list[SendPriority]:
        return [weight for weight, given in self.asked if not given.done()]

    def give(self) -> None:
        next(given for _, given in self.asked if not given.done()).set_result(None)


@asynccontextmanager
async def paced(store: MemoryStore | None = None) -> AsyncIterator[tuple[Place, Paced]]:
    place = Place(store, chat=Paced)
    assert isinstance(place.chat, Paced)
    async with place.open():
        yield place, place.chat
        for _ in range(30):
            place.chat.turn = None  # type: ignore[assignment,method-assign]
            for _weight, given in place.chat.asked:
                if not given.done():
                    given.set_result(None)
            await place.quiet()


async def one(place: Place, chat: Paced) -> str:
    """Give a turn; return what was said in it."""
    before = len(chat.told)
    chat.give()
    await place.quiet()
    (told,) = list(chat.told)[before:]
    return told.outbound.text


async def test_an_outcome_goes_before_an_answer_and_progress_goes_last() -> None:
    async with paced() as (place, chat):
        place.robot("omni").work_s = 300.0
        await place.say("omni wave")
        assert "accepted" in await one(place, chat) or chat.told
        await place.say("status")
        assert chat.waiting == [SendPriority.QUESTION]
        place.robot("omni").finish()
        await place.quiet()
        assert chat.waiting == [SendPriority.OUTCOME], (
            "what has become important asks with its weight"
        )
        assert "done" in await one(place, chat)
        assert "at rest" in await one(place, chat)


async def test_what_is_said_is_chosen_when_its_turn_has_come() -> None:
    async with paced() as (place, chat):
        await place.say("omni wave")
        await place.say("omni fly")
        said = await one(place, chat)
        assert "done" in said, "the order has ended since it was accepted"


async def test_a_life_that_is_over_is_one_message_where_others_wait() -> None:
    store = MemoryStore()
    async with paced(store) as (place, chat):
        for robot in ("omni", "kuka1", "cf1"):
            await place.say(f"{robot} wave")
        # The first two have others behind them; the last says its ending by an edit, as ever.
        shown = [await one(place, chat) for _ in range(4)]
        assert ["done" in text for text in shown] == [True, True, False, True]
        assert [told.edited for told in chat.told] == [False, False, False, True]
        assert chat.waiting == []
    assert not store._open_orders or (await store.open()).unfinished == ()


async def test_what_may_stand_there_already_is_said_again_with_a_mark() -> None:
    async with paced() as (place, chat):
        for robot in ("omni", "kuka1"):
            await place.say(f"{robot} wave")
        chat.breaks = True
        assert "twice" not in await one(place, chat)
        chat.breaks = False
        await place.clock.advance(1.0)
        while chat.waiting:
            chat.give()
            await place.quiet()
        again = [
            m
            for m in {t.message for t in chat.told}
            if "may stand here twice" in chat.shown(m).text
        ]
        assert len(again) == 1


async def test_a_stop_asks_for_no_turn_of_its_chat() -> None:
    async with paced() as (place, chat):
        await place.say("status")
        told = await place.say("stop omni", account=ADA)
        assert "STOP: omni at rest" in told
        assert chat.waiting == [SendPriority.QUESTION]


assert FLEET[0].id == "omni"


async def test_a_full_queue_says_what_answers_the_newest_message_and_logs_what_it_drops(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with paced() as (place, chat):
        before = len(chat.told)
        sender = place.gateway.pipeline._chat_sender
        for number in range(UNSAID_AT_MOST + 50):
            asked = Outbound(chat=Chat("memory", ADA), text=f"question {number}")
            sender.say(OutgoingMessage(chat, asked))
        await place.say("robots", chat=ADA)
        queue = sender._queues[chat.name, ADA]
        assert len(queue.items) <= UNSAID_AT_MOST
        newest = queue.items[-1]
        assert isinstance(newest, OutgoingMessage)
        assert "Which robot?" in newest.outbound.text
        assert "1 messages were dropped there" in caplog.text
        assert len(chat.told) == before


GROUP = "-100"


async def test_whoever_asks_for_much_in_a_group_keeps_nobody_elses_answer_waiting() -> None:
    async with paced() as (place, chat):
        for _ in range(ANSWERS_AT_MOST + 40):
            await place.say("status", chat=GROUP, kind=ChatKind.GROUP)
        await place.say("help", chat=GROUP, kind=ChatKind.GROUP, account=BO)
        said = [await one(place, chat) for _ in range(2)]
        assert sum("at rest" in text for text in said) == 1, said
        place.robot("omni").work_s = 300.0
        await place.say("omni wave", chat=GROUP, kind=ChatKind.GROUP, account=BO)
        said = [await one(place, chat) for _ in range(2)]
        assert sum("wave" in text for text in said) == 1, said
        place.robot("omni").finish()
        await place.quiet()
        assert "done" in await one(place, chat), "how an order ended goes before every answer"


async def test_refusals_of_one_person_keep_nobody_elses_answer_waiting() -> None:
    async with paced() as (place, chat):
        for _ in range(20):
            await place.say("omni fly", chat=GROUP, kind=ChatKind.GROUP)
        await place.say("status omni", chat=GROUP, kind=ChatKind.GROUP, account=BO)
        said = [await one(place, chat) for _ in range(3)]
        assert sum("at rest" in text for text in said) == 1, said


async def test_who_has_too_many_answers_waiting_reads_how_many_were_left_out() -> None:
    store = MemoryStore()
    async with paced(store) as (place, chat):
        for _ in range(ANSWERS_AT_MOST + 3):
            await place.say("omni fly", chat=GROUP, kind=ChatKind.GROUP)
        queue = place.gateway.pipeline._chat_sender._queues[chat.name, GROUP]
        assert len(queue.items) == ANSWERS_AT_MOST
        assert "(3 earlier answers to you were left out" in await one(place, chat)
        assert "left out" not in await one(place, chat)
        while chat.waiting:
            await one(place, chat)
    assert (await store.open()).unfinished == ()


async def test_whom_a_busy_group_has_answered_is_remembered_within_bounds() -> None:
    async with paced() as (place, chat):
        sender = place.gateway.pipeline._chat_sender
        queue = ChatQueue(sender, chat.name, place.clock, None, shared=True)
        for number in range(2 * ASKERS_REMEMBERED):
            for asker in (f"p{number}", f"p{number}"):
                asked = Outbound(chat=Chat("memory", GROUP), text=asker)
                queue.items.append(OutgoingMessage(chat, asked, asker=asker))
            queue.take()
            queue.items.popleft()
            queue.items.append(OutgoingMessage(chat, Outbound(chat=Chat("memory", GROUP), text="")))
        assert len(queue.answered) <= ASKERS_REMEMBERED
