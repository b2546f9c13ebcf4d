"""Buttons: once, by the right person, soon, and without a gap between showing and pressing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tests.journeys.lab import Lab, lab

if TYPE_CHECKING:
    from pathlib import Path

    from tests.journeys.running import Launcher

NO_GOOD = "This button is no longer good. Nothing was done."
TOO_OLD = "This button is too old. Nothing was done."


async def question(place: Lab, chat: int) -> int:
    """Go from the menu to the last question before a robot moves; return its message."""
    menu = await place.ask(place.bo, "/use ant", "Its name may be left out now.", chat=chat)
    await place.control.tap(place.bo, chat, menu["message_id"], "Hop")
    asked = await place.reads(chat, "Ant: hop, 1.00 m?")
    assert place.acted() == 0
    return int(asked["message_id"])


async def press(place: Lab, user: int, chat: int, message: int, **how: bool) -> str:
    """Press "Do it", and return what the person reads at once."""
    tap = await place.control.tap(user, chat, message, "Do it", **how)
    return await answer(place, tap)


async def answer(place: Lab, tap: str) -> str:
    async def look() -> Any:  # noqa: ANN401 - any JSON
        return (await place.control.call("press", query_id=tap))["answers"]

    [answered] = await place.until(look)
    return str(answered.get("text") or "")


async def test_a_button_pressed_twice_acts_once(tmp_path: Path, launcher: Launcher) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        asked = await question(place, place.bo)

        first = await place.control.tap(place.bo, place.bo, asked, "Do it")
        second = await place.control.tap(place.bo, place.bo, asked, "Do it", stale=True)

        assert sorted([await answer(place, first), await answer(place, second)]) == ["", NO_GOOD]
        await place.reads(place.bo, "done ")
        await place.drained()
        assert place.acted() == 1


async def test_another_person_cannot_press_it(tmp_path: Path, launcher: Launcher) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        room = await place.control.create_chat("supergroup", "Room", members=[place.ada, place.bo])
        asked = await question(place, room)

        said = await press(place, place.ada, room, asked)

        assert said == "This question was asked of somebody else."
        await place.drained()
        assert place.acted() == 0
        assert await press(place, place.bo, room, asked) == ""
        assert await place.counter.wait_for(1, 60)


async def test_a_button_from_before_a_kill_is_dead(tmp_path: Path, launcher: Launcher) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        asked = await question(place, place.bo)
        gateway.kill()
        tap = await place.control.tap(place.bo, place.bo, asked, "Do it")

        await place.start()

        assert await answer(place, tap) == NO_GOOD
        assert await press(place, place.bo, place.bo, asked) == NO_GOOD
        await place.drained()
        assert place.acted() == 0


async def test_a_button_from_before_a_gap_in_listening_is_dead(
    tmp_path: Path, launcher: Launcher
) -> None:
    async with lab(tmp_path, launcher) as place:
        gateway = await place.start()
        asked = await question(place, place.bo)
        await place.control.fail("hang", "getUpdates", seconds=6.0)
        assert await place.until(place.hangs)
        tap = await place.control.tap(place.bo, place.bo, asked, "Do it")

        assert await gateway.says("lab: listening", times=2)

        assert await answer(place, tap) == TOO_OLD
        await place.drained()
        assert place.acted() == 0
        await place.ask(place.bo, "ant hop", "done ")


async def test_a_forged_button_does_nothing(tmp_path: Path, launcher: Launcher) -> None:
    async with lab(tmp_path, launcher) as place:
        await place.start()
        asked = await question(place, place.bo)

        for forged in ("ant hop", "AAAAAAAAAAAAAAAAAAAAAA"):
            tap = await place.control.tap(place.bo, place.bo, asked, forged, forged=True)
            assert await answer(place, tap) == NO_GOOD
        assert place.acted() == 0
