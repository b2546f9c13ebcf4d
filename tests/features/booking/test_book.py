"""`/book`: a time, a time that comes again, and every way to be refused."""

from __future__ import annotations

import asyncio

import pytest

from rosic.core.local_time import LocalTime
from rosic.core.slot import SLOT
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, RecordUnavailable
from rosic.organiser.calendar_conflicts import SlotTaken
from rosic.organiser.timezones import zone_named
from tests.features.booking.booking_handlers import (
    ADA,
    ANN,
    BEN,
    HOUR,
    NOW,
    VI,
    VIENNA,
    FullDisk,
    Lab,
)


async def test_a_time_is_booked_and_said_in_full() -> None:
    async with Lab().open() as lab:
        said = await lab.say(ANN, "/book kuka1 tomorrow 14:00 1h")
        assert said == (
            "KUKA iiwa is yours on Sun 22 Nov 2026 from 14:00 to 15:00 (Europe/Vienna)."
        )
        (slot,) = lab.calendar.of(ANN)
        assert (slot.start_ns, slot.end_ns, slot.by) == (NOW + 28 * HOUR, NOW + 29 * HOUR, ANN)
        assert lab.decisions() == [("book", ANN)]
        memory = await lab.store.open()
        assert memory.facts[SLOT] == (slot.fact(),)
        assert lab.labels() == ["Cancel it"]
        assert await lab.tap(ANN, "Cancel it") == (
            "Cancelled: KUKA iiwa on Sun 22 Nov 2026 from 14:00 to 15:00 (Europe/Vienna)."
        )
        assert lab.calendar.of(ANN) == ()


@pytest.mark.parametrize("name", ["kuka1", "KUKA iiwa", "the kuka1", "KUKA1"])
async def test_any_name_will_do(name: str) -> None:
    async with Lab().open() as lab:
        assert (await lab.book(ANN, f"{name} 14:00 1h")).robot == "kuka1"


async def test_a_time_over_midnight_says_both_days() -> None:
    async with Lab().open() as lab:
        assert await lab.say(ANN, "/book kuka1 today 23:00 2h") == (
            "KUKA iiwa is yours from Sat 21 Nov 2026 23:00 to Sun 22 Nov 2026 01:00 "
            "(Europe/Vienna)."
        )
        assert await lab.say(ANN, "/book arm today 23:00 1h") == (
            "The Arm is yours on Sat 21 Nov 2026 from 23:00 to 24:00 (Europe/Vienna)."
        )


async def test_the_zone_is_the_persons() -> None:
    async with Lab().open() as lab:
        lab.zones[BEN] = zone_named("Asia/Tokyo")
        assert await lab.say(BEN, "/book kuka1 tomorrow 14:00 1h") == (
            "KUKA iiwa is yours on Sun 22 Nov 2026 from 14:00 to 15:00 (Asia/Tokyo)."
        )
        (slot,) = lab.calendar.of(BEN)
        assert VIENNA.local(slot.start_ns) == LocalTime(2026, 11, 22, 6)


async def test_an_overlap_is_refused_with_a_tap_to_the_next_free_time() -> None:
    async with Lab().open() as lab:
        await lab.book(ANN, "kuka1 14:00 1h")
        assert await lab.say(BEN, "/book kuka1 14:30 1h") == (
            "KUKA iiwa is taken by Ann from 14:00 to 15:00. It is free from 15:00 on."
        )
        assert isinstance(lab.refusal, SlotTaken)
        assert lab.offers() == ("book kuka1 2026-11-21 15:00 1 h",)
        assert await lab.say(BEN, lab.offers()[0]) == (
            "KUKA iiwa is yours on Sat 21 Nov 2026 from 15:00 to 16:00 (Europe/Vienna)."
        )


async def test_booking_needs_the_right_to_move_that_robot() -> None:
    async with Lab().open() as lab:
        assert await lab.say(VI, "/book kuka1 14:00 1h") == "That needs a right you lack."
        assert isinstance(lab.refusal, NotPermitted)
        assert len(lab.calendar) == 0


