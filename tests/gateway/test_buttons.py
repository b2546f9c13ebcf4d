"""I16: a tap is good once, for its person, in its chat, before it expires."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from rosic.core.message import Button
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.gateway.button_rows import rows
from tests.gateway.place import ADA, BO, Place

FIELD = Parameter(unit="m", min=-10, max=10)
GOES = Profile(
    id="rover",
    link=Link(kind="memory"),
    skills={
        "goto": Skill(id="goto", parameters={"x": FIELD, "y": FIELD}),
        "grasp": Skill(
            id="grasp", parameters={"force": Parameter(unit="N", min=5, max=40, default=15)}
        ),
    },
)


async def test_from_the_robots_to_a_motion_by_taps_alone() -> None:
    async with Place().open() as place:
        await place.say("/start")
        await place.tap(*place.button("omni"))
        await place.tap(*place.button("Wave"))
        assert place.acted() == 0, "a tapped skill is asked about first"
        await place.tap(*place.button("Do it"))
        assert place.acted() == 1


async def test_what_lacks_two_values_begins_with_small_ones() -> None:
    async with Place(fleet=(GOES,)).open() as place:
        await place.say("use rover")
        assert await place.tap(*place.button("Goto")) == "rover: goto, x 1.00 m, y 1.00 m?"
        await place.tap(*place.button("Do it"))
        assert place.acted("rover") == 1


async def test_what_is_asked_says_the_values_that_were_not() -> None:
    async with Place(fleet=(GOES,)).open() as place:
        await place.say("/start")
        assert await place.tap(*place.button("Grasp")) == "rover: grasp, 15 N?"


async def test_who_has_one_robot_begins_with_what_it_can_do() -> None:
    async with Place(fleet=(GOES,)).open() as place:
        assert (await place.say("/start")).endswith("What should rover do?")
        await place.tap(*place.button("Grasp"))
        await place.tap(*place.button("Do it"))
        assert place.acted("rover") == 1


async def test_a_menu_may_be_tapped_late_because_it_only_asks() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.clock.advance(500.0)
        assert await place.tap(*place.button("Wave")) == "omni: wave?"
        assert place.acted() == 0
        await place.say("use omni")
        button, under = place.button("Wave")
        await place.clock.advance(601.0)
        await place.tap(button, under)
        assert place.chat.answers[-1][1] == "This button is too old. Nothing was done."


def test_a_row_holds_what_a_phone_can_show() -> None:
    said = ["Home", "Grasp", "Release", "Wave", "Move in a straight line", "Turn on the spot", "A"]
    laid = rows([Button(label, label) for label in said])
    assert [[button.label for button in row] for row in laid] == [
        ["Home", "Grasp", "Release"],
        ["Wave"],
        ["Move in a straight line"],
        ["Turn on the spot", "A"],
    ]


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


@pytest.mark.parametrize("forged", ["omni wave", "A" * 22, "use omni", "?", ""])
async def test_a_tap_on_what_was_never_shown_does_nothing(forged: str) -> None:
    async with Place().open() as place:
        await place.say("use omni")
        button, under = place.button("Wave")
        assert await place.tap(replace(button, nonce=forged), under) == ""
        assert place.acted() == 0
        assert place.chat.answers[-1][1] == "This button is no longer good. Nothing was done."


async def test_a_button_is_dead_after_a_minute() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Wave"))
        button, under = place.button("Do it")
        await place.clock.advance(61.0)
        await place.tap(button, under)
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
