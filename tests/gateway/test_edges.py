"""Endings at the edges: a claim under way when the gateway closes, a life nobody can be told of."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from rosic.core.records import Claimed, Concluded, Placed
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from tests.gateway.place import Place, SlowStore

if TYPE_CHECKING:
    from rosic.core.message import Outbound
    from rosic.core.records import Record
    from rosic.testing.clock import ManualClock


class Lane(MemoryStore):
    """Like the writer's thread: a claim is written though whoever asked for it was cancelled."""

    def __init__(self) -> None:
        super().__init__()
        self.ready = asyncio.Event()

    async def write(self, *records: Record) -> None:
        if any(isinstance(record, Claimed) for record in records):
            try:
                await self.ready.wait()
            except asyncio.CancelledError:
                await self.ready.wait()
                await super().write(*records)
                raise
        await super().write(*records)


async def test_a_claim_under_way_when_the_gateway_closes_is_known_not_to_have_moved() -> None:
    store = Lane()
    place = Place(store)
    async with place.open():
        place.chat.say("omni wave")
        await place.quiet()
        closing = asyncio.create_task(place.gateway._fall_deaf())
        await place.quiet()
        store.ready.set()
        await closing
        await place.quiet()
    assert place.acted() == 0
    async with Place(store).open() as after:
        await after.quiet()
        assert not after.robot("omni").gate.latched, after.chat.told[-1].outbound.text
        assert "Nothing was done." in after.chat.told[-1].outbound.text


async def test_an_order_that_has_not_begun_when_the_gateway_closes_is_told() -> None:
    async with Place().open() as place:
        inbound = place.chat.say("omni wave")
        pipeline = place.gateway.pipeline

        async def come_and_go() -> None:
            # No turn of the event loop lies between the claim and the end.
            await pipeline.receive(place.chat, inbound)
            await pipeline.close()

        going = asyncio.create_task(come_and_go())
        await place.quiet()
        assert going.done(), "it waits for what was cut off before it could say that it ends"
        assert place.acted() == 0
        assert "could begin. Nothing was done." in place.chat.told[-1].outbound.text


class SlowToSend(MemoryMessenger):
    """The network takes its time with a first message."""

    def __init__(self, clock: ManualClock) -> None:
        super().__init__("memory", clock=clock)
        self.ready = asyncio.Event()

    async def send(self, outbound: Outbound) -> str:
        await self.ready.wait()
        return await super().send(outbound)


class SlowToConclude(SlowStore):
    """Remembers which records were waited for."""

    def __init__(self) -> None:
        super().__init__(Concluded)
        self.awaited: list[type] = []

    async def write(self, *records: Record) -> None:
        await super().write(*records)
        self.awaited += map(type, records)


async def test_a_message_is_on_disk_before_it_shows_an_ending() -> None:
    store = SlowToConclude()
    async with Place(store, chat=SlowToSend).open() as place:
        assert isinstance(place.chat, SlowToSend)
        place.chat.say("omni wave")
        await place.quiet()
        assert place.acted() == 1, "it has ended, and that is on its way to the disk"
        place.chat.ready.set()
        await place.quiet()
        assert Placed in store.awaited
        store.ready.set()


async def test_a_life_that_nobody_can_be_told_of_is_closed_at_the_next_start() -> None:
    store = MemoryStore()
    async with Place(store).open() as place:
        place.robot("omni").work_s = 60.0
        await place.say("omni wave")
        ada = place.gateway.rooms.authoriser.directory.named("Ada")[0].id
        await store.shred(ada)
        async with Place(store).open() as after:
            await after.quiet()
        assert not store._open_orders, "it counts against the room in the record for ever"
