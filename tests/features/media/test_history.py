"""Charts of the last minutes, and the way of the last order: kept bounded, drawn on request."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.core.robot.view import PathView, Pose, TimeSeries
from rosic.features.media import MediaFeature
from rosic.features.media.telemetry_buffer import (
    KEPT,
    WAY_POINTS,
    RobotTrack,
    SampleRing,
    TelemetryBuffer,
)
from tests.features.media.media_gateway import Booth, Sketcher, booth

if TYPE_CHECKING:
    from collections.abc import AsyncIterator


@pytest.fixture
async def place() -> AsyncIterator[Booth]:
    async with booth(Sketcher()).open() as place:
        assert isinstance(place, Booth)
        place.prepare()
        yield place


# ---- what is kept ----


def test_a_ring_keeps_the_newest_in_order() -> None:
    ring = SampleRing()
    for second in range(KEPT + 5):
        ring.add(float(second), second * 2.0)
    points = ring.points(float(KEPT + 5))
    assert len(points) == KEPT
    assert points[0] == (-float(KEPT), 10.0)
    assert points[-1] == (-1.0, (KEPT + 4) * 2.0)


def test_only_numbers_are_kept() -> None:
    samples = TelemetryBuffer()
    samples.take("omni", [("mode", "idle"), ("x", 1.0), ("bad", float("nan"))], 0.0)
    assert samples.names("omni") == ("x",)
    assert samples.points("omni", "x", 1.0) == ((-1.0, 1.0),)
    assert samples.points("kuka1", "x", 1.0) == ()


def test_a_reading_is_kept_once_as_of_when_it_was_heard() -> None:
    samples = TelemetryBuffer()
    for second in range(10):
        jitter_s = 0.01 * (second % 3)  # of the two clocks that an age comes from
        samples.take("omni", [("x", 1.0)], second + 0.5, {"x": second + 0.25 + jitter_s})
    samples.take("omni", [("x", 2.0)], 10.5, {"x": 0.5})
    assert samples.points("omni", "x", 11.0) == ((-10.75, 1.0), (-1.0, 2.0))


def test_a_long_way_is_thinned_and_keeps_its_ends() -> None:
    track = RobotTrack("move", 0)
    for step in range(20 * WAY_POINTS):
        track.add(Pose(float(step), 0.0))
    track.add(Pose(1e6, 0.0), last=True)
    assert WAY_POINTS / 4 < len(track.points) <= WAY_POINTS
    assert track.points[0].x_m == 0.0
    assert track.points[-1].x_m == 1e6
    steps = [b.x_m - a.x_m for a, b in zip(track.points[:-2], track.points[1:-1], strict=True)]
    assert max(steps) <= 4 * min(steps)


# ---- charts ----


async def test_a_chart_shows_what_was_reported(place: Booth) -> None:
    for second in range(5):
        place.robot("omni").values = {"battery": 80.0 - second, "x": 0.5, "mode": "idle"}
        await place.clock.advance(1.0)
    shown = await place.see("chart omni battery")
    (curve, low), *_ = place.renderer.drawn
    assert isinstance(curve, TimeSeries)
    assert not low
    assert (curve.title, curve.unit, curve.alert_below) == ("The omni: battery", "%", 20.0)
    assert [value for _, value in curve.points[-4:]] == [80.0, 79.0, 78.0, 77.0] or [
        value for _, value in curve.points[-4:]
    ] == [79.0, 78.0, 77.0, 76.0]
    assert "battery over" in shown.text
    assert shown.attachment is not None
    assert shown.attachment.name == "omni-battery.png"


async def test_the_words_in_it_are_in_the_language_of_whoever_asked(place: Booth) -> None:
    place.robot("omni").values = {"battery": 80.0}
    await place.clock.advance(3.0)
    await place.see("chart omni battery")
    await place.say("/language de")
    await place.see("chart omni battery")
    assert place.renderer.wrote == ["now", "jetzt"]


async def test_which_value_is_asked_with_buttons(place: Booth) -> None:
    await place.clock.advance(2.0)
    assert await place.say("chart omni") == "Which value of The omni?"
    button, under = place.button("x")
    await place.tap(button, under)
    shown = await place.see("status")
    assert shown is not None
    assert isinstance(place.renderer.drawn[0][0], TimeSeries)


async def test_the_chosen_robots_value_needs_no_name(place: Booth) -> None:
    await place.clock.advance(2.0)
    await place.say("use omni")
    await place.see("chart battery low")
    assert place.renderer.drawn[0][1]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("chart kuka1", "kuka1 reports no numbers to draw."),
        ("chart omni smell", "The omni does not report smell. There is: battery, x."),
        ("trajectory kuka1", "kuka1 does not say where it is, so its way cannot be drawn."),
        ("trajectory omni", "The omni has carried out no order since I was started."),
        ("trajectory omni fast", "Say trajectory, the robot"),
    ],
)
async def test_what_cannot_be_drawn_is_said(place: Booth, line: str, words: str) -> None:
    assert words in await place.say(line)
    assert place.renderer.drawn == []


async def test_a_robot_that_is_away_leaves_a_gap(place: Booth) -> None:
    await place.clock.advance(3.0)
    place.robot("omni").online = False
    before = place.gateway.features.get(MediaFeature).sampler.samples.points("omni", "x", 0.0)
    await place.clock.advance(5.0)
    assert (
        place.gateway.features.get(MediaFeature).sampler.samples.points("omni", "x", 0.0) == before
    )


# ---- ways ----


async def test_the_way_of_the_last_order_is_drawn(place: Booth) -> None:
    robot = place.robot("omni")
    robot.pose = Pose(0.0, 0.0)
    robot.work_s = 10_000.0
    await place.say("omni move 1 m forward")
    robot.pose = Pose(0.5, 0.0)
    await place.clock.advance(0.5)
    robot.finish()
    await place.quiet()
    robot.pose = Pose(9.0, 9.0)  # after its end nobody follows
    shown = await place.see("trajectory omni")
    (way, _), *_ = place.renderer.drawn
    assert isinstance(way, PathView)
    assert way.points[0] == Pose(0.0, 0.0)
    assert Pose(9.0, 9.0) not in way.points
    assert "way of the last order (move" in shown.text
    assert shown.text.endswith(" ago")


async def test_of_a_robot_that_did_not_move_from_its_place_no_way_is_drawn(place: Booth) -> None:
    robot = place.robot("omni")
    robot.work_s = 10_000.0
    robot.pose = Pose(2.0, 1.0, yaw_rad=0.0)
    await place.say("omni wave")
    robot.pose = Pose(2.001, 1.0, yaw_rad=1.5)
    told = await place.say("trajectory omni")
    assert told == "The omni has not moved from its place with this order so far (wave)."
    robot.finish()
    await place.quiet()
    told = await place.say("trajectory omni")
    assert told == "The omni did not move from its place with the last order (wave)."
    assert not place.renderer.drawn


async def test_a_way_goes_on_while_the_order_does(place: Booth) -> None:
    robot = place.robot("omni")
    robot.work_s = 0.3
    robot.pose = Pose(0.0, 0.0)
    await place.say("omni move 1 m forward")
    for step in range(1, 4):
        robot.pose = Pose(step * 0.1, 0.0, step * 0.1)
        await place.clock.advance(0.1)
    shown = await place.see("trajectory omni")
    (way, _), *_ = place.renderer.drawn
    assert isinstance(way, PathView)
    assert [point.x_m for point in way.points[:3]] == pytest.approx([0.0, 0.1, 0.2])
    assert way.vertical
    assert "so far" in shown.text or "last order" in shown.text


async def test_a_robot_that_cannot_be_followed_moves_all_the_same(place: Booth) -> None:
    linker = place.gateway.rooms.linker

    def fails(_robot: str) -> None:
        raise ZeroDivisionError

    presence = linker.presence
    linker.presence = fails  # type: ignore[method-assign, assignment]
    await place.say("omni wave")
    linker.presence = presence  # type: ignore[method-assign]
    assert place.acted() == 1
