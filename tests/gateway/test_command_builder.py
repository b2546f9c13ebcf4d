"""Putting a command together by tapping: values first, then one tap that means it."""

from __future__ import annotations

from msgspec.structs import replace

from tests.gateway.place import BO, FLEET, WAVE, Place


def _rows(place: Place) -> list[list[str]]:
    return [[button.label for button in row] for row in place.last()[1].buttons]


async def test_a_number_is_stepped_through_and_what_is_shown_is_done() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Move"))
        assert place.last()[1].text == "omni: move, 0.50 m forward?"
        assert _rows(place) == [
            ["• forward", "back", "left"],
            ["−", "0.50 m", "+"],  # noqa: RUF001
            ["Do it", "Previous", "Leave it"],
        ]
        message = place.last()[0]
        await place.tap(*place.button("+"))
        await place.tap(*place.button("left"))
        assert place.last() == (message, place.chat.shown(message)), "one message, edited"
        assert place.last()[1].text == "omni: move, 1.00 m left?"
        assert place.acted() == 0
        told = await place.tap(*place.button("Do it"))
        assert place.acted() == 1
        assert "omni: move, 1.00 m left" in told


async def test_a_number_stops_at_its_bounds() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Move"))
        for _ in range(6):
            await place.tap(*place.button("+"))
        assert place.last()[1].text == "omni: move, 5.00 m forward?"
        for _ in range(12):
            await place.tap(*place.button("−"))  # noqa: RUF001
        assert place.last()[1].text == "omni: move, 0.01 m forward?"


async def test_a_step_is_good_once_and_for_its_person() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Move"))
        plus, under = place.button("+")
        assert await place.tap(plus, under, account=BO) == ""
        await place.tap(plus, under)
        assert await place.tap(plus, under) == ""
        assert place.last()[1].text == "omni: move, 1.00 m forward?"


async def test_a_skill_without_values_is_only_asked_about() -> None:
    async with Place().open() as place:
        await place.say("use omni")
        await place.tap(*place.button("Wave"))
        assert place.last()[1].text == "omni: wave?"
        assert _rows(place) == [["Do it", "Previous", "Leave it"]]


async def test_a_skill_has_its_sign_on_its_button() -> None:
    omni = replace(FLEET[0], skills={"wave": replace(WAVE, icon="👋")})
    async with Place(fleet=(omni, *FLEET[1:])).open() as place:
        await place.say("use omni")
        await place.tap(*place.button("👋 Wave"))
        assert place.last()[1].text == "omni: wave?"


async def test_again_asks_for_what_was_done_last_in_this_chat() -> None:
    async with Place().open() as place:
        told = await place.say("again")
        assert told == "There is nothing to do again here yet."
        await place.say("use omni")
        await place.say("move 30 cm left")
        await place.say("again")
        assert place.last()[1].text == "omni: move, 0.30 m left?"
        await place.tap(*place.button("Do it"))
        assert place.acted() == 2
        await place.say("again", account=BO)
        assert place.last()[1].text == "There is nothing to do again here yet."


async def test_again_works_for_a_group_too() -> None:
    async with Place().open() as place:
        await place.say("swarm wave")
        await place.say("again")
        assert place.last()[1].text == "swarm (cf1, cf2): wave?"
        await place.tap(*place.button("Do it"))
        assert (place.acted("cf1"), place.acted("cf2")) == (2, 2)


async def test_what_somebody_often_asks_comes_first_and_is_theirs_alone() -> None:
    async with Place().open() as place:
        for _ in range(2):
            await place.say("omni move 0.5 m left")
        await place.say("omni wave")
        await place.say("use omni")
        assert _rows(place)[0] == ["★ move, 0.50 m left"]
        await place.tap(*place.button("★ move, 0.50 m left"))
        assert place.acted() == 3, "asked about first"
        await place.tap(*place.button("Do it"))
        assert place.acted() == 4
        await place.say("use omni", account=BO)
        assert not any("★" in label for row in _rows(place) for label in row)


async def test_a_link_leads_to_a_robot_or_asks_for_a_skill_and_moves_nothing() -> None:
    async with Place().open() as place:
        await place.say("/start omni")
        assert "Move" in [label for row in _rows(place) for label in row]
        await place.say("/start omni__move")
        assert place.last()[1].text == "omni: move, 0.50 m forward?"
        assert place.acted() == 0
        await place.say("/start nobody__move")
        assert "Which robot?" in place.last()[1].text


async def test_a_link_shows_a_stranger_nothing() -> None:
    async with Place().open() as place:
        told = await place.say("/start omni__move", account="99")
        assert "omni" not in told
