"""Cameras and maps over a real ROS 2 graph: seen while somebody looks, and dated."""

from __future__ import annotations

import asyncio
from contextlib import aclosing, asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rosic.core.order_gate import OrderGate
from rosic.core.robot.view import CompressedFrame, OccupancyMap, RawFrame, View, ViewKind
from rosic.errors import NothingToSee
from rosic.rendering.draw import draw
from rosic.robots.ros2 import camera_map
from rosic.robots.ros2.client.node import LOOK_EVERY_S
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.profile import (
    Camera,
    MapSource,
    PathSource,
    PoseSource,
    Ros2Link,
    Ros2Profile,
)
from rosic.robots.ros2.robot import Ros2Robot
from rosic.system import SystemClock
from tests.pace import pace, patience
from tests.real.ros2.simulated import opened, shipped, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.robots.ros2.messages.types import TypeRegistry
    from rosic.testing.ros2.graph import RosGraph, RosProcess

EYES = Path(__file__).with_name("eyes.py")
JPEG = Camera(topic="/omni/jpeg")
RAW = Camera(topic="/omni/raw", type="sensor_msgs/msg/Image")


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Until both sides have found each other, nothing comes; a person would look once more."""
    monkeypatch.setattr(camera_map, "FIRST_WITHIN_S", 60.0)


@pytest.fixture
def eyes(graph: RosGraph) -> RosProcess:
    return graph.start(EYES)


@asynccontextmanager
async def robot(camera: Camera = JPEG) -> AsyncIterator[Ros2Robot]:
    profile = Ros2Profile(
        id="omni",
        title="Omni",
        link=Ros2Link(kind="ros2", namespace="/omni"),
        camera=camera,
        map=MapSource(topic="/omni/map"),
        pose=PoseSource(topic="/omni/pose", type="geometry_msgs/msg/PoseStamped"),
        path=PathSource(topic="/omni/path"),
    )
    made = Ros2Robot(profile, OrderGate.new("omni"), SystemClock())
    await made.open(lambda _: None)
    try:
        yield made
    finally:
        await made.close()


async def first(made: Ros2Robot, sight: ViewKind) -> View:
    async with aclosing(made.look(sight)) as views:
        return await anext(views)


async def ask(eyes: RosProcess, line: str) -> None:
    await asyncio.to_thread(eyes.say, line)
    await asyncio.to_thread(eyes.expect, f"ok {line.split(maxsplit=1)[0]}")


@pytest.mark.usefixtures("eyes")
async def test_a_compressed_frame_comes_as_it_was_sent() -> None:
    async with robot() as made:
        view = await first(made, ViewKind.PICTURE)
        assert isinstance(view.content, CompressedFrame)
        assert view.content.data == b"\xff\xd8\xff frame"
        assert not view.foreign
        assert 0 <= SystemClock().monotonic_ns() - view.taken_ns < 5e9 * patience()


@pytest.mark.usefixtures("eyes")
async def test_a_raw_frame_comes_with_its_encoding() -> None:
    async with robot(RAW) as made:
        view = await first(made, ViewKind.PICTURE)
        assert view.content == RawFrame(4, 3, "bgr8", 12, bytes([1, 2, 3] * 12))
        assert isinstance(view.content, RawFrame)
        assert draw(view.content).width == 4


async def test_frames_are_subscribed_to_only_while_somebody_looks(eyes: RosProcess) -> None:
    async with robot() as made:
        await asyncio.to_thread(eyes.expect, "watched 0 0")
        async with aclosing(made.look(ViewKind.PICTURE)) as views:
            await anext(views)
            await asyncio.to_thread(eyes.expect, "watched 1 0")
            one, other = await anext(views), await anext(views)
            assert other.taken_ns > one.taken_ns
        await asyncio.to_thread(eyes.expect, "watched 0 0")


async def test_a_stamp_of_another_clock_is_said_to_be_one(eyes: RosProcess) -> None:
    await ask(eyes, "unstamped")
    async with robot() as made:
        view = await first(made, ViewKind.PICTURE)
        assert view.foreign
        assert 0 <= SystemClock().monotonic_ns() - view.taken_ns < 5e9 * patience()


async def test_what_is_no_picture_is_refused_when_it_is_drawn(eyes: RosProcess) -> None:
    await ask(eyes, "shows nothing")
    async with robot() as made:
        view = await first(made, ViewKind.PICTURE)
        with pytest.raises(NothingToSee, match="neither a JPEG nor a PNG"):
            draw(view.content)


async def test_a_camera_that_is_silent_is_not_waited_for(
    graph: RosGraph, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert graph.domain_id >= 0
    monkeypatch.setattr(camera_map, "FIRST_WITHIN_S", 0.3)
    async with robot() as made:
        for sight, what in ((ViewKind.PICTURE, "picture"), (ViewKind.MAP, "map")):
            async with asyncio.timeout(60 * pace()):
                with pytest.raises(NothingToSee, match=f"^Omni has sent no {what} for"):
                    await first(made, sight)


async def test_a_map_that_was_sent_once_is_seen_with_pose_and_path(eyes: RosProcess) -> None:
    await ask(eyes, "room map")
    await ask(eyes, "goes map")
    async with robot() as made:
        grid = await placed(made, eyes, "map", goes=True)
        assert (grid.width, grid.height, grid.resolution_m) == (3, 2, 0.5)
        assert grid.cells == bytes([0, 100, 255, 50, 0, 0])
        assert grid.origin.x_m == -1.0
        assert grid.pose is not None
        assert (grid.pose.x_m, grid.pose.y_m) == (0.25, 0.5)
        assert grid.pose.yaw_rad == pytest.approx(1.5708, abs=1e-3)
        assert grid.path == ((0.0, 0.0), (1.0, 0.0), (2.0, 0.0))
        assert made.presence().pose == grid.pose
        draw(grid)


async def test_a_pose_in_another_frame_is_not_put_on_the_map(eyes: RosProcess) -> None:
    await ask(eyes, "room map")
    async with robot() as made:
        grid = await placed(made, eyes, "odom")
        assert grid.pose is None
        assert grid.note == "robot not shown: its pose is in odom, the map in map"


@pytest.fixture
async def localiser(graph: RosGraph, types: TypeRegistry) -> AsyncIterator[RosRuntime]:
    """A node of another name than the gateway's, whose own ends do not count."""
    own = RosRuntime.open(types, node_name="localiser", domain_id=graph.domain_id)
    async with await own as runtime:
        yield runtime


