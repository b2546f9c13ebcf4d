"""I16: a tap is good once, for its person, in its chat, before it expires."""

from __future__ import annotations

from tests.rooms.pipeline.place import ADA, BO, Place


async def test_from_the_robots_to_a_motion_by_taps_alone() -> None:
    async with Place().open() as place:
        await place.say("/start")
        await place.tap(*place.button("omni"))
        await place.tap(*place.button("Wave"))
        assert place.acted() == 0, "a tapped skill is asked about first"
        await place.tap(*place.button("Do it"))
        assert place.acted() == 1


async def test_a_skill_that_lacks_a_value_offers_some() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Move"))
        await place.tap(*place.button("Do it"))
        assert place.acted() == 0
        _, shown = place.last()
        assert shown.buttons, shown.text
        await place.tap(shown.buttons[0][0], place.last()[0])
        assert place.acted() == 1


async def test_a_button_works_once() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Wave"))
        button, under = place.button("Do it")
        await place.tap(button, under)
        assert await place.tap(button, under) == ""
        assert place.acted() == 1
        assert place.chat.answers[-1][1] == "This button is no longer good. Nothing was done."


async def test_another_persons_tap_does_nothing_and_uses_nothing_up() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Wave"))
        button, under = place.button("Do it")
        assert await place.tap(button, under, account=BO) == ""
        assert place.acted() == 0
        assert place.chat.answers[-1][1] == "This question was asked of somebody else."
        await place.tap(button, under, account=ADA)
        assert place.acted() == 1


async def test_a_button_is_dead_after_a_minute() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Wave"))
        await place.clock.advance(61.0)
        await place.tap(*place.button("Do it"))
        assert place.acted() == 0
        assert place.chat.answers[-1][1] == "This button is too old. Nothing was done."


async def test_a_button_is_dead_after_a_gap_in_listening() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Wave"))
        await place.clock.advance(1.0)
        place.chat.gap()
        await place.tap(*place.button("Do it"))
        assert place.acted() == 0


async def test_a_stop_button_never_dies() -> None:
    async with Place().open() as place:
        place.robot("omni").work_s = 10_000.0
        await place.say("omni move 1 m")
        button, under = place.button("STOP")
        await place.clock.advance(3600.0)
        place.chat.gap()
        for _ in range(2):
            await place.tap(button, under, account=BO)
            assert place.robot("omni").gate.latched


async def test_leaving_it_leaves_it() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Wave"))
        assert await place.tap(*place.button("Leave it")) == "Nothing was done."
        assert place.acted() == 0
