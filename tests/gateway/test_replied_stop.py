"""A stop said in reply to the message of an order stops that order's robot, and no other."""

from __future__ import annotations

from tests.gateway.place import BO, VI, Place


async def _both_at_work(place: Place) -> tuple[str, str]:
    place.robot("omni").work_s = place.robot("kuka1").work_s = 10_000.0
    await place.say("omni move 1 m")
    omni = place.last()[0]
    await place.say("kuka1 move 1 m", account=BO)
    return omni, place.last()[0]


def _latched(place: Place) -> list[str]:
    return [name for name in ("cf1", "kuka1", "omni") if place.robot(name).gate.latched]


async def test_it_stops_the_robot_of_that_order() -> None:
    async with Place().open() as place:
        omni, _ = await _both_at_work(place)
        told = await place.say("stop", answers=omni)
        assert _latched(place) == ["omni"]
        assert "omni" in told
        assert "kuka1" not in told


async def test_it_stops_what_still_waits_for_its_turn() -> None:
    async with Place().open() as place:
        await _both_at_work(place)
        await place.say("kuka1 wave", account=BO)
        waiting = place.last()[0]
        await place.say("stop", answers=waiting, account=VI, chat="1")
        assert _latched(place) == ["kuka1"]
        assert place.acted("kuka1") == 1


async def test_in_reply_to_anything_else_it_stops_everything() -> None:
    async with Place().open() as place:
        omni, _ = await _both_at_work(place)
        for answers in ("no such message", omni):
            await place.say("stop", answers=answers, chat="another chat")
            assert _latched(place) == ["cf1", "kuka1", "omni"]


async def test_a_name_counts_more_than_what_is_replied_to() -> None:
    async with Place().open() as place:
        omni, _ = await _both_at_work(place)
        await place.say("stop kuka1", answers=omni)
        assert _latched(place) == ["kuka1"]


async def test_an_order_that_is_over_is_no_order_to_stop() -> None:
    async with Place().open() as place:
        await place.say("omni move 1 m")
        over = place.last()[0]
        await place.say("stop", answers=over)
        assert _latched(place) == ["cf1", "kuka1", "omni"]