async def test_a_right_that_ends_while_somebody_else_has_the_turn_books_nothing() -> None:
    async with Lab().open() as lab:
        async with lab.changes.turn():
            saying = asyncio.create_task(lab.say(BEN, "/book kuka1 14:00 1h"))
            await lab.told()
            lab.forbidden.add(BEN)
        assert await saying == "That needs a right you lack."
        assert len(lab.calendar) == 0


async def test_a_robot_that_one_may_not_see_is_as_unknown_as_none() -> None:
    async with Lab().open() as lab:
        lab.hidden.add("arm")
        assert await lab.say(BEN, "/book arm 14:00 1h") == (
            'I know no robot "arm". Say robots for those you may use.'
        )
        assert await lab.say(BEN, "/book xyz 14:00 1h") == (
            'I know no robot "xyz". Say robots for those you may use.'
        )
        assert isinstance(lab.refusal, NotUnderstood)


async def test_a_misspelt_name_is_offered_right() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/book kuak1 tomorrow 14:00 1h") == (
            'I know no robot "kuak1". Did you mean kuka1?'
        )
        assert lab.offers() == ("book kuka1 tomorrow 14:00 1h",)


async def test_without_a_name_it_is_the_chosen_robot_or_a_question() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/book tomorrow 14:00 1h") == "Which robot?"
        assert lab.offers()[0] == "book arm tomorrow 14:00 1h"
        lab.selected[BEN] = "kuka1"
        assert (await lab.book(BEN, "tomorrow 14:00 1h")).robot == "kuka1"


async def test_a_group_is_not_booked_as_one() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/book swarm 14:00 1h") == "swarm is several robots. Which one?"
        assert lab.offers() == ("book cf1 14:00 1h", "book cf2 14:00 1h")


async def test_what_needs_no_booking_is_not_booked() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/book cf1 14:00 1h") == (
            "cf1 needs no booking: whoever comes first has it. Nothing was booked."
        )
        assert isinstance(lab.refusal, OutOfBounds)
        assert lab.offers() == ("wait cf1",)


async def test_half_a_time_is_asked_for() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/book kuka1 tomorrow 14:00") == "For how long?"
        assert "book kuka1 2026-11-22 14:00 1h" in lab.offers()
        assert (await lab.say(BEN, "/book kuka1")).startswith("When, and for how long?")
        assert lab.offers()[0] == "book kuka1 tomorrow 14:00 1h"
        assert await lab.say(BEN, "/book kuka1 blursday 14:00 1h") == (
            'I cannot read "blursday" as a time. Write it as tomorrow 14:00 1h, or the day as '
            "2027-02-01."
        )
        assert (await lab.say(BEN, "/book kuka1 yesterday 14:00 1h")).startswith(
            "That time is over: it would have begun at Fri 20 Nov 14:00"
        )


async def test_what_the_calendar_refuses_is_refused_in_its_words() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/book kuka1 2026-11-20 14:00 1h") == (
            "That time is over: it would have begun at Fri 20 Nov 14:00, and it is 10:00. "
            "Nothing was booked."
        )
        assert await lab.say(BEN, "/book kuka1 14:00 2 days") == (
            "One time may be at most 1 day. Nothing was booked."
        )
        assert await lab.say(BEN, "/book kuka1 2027-03-28 02:30 1h") == (
            "On Sun 28 Mar the clocks in Europe/Vienna go forward, and there is no 02:30. The "
            "next possible time is 03:00. Nothing was booked."
        )
        assert await lab.say(BEN, lab.offers()[0]) == (
            "KUKA iiwa is yours on Sun 28 Mar 2027 from 03:00 to 04:00 (Europe/Vienna)."
        )


