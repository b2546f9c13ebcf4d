"""Everybody reads and says times on the clocks of their own zone, if they have set one."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.features.fleet import FleetFeature
from rosic.stores.memory import MemoryStore
from rosic.testing.clock import ManualClock
from tests.features.access.access_gateway import ADA, BO, EVE, VI, House

NOW_NS = 1_795_255_200_000_000_000  # 21 November 2026, 10:00 UTC


def vienna(store: MemoryStore | None = None, clock: ManualClock | None = None) -> House:
    """Return a place in Vienna; it is 11:00 there, and 19:00 in Tokyo."""
    place = House(store, clock or ManualClock(NOW_NS))
    place.gateway._settings = replace(place.gateway._settings, zone="Europe/Vienna")
    return place


async def test_one_books_in_ones_own_zone_and_others_read_it_in_theirs() -> None:
    async with vienna().open() as place:
        assert await place.line(BO, "/settings zone Asia/Tokyo") == "Saved."
        assert await place.line(BO, "/book omni 21:00 1h") == (
            "omni is yours on Sat 21 Nov 2026 from 21:00 to 22:00 (Asia/Tokyo)."
        )
        assert "omni: 21:00 to 22:00" in await place.line(BO, "/slots")
        assert await place.line(ADA, "/book omni 13:30 1h") == (
            "omni is taken by Bo from 13:00 to 14:00. It is free from 14:00 on."
        )
        assert "13:00 to 14:00 Bo" in await place.line(ADA, "/slots omni")
        await place.pass_s(2 * 3_600)
        told = await place.line(ADA, "omni wave")
        assert "until 14:00" in told
        await place.line(BO, "stop omni")
        assert "stopped, by you, since 21:00." in await place.line(BO, "omni wave")
        assert "stopped, by Bo, since 13:00." in await place.line(ADA, "omni wave")


async def test_what_somebody_is_allowed_ends_for_each_on_their_own_clocks() -> None:
    async with vienna().open() as place:
        await place.line(VI, "/settings zone Asia/Tokyo")
        await place.line(VI, "/ask omni wave for 2h")
        told = await place.press(ADA, "Allow 2 h")
        assert "wave on omni, until 13:00." in told
        assert place.newest(EVE).text == "Ada allowed Vi: wave on omni, until 13:00."
        assert place.newest(VI).text == "Ada allows it. You may now: wave on omni, until 21:00."
        assert "wave on omni, until 21:00" in await place.line(VI, "/me")


async def test_a_task_is_due_on_the_clocks_of_whoever_gives_it() -> None:
    async with vienna().open() as place:
        place.robot("omni").work_s = 60.0
        await place.line(BO, "/settings zone Asia/Tokyo")
        told = await place.line(BO, "/task omni wave by 20:00")
        assert "20:00" in told, told
        [task] = place.gateway.features.get(FleetFeature).dispatching.fleet.open()
        assert task.until_ns == NOW_NS + 3_600 * 10**9


async def test_it_outlives_a_restart_and_none_is_the_places_again() -> None:
    store, clock = MemoryStore(), ManualClock(NOW_NS)
    async with vienna(store, clock).open() as place:
        await place.line(BO, "/settings zone Asia/Tokyo")
    async with vienna(store, clock).open() as place:
        assert "(Asia/Tokyo)" in await place.line(BO, "/book omni 21:00 1h")
        await place.line(BO, "/settings zone none")
        assert "omni: 13:00 to 14:00" in await place.line(BO, "/slots")


async def test_a_card_keeps_to_the_clocks_of_the_place() -> None:
    async with vienna().open() as place:
        await place.line(BO, "/settings zone Asia/Tokyo")
        await place.line(BO, "/book omni now 1h")
        await place.line(ADA, "/card omni")
        await place.quiet()
        assert "Bo until 12:00" in place.newest(ADA).text
