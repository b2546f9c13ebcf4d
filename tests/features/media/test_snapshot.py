"""Pictures, clips and maps: for whoever may read the robot, with their age, bounded."""

from __future__ import annotations

import asyncio
import threading
from math import pi
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.robot.view import Clip, Pose, ViewKind
from rosic.errors import MessengerFault
from rosic.features.media import MediaFeature, render_queue
from tests.features.media.media_gateway import FRAME, GRID, Booth, Sketcher, booth, without_files
from tests.gateway.place import BO, STRANGER, VI
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@pytest.fixture
async def place() -> AsyncIterator[Booth]:
    async with booth(Sketcher()).open() as place:
        assert isinstance(place, Booth)
        place.prepare()
        yield place


def labels(place: Booth) -> list[str]:
    _, shown = place.last()
    return [button.label for row in shown.buttons for button in row]


async def test_a_picture_comes_with_robot_and_age(place: Booth) -> None:
    shown = await place.see("/picture omni")
    assert shown.attachment is not None
    assert (shown.attachment.name, shown.attachment.media_type) == ("omni.png", "image/png")
    assert shown.text.startswith("The omni, camera, 0.")
    assert shown.text.endswith(" s ago")
    assert place.renderer.drawn == [(FRAME, False)]
    assert labels(place) == ["Again", "Clip", "Lower quality"]


async def test_it_is_drawn_off_the_event_loop(place: Booth) -> None:
    await place.see("picture omni")
    assert place.renderer.threads
    assert threading.get_ident() not in place.renderer.threads


async def test_low_quality_is_asked_for_and_said(place: Booth) -> None:
    shown = await place.see("picture omni low")
    assert shown.text.endswith("low quality")
    assert place.renderer.drawn == [(FRAME, True)]


async def test_a_button_asks_again(place: Booth) -> None:
    await place.see("picture omni low")
    button, under = place.button("Better quality")
    await place.tap(button, under)
    async with asyncio.timeout(60 * pace()):
        while len(place.renderer.drawn) < 2:  # noqa: ASYNC110 - a thread draws
            await asyncio.sleep(0.001)
    assert place.renderer.drawn[1] == (FRAME, False)


async def test_a_clip_is_several_frames(place: Booth) -> None:
    shown = await place.see("clip omni")
    (clip, _), *_ = place.renderer.drawn
    assert isinstance(clip, Clip)
    assert len(clip.frames) == 14
    assert 0.19 < clip.every_s < 0.5
    assert "clip of" in shown.text


async def test_a_map_is_shown(place: Booth) -> None:
    shown = await place.see("map cf1")
    assert place.renderer.drawn == [(GRID, False)]
    assert shown.text.startswith("The cf1, map, ")
    assert "position" not in shown.text


async def test_a_map_says_how_old_the_position_on_it_is(place: Booth) -> None:
    pose_ns = place.clock.monotonic_ns() - 42_000_000_000
    place.robot("cf1").shows[ViewKind.MAP] = replace(GRID, pose=Pose(0, 0), pose_ns=pose_ns)
    shown = await place.see("map cf1")
    assert shown.text.endswith("s ago, position 42 s ago")


@pytest.mark.parametrize(
    ("origin", "pose", "beside"),
    [
        (Pose(0, 0), Pose(6.94, -0.5), "x 6.94 m, y -0.50 m"),
        (Pose(0, 0), Pose(0.05, 0.11), "x 0.05 m, y 0.11 m"),
        (Pose(0, 0), Pose(0.05, 0.05), ""),
        (Pose(5, 5), Pose(5.05, 5.05), ""),
        (Pose(5, 5), Pose(0.05, 0.05), "x 0.05 m, y 0.05 m"),
        (Pose(0, 0, yaw_rad=pi), Pose(-0.05, -0.05), ""),
        (Pose(0, 0, yaw_rad=pi), Pose(0.05, 0.05), "x 0.05 m, y 0.05 m"),
    ],
)
async def test_a_robot_beside_the_map_is_said_to_be(
    place: Booth, origin: Pose, pose: Pose, beside: str
) -> None:
    now_ns = place.clock.monotonic_ns()
    grid = replace(GRID, origin=origin, pose=pose, pose_ns=now_ns)
    place.robot("cf1").shows[ViewKind.MAP] = grid
    text = (await place.see("map cf1")).text
    assert text.endswith(f". The cf1 is outside this map, at {beside}.") is bool(beside)
    assert ("outside" in text) is bool(beside)


async def test_nobody_looks_any_longer_than_it_takes(place: Booth) -> None:
    for line in ("picture omni", "clip omni", "map omni"):
        await place.see(line)
        assert place.robot("omni").looked == 0