async def test_a_pose_that_was_kept_is_as_old_as_it_says(
    localiser: RosRuntime, eyes: RosProcess
) -> None:
    kept = await localiser.publisher(
        "/omni/pose", "geometry_msgs/msg/PoseStamped", TopicQos(latched=True, depth=1)
    )
    kept.publish({"pose.position.x": 0.75, "header.frame_id": "map"})
    await ask(eyes, "room map")
    await asyncio.sleep(camera_map.STALE_POSE_S + 0.1)
    async with robot() as made:
        await until(lambda: made.presence().pose is not None)
        pose = made.presence().pose
        assert pose is not None
        assert pose.x_m == 0.75
        grid = (await first(made, ViewKind.MAP)).content
        assert isinstance(grid, OccupancyMap)
        assert grid.note.startswith("robot as of "), "it was said before anybody looked"


async def test_who_keeps_no_pose_is_not_asked_for_one(localiser: RosRuntime) -> None:
    """It could not be heard so, and would log that the quality of service does not fit."""
    place = await localiser.publisher("/omni/pose", "geometry_msgs/msg/PoseStamped")
    async with robot():
        await until(lambda: place.listeners == 1)
        await asyncio.sleep(2.5 * LOOK_EVERY_S)
        assert len(place.takers()) == 1


async def placed(
    made: Ros2Robot, eyes: RosProcess, frame: str, *, goes: bool = False
) -> OccupancyMap:
    """Return the map once the pose was heard, and the path if it goes: each comes in its time."""
    async with asyncio.timeout(60 * pace()):
        while made.presence().pose is None:
            await ask(eyes, f"stands {frame}")
            await asyncio.sleep(0.05)
        while True:
            view = await first(made, ViewKind.MAP)
            assert isinstance(view.content, OccupancyMap)
            if view.content.path or not goes:
                return view.content


@pytest.mark.usefixtures("interfaces")
async def test_a_simulated_robot_films_itself_and_knows_its_room(graph: RosGraph) -> None:
    await asyncio.to_thread(graph.start, "-m", "rosic", "sim", "omni", ends_with_input=False)
    clock = SystemClock()
    async with opened(shipped("omni"), clock) as made:
        view = await first(made, ViewKind.PICTURE)
        assert isinstance(view.content, CompressedFrame)
        assert draw(view.content).width == 360
        async with asyncio.timeout(60 * pace()):
            while True:  # the pose comes on a topic of its own
                grid = (await first(made, ViewKind.MAP)).content
                assert isinstance(grid, OccupancyMap)
                if grid.pose is not None and not grid.note:
                    break
