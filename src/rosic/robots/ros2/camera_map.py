"""What can be seen of a robot on ROS 2: camera frames and maps, subscribed to while somebody looks.

A camera sends megabytes a second, so nobody listens to it for nothing. Where the robot is and
means to go is heard all the time, as that is little and may be said only once.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
from math import atan2, isfinite
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.robot.view import CompressedFrame, OccupancyMap, Pose, RawFrame, View, ViewKind
from rosic.core.time_units import DAY_S, SECOND_NS
from rosic.errors import NothingToSee
from rosic.robots.ros2.client.kept_topics import KeptTopics
from rosic.robots.ros2.client.topics import LatestMessage, TopicQos
from rosic.robots.ros2.errors import BadValue, NotSent
from rosic.robots.ros2.messages.coerce import clean_text

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.contracts.clock import Clock
    from rosic.core.robot.view import Content
    from rosic.robots.ros2.client.graph import GraphSnapshot
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.profile import Camera, MapSource, Ros2Profile

FIRST_WITHIN_S = 5.0
MOST_BYTES = 64_000_000
MOST_POINTS = 20_000
AHEAD_S = 1.0  # clocks that agree do so within this
OLDEST_S = float(DAY_S)
STALE_POSE_S = 2.0
RAW = "sensor_msgs/msg/Image"
POSE_ALONE = "geometry_msgs/msg/PoseStamped"
_FRAME_BYTES = 64
# A map is often sent once and kept for whoever comes later; a subscriber that asks for that hears
# nobody who does not, so there are two.
_VOLATILE = TopicQos(reliable=False, depth=1)
_KEPT = TopicQos(reliable=True, latched=True, depth=1)


class CameraAndMap:
    """The camera, the map, the pose and the path of one robot, as far as its profile names them."""

    def __init__(self, profile: Ros2Profile, clock: Clock) -> None:
        self._profile = profile
        self._clock = clock
        self._runtime: RosRuntime | None = None
        self._pose: LatestMessage | None = None
        self._path: LatestMessage | None = None
        self._kept = KeptTopics()

    def types(self) -> set[str]:
        """Return the types of message that it takes."""
        profile = self._profile
        named = (profile.camera, profile.map, profile.pose, profile.path)
        return {source.type for source in named if source is not None}

    async def open(self, runtime: RosRuntime) -> None:
        """Listen to where the robot is and goes. Nothing is asked of camera or map yet."""
        self._runtime = runtime
        pose, path = self._profile.pose, self._profile.path
        if pose is not None:
            self._pose = await runtime.latest(pose.topic, pose.type, _VOLATILE)
        if path is not None:
            self._path = await runtime.latest(path.topic, path.type, _VOLATILE)

    async def close(self) -> None:
        """Listen no more; whoever looks sees nothing new."""
        self._runtime = None
        self._kept.close()
        sources, self._pose, self._path = self._sources(), None, None
        for source in sources:
            await source.close()

    def heed(self, seen: GraphSnapshot) -> None:
        """Take in who is on the graph.

        A localisation speaks of a robot that moves; where it came to rest is kept.
        """
        if self._runtime is not None:
            self._kept.look(self._runtime, seen, self._sources())

    def _sources(self) -> list[LatestMessage]:
        return [source for source in (self._pose, self._path) if source is not None]

    # ---- looking ----

    async def look(self, sight: ViewKind) -> AsyncGenerator[View, None]:
        """Subscribe, and yield what comes; see ``contracts.robot.Robot``."""
        runtime, profile = self._runtime, self._profile
        source = profile.camera if sight is ViewKind.PICTURE else profile.map
        if runtime is None or source is None:
            raise NothingToSee(said("{robot} shows nothing of that kind.", robot=profile.shown))
        news = asyncio.Event()
        qualities = (_VOLATILE,) if sight is ViewKind.PICTURE else (_VOLATILE, _KEPT)
        listening: list[LatestMessage] = []
        try:
            for quality in qualities:
                listening += [await self._listen(runtime, source, quality, news)]
            while True:
                newest = await self._next(listening, news, sight)
                yield await self._view(newest, sight)
        except NotSent as fault:
            sentence = said(
                "{robot} cannot be seen: the link to ROS 2 is closed.", robot=profile.shown
            )
            raise NothingToSee(sentence) from fault
        finally:
            for subscription in listening:
                with suppress(NotSent):
                    await subscription.close()

    async def _listen(
        self,
        runtime: RosRuntime,
        source: Camera | MapSource,
        quality: TopicQos,
        news: asyncio.Event,
    ) -> LatestMessage:
        return await runtime.latest(source.topic, source.type, quality, lambda _: news.set())

    async def _next(
        self, listening: list[LatestMessage], news: asyncio.Event, sight: ViewKind
    ) -> LatestMessage:
        try:
            async with asyncio.timeout(FIRST_WITHIN_S):
                await news.wait()
        except TimeoutError:
            raise NothingToSee(self._nothing_came(sight)) from None
        news.clear()
        return max(listening, key=lambda latest: latest.received_ns or -1)

    def _nothing_came(self, sight: ViewKind) -> str:
        shown, within_s = self._profile.shown, round(FIRST_WITHIN_S)
        if sight is ViewKind.PICTURE:
            return said(
                "{robot} has sent no picture for {seconds} s. Is its camera on?",
                robot=shown,
                seconds=within_s,
            )
        return said("{robot} has sent no map for {seconds} s.", robot=shown, seconds=within_s)

    async def _view(self, latest: LatestMessage, sight: ViewKind) -> View:
        """Decode what came, off the event loop: it may be megabytes."""
        shown = self._profile.shown
        if latest.size_bytes > MOST_BYTES:
            raise NothingToSee(said("What {robot} shows is too large.", robot=shown))
        try:
            message = await asyncio.to_thread(latest.message)
            content = self._content(message, sight)
        except BadValue as fault:
            raise NothingToSee(said("What {robot} shows cannot be read.", robot=shown)) from fault
        return self._dated(content, message, latest.received_ns or 0)

    def _content(self, message: RosObject, sight: ViewKind) -> Content:
        if sight is ViewKind.MAP:
            return self._grid(message)
        if self._profile.camera is not None and self._profile.camera.type == RAW:
            return RawFrame(
                int(message.width),
                int(message.height),
                clean_text(message.encoding, max_bytes=_FRAME_BYTES),
                int(message.step),
                bytes(message.data),
                bool(message.is_bigendian),
            )
        return CompressedFrame(bytes(message.data))

    def _dated(self, content: Content, message: RosObject, received_ns: int) -> View:
        """Take the time of the stamp, unless it is of another clock than ours."""
        stamp = message.header.stamp
        age_ns = self._clock.wall_ns() - (int(stamp.sec) * SECOND_NS + int(stamp.nanosec))
        if not -AHEAD_S * SECOND_NS <= age_ns <= OLDEST_S * SECOND_NS:
            return View(content, received_ns, foreign=True)
        now_ns = self._clock.monotonic_ns()
        return View(content, min(received_ns, now_ns - age_ns))

    # ---- the map ----

    def _grid(self, message: RosObject) -> OccupancyMap:
        info, frame = message.info, _frame(message)
        pose, note = self.pose(), ""
        if pose is not None and not _same(pose.frame, frame):
            note = said(
                "robot not shown: its pose is in {pose}, the map in {map}",
                pose=pose.frame,
                map=frame,
            )
            pose = None
        elif pose is not None and (age_s := self._pose_age_s()) > STALE_POSE_S:
            note = said("robot as of {age_s:.0f} s ago", age_s=age_s)
        elif pose is None and self._profile.pose is not None:
            note = said("robot not shown: no pose heard")
        return OccupancyMap(
            int(info.width),
            int(info.height),
            float(info.resolution),
            _pose(info.origin, frame),
            message.data.tobytes(),
            pose,
            self._way(frame),
            note,
            None if pose is None else self._pose_ns(),
        )

    def pose(self) -> Pose | None:
        """Return where the robot last said that it is."""
        source = self._pose
        try:
            message = None if source is None else source.message()
        except BadValue:
            return None
        if message is None or self._profile.pose is None:
            return None
        alone = self._profile.pose.type == POSE_ALONE
        pose = _pose(message.pose if alone else message.pose.pose, _frame(message))
        return pose if isfinite(pose.x_m) and isfinite(pose.y_m) and isfinite(pose.z_m) else None

    def _pose_ns(self) -> int | None:
        return None if self._pose is None else self._pose.told_ns

    def _pose_age_s(self) -> float:
        age_s = None if self._pose is None else self._pose.told_age_s
        return 0.0 if age_s is None else age_s

    def _way(self, frame: str) -> tuple[tuple[float, float], ...]:
        """Return the newest path, if it is in the map's frame and of a bearable length."""
        newest = self._path
        if newest is None:
            return ()
        try:
            message = newest.message() if newest.size_bytes < MOST_BYTES // 8 else None
        except BadValue:
            return ()
        if message is None or not _same(_frame(message), frame):
            return ()
        places = [stamped.pose.position for stamped in message.poses[:MOST_POINTS]]
        return tuple((float(place.x), float(place.y)) for place in places)


def _frame(message: RosObject) -> str:
    return clean_text(message.header.frame_id, max_bytes=_FRAME_BYTES).lstrip("/")


def _same(one: str, other: str) -> bool:
    """Whether two frames are one, as far as is said."""
    return not one or not other or one == other


def _pose(pose: RosObject, frame: str) -> Pose:
    place, turn = pose.position, pose.orientation
    yaw = atan2(2.0 * (turn.w * turn.z + turn.x * turn.y), 1.0 - 2.0 * (turn.y**2 + turn.z**2))
    return Pose(float(place.x), float(place.y), float(place.z), yaw, frame)
