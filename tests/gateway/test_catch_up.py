"""What had piled up while nobody listened is answered once in each chat."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import Chat, ChatKind
from rosic.core.rate_limit import RateLimit
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock, settle
from tests.gateway.place import ADA, BO, VI, Place

if TYPE_CHECKING:
    from rosic.contracts.messenger import Settle
    from rosic.core.records import Record

HOUR_NS = 3_600_000_000_000
GROUP = "-1"


async def old(place: Place, text: str, count: int = 1, **how: object) -> None:
    """Have something arrive that was sent an hour ago, while nobody listened."""
    place.chat.gap()
    for _ in range(count):
        place.chat.say(text, sent_ns=place.clock.wall_ns() - HOUR_NS, **how)  # type: ignore[arg-type]
    await place.quiet()


@pytest.mark.parametrize("also", [True, False])
async def test_many_commands_are_answered_as_one_and_name_the_network_if_it_was_that(
    also: bool,
) -> None:
    async with Place().open() as place:
        place.chat.gap()
        sent_ns = place.clock.wall_ns() - HOUR_NS
        for number in range(5):
            inbound = place.chat._inbound(ADA, Chat("memory", ADA), f"m{number}", sent_ns)
            away = number < 4 or also
            place.chat.deliver(replace(inbound, text="omni wave", network_away=away))
        await place.quiet()
        await place.clock.advance(1.0)
        why = "While the network was away" if also else "While I could not listen"
        assert place.chat.told[-1].outbound.text.startswith(f"{why}, 5 commands came in here.")


async def test_many_commands_are_answered_as_one_and_the_newest_are_on_offer() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        for number in range(1, 6):
            await old(place, f"omni move {number} m", 10)
        assert not place.chat.told, "more of it might come"
        await place.clock.advance(1.0)
        (told,) = place.chat.told
        assert told.outbound.text == (
            "While I could not listen, 50 commands came in here. None of them was carried out.\n"
            "What you still want, tap to send it again."
        )
        labels = [row[0].label for row in told.outbound.buttons]
        assert labels == ["omni move 3 m", "omni move 4 m", "omni move 5 m"]
        assert place.acted() == 0
        place.chat.listening_since_ns = 0
        await place.tap(told.outbound.buttons[1][0], told.message)
        assert place.acted() == 1
    assert (await store.open()).unfinished == ()


async def test_each_chat_is_told_and_an_offer_is_its_authors() -> None:
    async with Place().open() as place:
        await old(place, "omni wave", 3, chat=GROUP, kind=ChatKind.GROUP, account=BO)
        await old(place, "omni look", 3, chat=ADA, account=ADA)
        await place.clock.advance(1.0)
        assert {told.outbound.chat.id for told in place.chat.told} == {GROUP, ADA}
        told = next(t for t in place.chat.told if t.outbound.chat.id == GROUP)
        place.chat.listening_since_ns = 0
        await place.tap(told.outbound.buttons[0][0], told.message, account=ADA)
        assert place.acted() == 0
        await place.tap(told.outbound.buttons[0][0], told.message, account=BO)
        assert place.acted() == 1


async def test_a_flood_of_old_commands_costs_nobody_their_rate_or_their_key() -> None:
    async with Place(limit=RateLimit(burst=2.0, per_s=0.001)).open() as place:
        await old(place, "omni wave", 200, account=BO, chat=BO)
        await place.clock.advance(1.0)
        place.chat.listening_since_ns = 0
        assert "done" in await place.say("omni wave", account=BO, chat=BO)


async def test_of_old_questions_only_the_newest_are_answered() -> None:
    async with Place().open() as place:
        for _ in range(20):
            await old(place, "status", account=VI, chat=VI)
        await place.clock.advance(1.0)
        assert len(place.chat.told) == 3


class Settling(MemoryMessenger):
    """Asks before it would confirm, as a messenger with a platform behind it does."""

    settle: Settle

    def settle_with(self, settle: Settle) -> None:
        self.settle = settle


class SlowStore(MemoryStore):
    """Writes when it may."""

    def __init__(self) -> None:
        super().__init__()
        self.may = asyncio.Event()
        self.may.set()
        self.asked = 0

    async def write(self, *records: Record) -> None:
        self.asked += 1
        await self.may.wait()
        await super().write(*records)


async def test_what_a_disk_is_slow_to_take_holds_up_no_further_message_of_its_chat() -> None:
    store = SlowStore()
    async with Place(store, chat=lambda clock: Settling("memory", clock=clock)).open() as place:
        assert isinstance(place.chat, Settling)
        assert await place.chat.settle(0.0)
        place.chat.gap()
        store.may.clear()
        before = store.asked
        for number in range(1, 6):
            sent_ns = place.clock.wall_ns() - HOUR_NS
            place.chat.say(f"omni move {number} m", sent_ns=sent_ns)
        await place.quiet()
        assert store.asked == before + 5, "one waited for the other's commit"
        assert not await place.chat.settle(0.01), "it would be confirmed before it is on disk"
        assert not place.gateway.quiet
        await place.clock.advance(0.9)
        assert not place.chat.told, "told before it was on disk, or a second was over"
        store.may.set()
        assert await place.chat.settle(30.0)
        await settle()
        await place.clock.advance(1.0)
        (told,) = place.chat.told
        assert "5 commands came in here" in told.outbound.text


async def test_a_refusal_that_a_disk_is_slow_to_take_holds_up_no_further_message_either() -> None:
    store = SlowStore()
    async with Place(store, chat=lambda clock: Settling("memory", clock=clock)).open() as place:
        assert isinstance(place.chat, Settling)
        store.may.clear()
        before = store.asked
        for number in range(1, 6):
            place.chat.say(f"omni move {number}00 m")
        await place.quiet()
        assert store.asked == before + 5, "one waited for the other's commit"
        assert not await place.chat.settle(0.01), "it would be confirmed before it is on disk"
        await place.clock.advance(0.9)
        assert not place.chat.told, "told before it was on disk, or a second was over"
        store.may.set()
        assert await place.chat.settle(30.0)
        await place.quiet()
        told = [told.outbound.text for told in place.chat.told]
        assert ["at most 5 m" in text for text in told] == [True] * 5, told


async def test_a_messenger_that_does_not_ask_is_given_only_what_is_settled() -> None:
    store = SlowStore()
    async with Place(store).open() as place:
        place.chat.gap()
        store.may.clear()
        before = store.asked
        for number in range(1, 4):
            sent_ns = place.clock.wall_ns() - HOUR_NS
            place.chat.say(f"omni move {number} m", sent_ns=sent_ns)
        await settle()
        await asyncio.sleep(0.05)
        assert store.asked == before + 1
        store.may.set()
        await place.quiet()


async def test_answers_that_a_crash_left_unsaid_are_one_as_well() -> None:
    store, clock = MemoryStore(), ManualClock()
    async with Place(store, clock=clock).open() as place:
        place.chat.down = True
        await old(place, "omni wave", 30)
        await place.clock.advance(1.0)

    async with Place(store, clock=clock).open() as place:
        await place.clock.advance(1.0)
        (told,) = place.chat.told
        assert told.outbound.text.startswith("While I could not listen, 30 commands came in here.")
        assert told.outbound.text.endswith("(Said again: ROSIC was restarted.)")
    assert (await store.open()).unfinished == ()
