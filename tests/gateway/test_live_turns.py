"""Whose turn a live order waits for, who takes its controls again, and what it leaves behind."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.order import OrderEnding
from rosic.core.robot.profile import Busy
from rosic.core.sample_gate import SampleVerdict
from rosic.errors import Expired, NotUnderstood
from rosic.stores.memory import MemoryStore
from tests.gateway.steering import OMNI, Hand, driven, hand, live, person, steered

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.records import Record

TAKEN, OVER = SampleVerdict.TAKEN, SampleVerdict.OVER


async def test_whoever_was_cut_off_takes_the_controls_once_more() -> None:
    async with steered() as place:
        steers = await hand(place)
        await steers.hold(0.2, linear=0.3)
        steers.input.close()
        assert steers.put(linear=0.3).verdict is OVER
        again = Hand(place, live(place).open(steers.input.order.cid, person(place)))
        again.sequence = steers.sequence
        assert again.put(linear=0.1).taken


async def test_an_ended_order_is_opened_by_nobody() -> None:
    async with steered() as place:
        steers = await hand(place)
        steers.put(linear=0.3)
        steers.input.release()
        await place.quiet()
        with pytest.raises(Expired):
            live(place).open(steers.input.order.cid, person(place))


async def test_one_that_waits_is_steered_when_its_turn_comes() -> None:
    async with steered(fleet=(replace(OMNI, busy=Busy.QUEUE),)) as place:
        place.robot("omni").work_s = 60
        await place.say("omni move 1 m")
        steers = await hand(place)
        assert steers.put(linear=0.3).verdict is SampleVerdict.WAITING
        place.robot("omni").finish()
        await place.quiet()
        assert steers.put(linear=0.4).taken
        await place.quiet()
        assert driven(place) == [0.4]


async def test_whoever_waits_for_one_that_never_begins_learns_that() -> None:
    async with steered(fleet=(replace(OMNI, busy=Busy.QUEUE),)) as place:
        place.robot("omni").work_s = 60
        await place.say("omni move 1 m")
        steers = await hand(place)
        await place.say("stop omni")
        outcome = await steers.input.ended()
        assert outcome.ending is OrderEnding.REFUSED


class CountingStore(MemoryStore):
    """Keeps a list of what is written."""

    def __init__(self) -> None:
        super().__init__()
        self.written: list[Record] = []

    async def write(self, *records: Record) -> None:
        self.written += records
        await super().write(*records)

    def keep(self, record: Record, then: Callable[[], None]) -> None:
        self.written.append(record)
        super().keep(record, then)

    def note(self, *records: Record) -> None:
        self.written += records
        super().note(*records)


async def test_samples_keep_nothing() -> None:
    """Ten thousand leave no record, and no more than the newest."""
    store = CountingStore()
    async with steered(store=store) as place:
        steers = await hand(place)
        steers.put(linear=0.3)
        await place.quiet()
        records, said_before = len(store.written), len(place.chat.told)
        for _ in range(1_000):
            for _ in range(10):
                steers.put(linear=0.3)
            await place.clock.advance(0.01)
        assert len(store.written) <= records + 5, "what is written each minute"
        assert len(place.chat.told) <= said_before + 1, "that it runs"
        assert steers.input.counts[TAKEN] == 10_001
        assert driven(place) == [0.3]


async def test_there_is_no_line_for_what_cannot_be_steered() -> None:
    async with steered() as place:
        with pytest.raises(NotUnderstood):
            live(place).line("omni", "fly")
