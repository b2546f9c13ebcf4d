"""What was seen of robots, as messages that Foxglove knows: JSON, each with its schema.

The same messages go into a file and over a connection. A state is said again when it has changed,
and once a second all the same. A value is said of the moment at which it was heard, and once:
again when it was heard again, as another one, or a second later.
"""

from __future__ import annotations

from base64 import b64encode
from functools import cache
from math import cos, isfinite, sin
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.contracts.recording import ChannelDescription, EncodedMessage
from rosic.core.robot.observation import (
    NoticeObservation,
    OrderObservation,
    PresenceObservation,
    ViewObservation,
)
from rosic.core.robot.view import Drawing, Pose, ViewKind
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rosic.core.robot.observation import Observation, RecordedRobot
    from rosic.core.robot.profile import Presence, RobotId
    from rosic.core.robot.view import OccupancyMap

SCHEMAS: Final = Path(__file__).with_name("schemas.json")
"""Those of Foxglove as they publish them, and three of our own."""
AGAIN_NS: Final = SECOND_NS
SAME_NS: Final = SECOND_NS // 10
"""So far two looks may differ on when one reading was heard."""
INFO, WARNING = 2, 3
UINT8: Final = 1
EARTH_FIXED: Final = frozenset({"map", "world", "earth"})
"""Frames that robots have in common (REP 105); each has its own of any other name."""
LONGEST: Final = 2_000
"""Letters of a text that a message repeats."""

_encode = msgspec.json.Encoder(enc_hook=lambda _other: None).encode


@cache
def schemas() -> Mapping[str, str]:
    """Return the definition of every schema, as JSON Schema, by its name."""
    read = msgspec.json.decode(SCHEMAS.read_bytes(), type=dict[str, msgspec.Raw])
    return {name: bytes(definition).decode() for name, definition in read.items()}


class FoxgloveMessages:
    """Makes messages for one reader; it says a thing once until it changes."""

    def __init__(self, robots: Iterable[RecordedRobot]) -> None:
        self._robots = {robot.id: robot for robot in robots}
        self._channels: dict[str, ChannelDescription] = {}
        self._said: dict[str, tuple[int, object]] = {}

    def messages(self, seen: Iterable[Observation]) -> Iterator[EncodedMessage]:
        """Yield what is said of it, in order; of robots that nobody named, nothing. Total."""
        for one in seen:
            if one.robot not in self._robots:
                continue
            if isinstance(one, PresenceObservation):
                yield from self._presence(one)
            elif isinstance(one, OrderObservation):
                yield self._order(one)
            elif isinstance(one, NoticeObservation):
                yield self._notice(one)
            else:
                yield from self._view(one)

    def expected(self) -> Iterator[ChannelDescription]:
        """Yield what will be said, as far as that is known before anything was seen."""
        yield self._channel("/rosic/events", "foxglove.Log")
        for robot in self._robots.values():
            yield self._channel(f"/{robot.id}/state", "rosic.RobotState")
            yield self._channel(f"/{robot.id}/orders", "rosic.Order")
            for name, unit in robot.units.items():
                topic = f"/{robot.id}/telemetry/{_text(name)}"
                yield self._channel(topic, "rosic.TelemetryValue", (("unit", _text(unit)),))
            if ViewKind.MAP in robot.sights:
                yield self._channel(f"/{robot.id}/map", "foxglove.Grid")
            if ViewKind.PICTURE in robot.sights:
                yield self._channel(f"/{robot.id}/camera", "foxglove.CompressedImage")

    def forget(self, robot: RobotId) -> None:
        """Say nothing of a robot any more, and keep nothing of it."""
        self._robots.pop(robot, None)
        for topic in [topic for topic in self._said if topic.startswith(f"/{robot}/")]:
            del self._said[topic]

    # ---- what was asked ----

    def _order(self, one: OrderObservation) -> EncodedMessage:
        content = {
            "robot": one.robot,
            "order": one.order,
            "n": one.n,
            "skill": _text(one.skill),
            "stage": one.stage,
            "over": one.over,
            "by": one.by,
            "words": _text(one.words),
            "arguments": _values(one.arguments),
            "note": _text(one.note),
            "facts": _values(one.facts),
            "code": one.code,
            **_known(fraction=one.fraction),
        }
        return self._message(f"/{one.robot}/orders", "rosic.Order", one.at_ns, content)

    def _notice(self, one: NoticeObservation) -> EncodedMessage:
        content = {
            "level": WARNING if one.grave else INFO,
            "message": _text(one.text),
            "name": one.robot,
            "file": "",
            "line": 0,
        }
        return self._message("/rosic/events", "foxglove.Log", one.at_ns, content)

    # ---- what moved ----

    def _presence(self, one: PresenceObservation) -> Iterator[EncodedMessage]:
        robot, presence, at_ns = one.robot, one.presence, one.at_ns
        state = _state(presence, stopped=one.stopped)
        if self._is_news(f"/{robot}/state", at_ns, state):
            content = {"robot": robot, **state, **_known(heard_s_ago=presence.age_s)}
            yield self._message(f"/{robot}/state", "rosic.RobotState", at_ns, content)
        pose = presence.pose
        if pose is not None and _is_place(pose) and self._is_news(f"/{robot}/pose", at_ns, pose):
            yield from self._pose(robot, at_ns, pose)
        for name, value in presence.values.items():
            topic = f"/{robot}/telemetry/{_text(name)}"
            heard_ns = at_ns - int(max(0.0, presence.ages_s.get(name, 0.0)) * SECOND_NS)
            if self._is_news(topic, heard_ns, value):
                yield self._value(robot, topic, name, value, heard_ns)

    def _pose(self, robot: RobotId, at_ns: int, pose: Pose) -> Iterator[EncodedMessage]:
        frame = _frame(robot, pose.frame, "odom")
        placed = _pose(pose)
        content = {"frame_id": frame, "pose": placed}
        yield self._message(f"/{robot}/pose", "foxglove.PoseInFrame", at_ns, content)
        transform = {
            "parent_frame_id": frame,
            "child_frame_id": f"{robot}/base_link",
            "translation": placed["position"],
            "rotation": placed["orientation"],
        }
        yield self._message("/tf", "foxglove.FrameTransform", at_ns, transform)

    def _value(
        self, robot: RobotId, topic: str, name: str, value: float | str, at_ns: int
    ) -> EncodedMessage:
        unit = _text(self._robots[robot].units.get(name, ""))
        told = {"text": _text(value)} if isinstance(value, str) else {"value": value}
        if not isinstance(value, str) and not isfinite(value):
            told = {"text": str(value)}  # JSON has no word for it
        about = (("unit", unit),)
        return self._message(topic, "rosic.TelemetryValue", at_ns, {**told, "unit": unit}, about)

    # ---- what it shows ----

    def _view(self, one: ViewObservation) -> Iterator[EncodedMessage]:
        robot, at_ns, content = one.robot, one.at_ns, one.content
        if isinstance(content, Drawing):
            picture = {
                "frame_id": f"{robot}/camera",
                "data": b64encode(content.content).decode(),
                "format": content.media_type.removeprefix("image/"),
            }
            topic = f"/{robot}/camera"
            yield self._message(topic, "foxglove.CompressedImage", at_ns, picture)
            return
        frame = _frame(robot, content.origin.frame, "map")
        if self._is_news(f"/{robot}/map", at_ns, (content.cells, content.origin), again=False):
            yield self._message(f"/{robot}/map", "foxglove.Grid", at_ns, _grid(content, frame))
        if content.pose is not None and _is_place(content.pose):
            placed = {"frame_id": frame, "pose": _pose(content.pose)}
            yield self._message(f"/{robot}/map_pose", "foxglove.PoseInFrame", at_ns, placed)
        way = [_pose(Pose(x_m, y_m)) for x_m, y_m in content.path if _is_place(Pose(x_m, y_m))]
        if way:
            planned = {"frame_id": frame, "poses": way}
            yield self._message(f"/{robot}/path", "foxglove.PosesInFrame", at_ns, planned)

    # ---- messages ----

    def _is_news(self, topic: str, at_ns: int, what: object, *, again: bool = True) -> bool:
        before = self._said.get(topic)
        same = before is not None and before[1] == what
        if before is not None and same and (not again or -SAME_NS <= at_ns - before[0] < AGAIN_NS):
            return False
        self._said[topic] = (at_ns, what)
        return True

    def _message(
        self,
        topic: str,
        schema: str,
        at_ns: int,
        content: dict[str, Any],
        about: tuple[tuple[str, str], ...] = (),
    ) -> EncodedMessage:
        channel = self._channel(topic, schema, about)
        sec, nsec = divmod(max(0, at_ns), SECOND_NS)
        encoded = _encode({"timestamp": {"sec": sec, "nsec": nsec}, **content})
        return EncodedMessage(channel, max(0, at_ns), encoded)

    def _channel(
        self, topic: str, schema: str, about: tuple[tuple[str, str], ...] = ()
    ) -> ChannelDescription:
        channel = self._channels.get(topic)
        if channel is None:
            channel = ChannelDescription(topic, schema, schemas()[schema], about)
            self._channels[topic] = channel
        return channel