async def test_a_time_that_comes_twice_says_which_one_it_is() -> None:
    async with Lab().open() as lab:
        assert await lab.say(BEN, "/book kuka1 2027-10-31 02:30 30 min") == (
            "KUKA iiwa is yours on Sun 31 Oct 2027 from 02:30 to 02:00, 30 min (Europe/Vienna). "
            "On Sun 31 Oct the clocks in Europe/Vienna go back, and 02:30 comes twice. This is "
            "the first one."
        )


async def test_a_full_disk_books_nothing() -> None:
    store = FullDisk()
    async with Lab(store).open() as lab:
        store.full = True
        assert await lab.say(ANN, "/book kuka1 14:00 1h") == (
            "I cannot write this down now, so nothing was changed. The operator has to look."
        )
        assert isinstance(lab.refusal, RecordUnavailable)
        assert len(lab.calendar) == 0


# ---- again and again ----


async def test_a_series_says_how_many() -> None:
    async with Lab().open() as lab:
        said = await lab.say(ANN, "/book kuka1 every tue 14:00 1h until 2027-02-01")
        assert said == (
            "KUKA iiwa is yours 10 times: first on Tue 24 Nov 2026 from 14:00 to 15:00, last on "
            "Tue 26 Jan 2027 (Europe/Vienna)."
        )
        assert len(lab.calendar.of(ANN)) == 10
        assert lab.decisions() == [("book", ANN)]
        assert lab.labels() == ["Cancel all of them"]
        assert await lab.tap(ANN, "Cancel all of them") == (
            "Cancelled: KUKA iiwa, 10 times, first on Tue 24 Nov 2026 from 14:00 to 15:00, last "
            "on Tue 26 Jan 2027 (Europe/Vienna)."
        )
        assert len(lab.calendar) == 0


async def test_a_series_over_the_change_of_clocks_says_so() -> None:
    async with Lab().open() as lab:
        said = await lab.say(ANN, "/book kuka1 every sun 02:30 30 min until 2027-04-01")
        assert said.endswith(
            "On Sun 28 Mar 2027 the clocks in Europe/Vienna go forward, and it begins at 03:30."
        )


async def test_a_series_without_an_end_is_asked_for_one() -> None:
    async with Lab().open() as lab:
        assert await lab.say(ANN, "/book kuka1 every tue 14:00 1h") == (
            "Until when? A time that comes again needs a last day, or how many times."
        )
        assert lab.offers() == ("book kuka1 every Tue 14:00 1 h until 2027-02-16",)


async def test_a_series_is_booked_where_it_is_free_if_that_is_said() -> None:
    async with Lab().open() as lab:
        await lab.book(BEN, "kuka1 2026-12-01 14:30 1h")
        assert await lab.say(ANN, "/book kuka1 every tue 14:00 1h 4 times") == (
            "One of these times is taken: KUKA iiwa is Ben's at Tue 1 Dec 14:30. "
            "Nothing was booked."
        )
        assert lab.calendar.of(ANN) == ()
        free, day = lab.offers()
        assert free == "book kuka1 every tue 14:00 1h 4 times where free"
        assert await lab.say(ANN, f"/{day}") == (
            "KUKA iiwa on Tue 1 Dec 2026 (Europe/Vienna):\n14:30 to 15:30 Ben\n"
            "Otherwise it is free."
        )
        assert await lab.say(ANN, free) == (
            "KUKA iiwa is yours 3 times: first on Tue 24 Nov 2026 from 14:00 to 15:00, last on "
            "Tue 15 Dec 2026 (Europe/Vienna). One of these times is taken and was left out."
        )


async def test_a_series_of_which_nothing_is_free_offers_to_look() -> None:
    async with Lab().open() as lab:
        await lab.book(BEN, "kuka1 every tue 14:00 1h 2 times")
        await lab.say(ADA, "/book kuka1 every tue 14:00 1h 2 times")
        assert lab.offers() == ("slots kuka1 2026-11-24",)
