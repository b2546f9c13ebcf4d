"""`/rebook`: one act, which leaves the time where it was if it is refused."""

from __future__ import annotations

import asyncio

import pytest

from rosic.core.slot import SLOT
from rosic.errors import Expired, NotPermitted, NotUnderstood, OutOfBounds, RecordUnavailable
from rosic.organiser.calendar_conflicts import SlotTaken
from tests.features.booking.booking_handlers import (
    ADA,
    ANN,
    BEN,
    HOUR,
    MIN,
    NOW,
    FullDisk,
    Lab,
)


async def test_a_time_is_moved_in_one_write_and_keeps_its_id_and_its_length() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 14:00 1h")
        assert await lab.say(ANN, "/rebook kuka1 to 14:30") == (
            "Moved: KUKA iiwa is yours on Sat 21 Nov 2026 from 14:30 to 15:30 (Europe/Vienna)."
        )
        (moved,) = lab.calendar.of(ANN)
        assert (moved.id, moved.start_ns - slot.start_ns) == (slot.id, HOUR // 2)
        assert moved.end_ns - moved.start_ns == HOUR
        assert lab.decisions() == [("book", ANN), ("move", ANN)]
        memory = await lab.store.open()
        assert memory.facts[SLOT] == (moved.fact(),)
        assert lab.labels() == ["Cancel it"]
        assert (await lab.tap(ANN, "Cancel it")).startswith("Cancelled: KUKA iiwa")


async def test_of_several_it_is_asked_which_one() -> None:
    async with Lab().open() as lab:
        assert await lab.say(ANN, "/rebook") == "You have no times booked."
        assert await lab.say(ANN, "/rebook arm") == "You have no time booked with The Arm."
        await lab.book(ANN, "kuka1 14:00 1h")
        await lab.book(ANN, "kuka1 18:00 1h")
        assert await lab.say(ANN, "/umbuchen kuka1 tomorrow 9-11") == (
            "Which one is to be moved (Europe/Vienna)?\n"
            "KUKA iiwa: 14:00 to 15:00\n"
            "KUKA iiwa: 18:00 to 19:00"
        )
        assert await lab.tap(ANN, "KUKA iiwa: 18:00 to 19:00") == (
            "Moved: KUKA iiwa is yours on Sun 22 Nov 2026 from 09:00 to 11:00 (Europe/Vienna)."
        )
        await lab.say(ANN, "/rebook")
        assert await lab.tap(ANN, "KUKA iiwa: 14:00 to 15:00") == "When, and for how long?"
        assert not any("every" in offer for offer in lab.offers())
        assert (await lab.say(ANN, lab.offers()[0])).startswith("Moved: KUKA iiwa is yours")


async def test_a_move_that_clashes_leaves_it_and_offers_when_it_is_free() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 14:00 1h")
        await lab.book(BEN, "kuka1 16:00 1h")
        before = await lab.store.open()
        assert await lab.say(ANN, "/rebook kuka1 16:30 1h") == (
            "KUKA iiwa is taken by Ben from 16:00 to 17:00. It is free from 17:00 on."
        )
        assert isinstance(lab.refusal, SlotTaken)
        assert lab.calendar.of(ANN) == (slot,)
        assert (await lab.store.open()).facts[SLOT] == before.facts[SLOT]
        assert lab.offers() == (f"rebook {slot.id} 2026-11-21 17:00 1 h",)
        assert (await lab.say(ANN, lab.offers()[0])).startswith("Moved: KUKA iiwa is yours")
        assert len(lab.calendar.of(ANN)) == 1


@pytest.mark.parametrize(
    ("when", "refused"),
    [
        ("yesterday 14:00 1h", OutOfBounds),
        ("tomorrow 14:00 10 days", OutOfBounds),
        ("every tue 14:00 1h 3 times", NotUnderstood),
        ("whenever", NotUnderstood),
    ],
)
async def test_a_move_to_no_time_leaves_it(when: str, refused: type[Exception]) -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 14:00 1h")
        await lab.say(ANN, f"/rebook kuka1 {when}")
        assert isinstance(lab.refusal, refused)
        assert lab.calendar.of(ANN) == (slot,)


async def test_what_cannot_be_written_is_not_moved() -> None:
    disk = FullDisk()
    async with Lab(disk).open() as lab:
        slot = await lab.book(ANN, "kuka1 14:00 1h")
        disk.full = True
        await lab.say(ANN, "/rebook kuka1 16:00")
        assert isinstance(lab.refusal, RecordUnavailable)
        assert lab.calendar.of(ANN) == (slot,)


async def test_others_move_nothing_but_whoever_looks_after_times_may_and_the_owner_is_told() -> (
    None
):
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 14:00 1h")
        await lab.say(BEN, f"/rebook {slot.id} 16:00 1h")
        assert isinstance(lab.refusal, NotPermitted)
        assert lab.calendar.of(ANN) == (slot,)
        assert await lab.say(ADA, f"/rebook {slot.id} 16:00 1h") == (
            "Moved: KUKA iiwa is Ann's on Sat 21 Nov 2026 from 16:00 to 17:00 (Europe/Vienna)."
        )
        told = dict(await lab.told())[ANN]
        assert told.startswith("Ada moved your time with KUKA iiwa: it is on Sat 21 Nov 2026 from")
        lab.hidden.add("kuka1")
        await lab.say(BEN, f"/rebook {slot.id} 18:00 1h")
        assert isinstance(lab.refusal, NotUnderstood)


async def test_of_a_time_that_has_begun_the_end_alone_is_moved() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 now 1h")
        await lab.told_until(10)
        await lab.say(ANN, f"/rebook {slot.id} tomorrow 14:00 1h")
        assert isinstance(lab.refusal, OutOfBounds)
        assert lab.calendar.of(ANN) == (slot,)
        assert "from 10:00 to 12:00" in await lab.say(ANN, f"/rebook {slot.id} today 10:00 2h")
        assert lab.calendar.present("kuka1", NOW + 90 * MIN) == lab.calendar.slot(slot.id)
        await lab.told_until(200)
        await lab.say(ANN, f"/rebook {slot.id} tomorrow 14:00 1h")
        assert isinstance(lab.refusal, Expired)


async def test_its_turn_begins_when_it_was_moved_to_and_not_before() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 11:00 1h")
        await lab.say(ANN, "/rebook kuka1 12:00")
        assert not any("begin" in text for _, text in await lab.told_until(90))
        assert lab.calendar.present("kuka1", NOW + 90 * MIN) is None
        assert [who for who, _ in await lab.told_until(121)].count(ANN) == 1


async def test_one_of_a_series_is_moved_and_stays_of_it() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "arm every tue 14:00 1h 3 times")
        first = lab.calendar.of(ANN)[0]
        assert "from 16:00 to 17:00" in await lab.say(
            ANN, f"/rebook {first.id} 2026-11-24 16:00 1h"
        )
        assert {slot.series for slot in lab.calendar.of(ANN)} == {first.series}
        await lab.say(ANN, f"/cancel booking all {first.series}")
        assert lab.calendar.of(ANN) == ()


async def test_a_right_that_ends_while_somebody_else_has_the_turn_moves_nothing() -> None:
    async with Lab().open() as lab:
        slot = await lab.book(ANN, "kuka1 14:00 1h")
        async with lab.changes.turn():
            saying = asyncio.create_task(lab.say(ANN, "/rebook kuka1 16:00"))
            await lab.told()
            lab.forbidden.add(ANN)
        assert await saying == "That needs a right you lack."
        assert lab.calendar.of(ANN) == (slot,)