def _text(text: str) -> str:
    """Return a text as it can be written: without lone surrogates, not endless."""
    return text[:LONGEST].encode("utf-8", "replace").decode()


def _values(values: Mapping[str, float | str]) -> dict[str, float | str]:
    return {
        _text(name): _text(value) if isinstance(value, str) else value
        for name, value in values.items()
    }


def _known(**values: float | bool | None) -> dict[str, float | bool]:
    """Return what is known; what is not, or is no number, is absent, as the schemas say."""
    return {name: value for name, value in values.items() if value is not None and isfinite(value)}


def _state(presence: Presence, *, stopped: bool) -> dict[str, float | bool | str]:
    return {
        "doing": _text(presence.doing),
        "stopped": stopped,
        "doubt": _text(presence.doubt),
        **_known(online=presence.online, at_rest=presence.at_rest, holds=presence.holds),
    }


def _frame(robot: RobotId, named: str, otherwise: str) -> str:
    """Return a frame of which nobody takes another robot's for it."""
    named = _text(named).strip("/") or otherwise
    if named in EARTH_FIXED or named.startswith(f"{robot}/"):
        return named
    return f"{robot}/{named}"


def _is_place(pose: Pose) -> bool:
    """Whether it says where: JSON has no word for what is no number, and 3D no place."""
    return all(map(isfinite, (pose.x_m, pose.y_m, pose.z_m, pose.yaw_rad or 0.0)))


def _pose(pose: Pose) -> dict[str, dict[str, float]]:
    half = (pose.yaw_rad or 0.0) / 2
    return {
        "position": {"x": pose.x_m, "y": pose.y_m, "z": pose.z_m},
        "orientation": {"x": 0.0, "y": 0.0, "z": sin(half), "w": cos(half)},
    }


def _grid(grid: OccupancyMap, frame: str) -> dict[str, Any]:
    return {
        "frame_id": frame,
        "pose": _pose(grid.origin),
        "column_count": grid.width,
        "cell_size": {"x": grid.resolution_m, "y": grid.resolution_m},
        "row_stride": grid.width,
        "cell_stride": 1,
        "fields": [{"name": "occupancy", "offset": 0, "type": UINT8}],
        "data": b64encode(grid.cells).decode(),
    }