async def test_the_menu_has_what_the_robot_has(place: Booth) -> None:
    await place.say("use omni")
    assert {"Picture", "Clip", "Map", "Chart", "Way"} <= set(labels(place))
    await place.say("use kuka1")
    assert not {"Picture", "Clip", "Map", "Chart", "Way"} & set(labels(place))


async def test_the_chosen_robot_is_meant_when_none_is_named(place: Booth) -> None:
    await place.say("use cf1")
    assert (await place.see("picture low")).text.startswith("The cf1, camera, ")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("picture kuka1", "kuka1 has no camera that people may look through."),
        ("clip kuka1", "kuka1 has no camera that people may look through."),
        ("map kuka1", "kuka1 has no map to show."),
        ("picture omni please now", "Say picture, the robot, and perhaps low"),
        ("picture nobody", "nobody"),
    ],
)
async def test_what_cannot_be_shown_is_said(place: Booth, line: str, words: str) -> None:
    shown = await place.see(line)
    assert words in shown.text
    assert shown.attachment is None
    assert place.renderer.drawn == []


async def test_a_robot_that_shows_nothing_is_said_to(place: Booth) -> None:
    place.robot("omni").shows = {}
    shown = await place.see("picture omni")
    assert shown.text == "The omni shows nothing now."


# ---- who may ----


async def test_a_viewer_may_look(place: Booth) -> None:
    assert (await place.see("picture omni", account=VI)).attachment is not None


async def test_a_stranger_sees_nothing(place: Booth) -> None:
    await place.say("/picture omni", account=STRANGER)
    await asyncio.sleep(0.05)
    assert place.renderer.drawn == []


async def test_whoever_loses_the_right_meanwhile_is_shown_nothing(place: Booth) -> None:
    place.renderer.wait.clear()
    await place.say("picture omni", account=BO)
    place.gateway.rooms.organiser.visible = lambda _: frozenset()  # type: ignore[method-assign, assignment]
    place.renderer.wait.set()
    texts: list[str] = []
    async with asyncio.timeout(60 * pace()):
        while "You may not look at that robot any more." not in texts:
            await asyncio.sleep(0.001)
            texts = [told.outbound.text for told in place.chat.told]
    assert "You may not look at that robot any more." in texts
    assert all(told.outbound.attachment is None for told in place.chat.told)


# ---- bounds ----


async def test_one_picture_of_a_robot_at_a_time(place: Booth) -> None:
    place.renderer.wait.clear()
    await place.say("picture omni")
    assert "being made already" in await place.say("picture omni", account=VI)
    place.renderer.wait.set()
    await place.see("status")


async def test_nobody_may_ask_without_end(place: Booth) -> None:
    shown = await place.see("clip omni")
    for _ in range(20):
        if shown.attachment is not None:
            shown = await place.see("clip omni")
    assert "more pictures than one person may ask for" in shown.text
    assert len(place.renderer.drawn) <= render_queue.LIMIT.burst / 4 + 1
    assert (await place.see("clip omni", account=VI)).attachment is not None  # others still may


async def test_the_chat_goes_on_while_a_picture_is_made(place: Booth) -> None:
    place.renderer.wait.clear()
    await place.say("picture omni")
    assert "omni" in await place.say("status omni")
    assert place.acted() == 0
    await place.say("omni wave")
    assert place.acted() == 1
    place.renderer.wait.set()


# ---- what goes wrong ----


async def test_a_painter_that_fails_is_told_of(place: Booth) -> None:
    def fails(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    place.gateway.features.get(MediaFeature).render_queue._renderer = fails  # type: ignore[assignment]
    shown = await place.see("picture omni")
    assert shown.text == "The picture could not be made. The log says why."


async def test_a_picture_that_is_not_taken_is_told_of(place: Booth) -> None:
    send = place.chat.send

    async def refuse(outbound: object) -> str:
        if getattr(outbound, "attachment", None) is not None:
            raise MessengerFault("too large")
        return await send(outbound)  # type: ignore[arg-type]

    place.chat.send = refuse  # type: ignore[method-assign]
    shown = await place.see("picture omni")
    assert shown.text.startswith("The picture could not be sent.")


async def test_without_pillow_it_is_said_how_to_get_it() -> None:
    async with booth(None).open() as place:
        assert "pip install 'rosic[pictures]'" in await place.say("picture omni")
        await place.say("use omni")
        _, shown = place.last()
        assert "Picture" not in [button.label for row in shown.buttons for button in row]


async def test_a_messenger_without_files_says_so() -> None:
    async with booth(Sketcher(), chat=without_files).open() as place:
        assert await place.say("picture omni") == "This messenger cannot show pictures."


async def test_closing_waits_for_nobody_who_looks() -> None:
    made = booth(Sketcher())
    async with made.open():
        made.prepare()
        made.robot("omni").shows = {ViewKind.PICTURE: FRAME}
        await made.say("clip omni")
        assert made.robot("omni").looked == 1
    assert made.robot("omni").looked == 0
