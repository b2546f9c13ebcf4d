"""One connection of Foxglove: what is said over a WebSocket of its protocol, version 1.

Frames in, frames out; no I/O. It is read-only: what a client wants to publish, call or set is
answered with a status, and nothing comes of it.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Annotated, Any, Final

import msgspec

from rosic.core.robot.view import ViewKind
from rosic.foxglove.messages import FoxgloveMessages

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rosic.contracts.recording import ChannelDescription, EncodedMessage, Frame
    from rosic.core.robot.observation import Observation, RecordedRobot
    from rosic.core.robot.profile import RobotId

SUBPROTOCOLS: Final = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Newest first; a client says which it speaks. What is sent here is the same in both."""
MESSAGE_DATA: Final = 1
_HEAD: Final = struct.Struct("<BIQ")
WARNING: Final = 1
ERROR: Final = 2

NOT_READ: Final = "That is no message of this protocol."
READ_ONLY: Final = "This connection only shows: nothing was published, called or set."
NO_CHANNEL: Final = "There is no such channel here."
ID_IN_USE: Final = "A subscription of that id is there already."
SHOWN_BY: Final = {"camera": ViewKind.PICTURE, "map": ViewKind.MAP}
"""What a robot shows only while somebody looks, by the last part of its topic."""

_Id = Annotated[int, msgspec.Meta(ge=0, lt=2**32)]


class _Subscription(msgspec.Struct, frozen=True):
    id: _Id
    channel: _Id = msgspec.field(name="channelId")


class _Subscribe(msgspec.Struct, frozen=True):
    subscriptions: Annotated[tuple[_Subscription, ...], msgspec.Meta(max_length=10_000)]


class _Unsubscribe(msgspec.Struct, frozen=True):
    ids: Annotated[tuple[_Id, ...], msgspec.Meta(max_length=10_000)] = msgspec.field(
        name="subscriptionIds"
    )


class _Operation(msgspec.Struct, frozen=True):
    op: Annotated[str, msgspec.Meta(max_length=64)]


_read_operation = msgspec.json.Decoder(_Operation).decode
_read_subscribe = msgspec.json.Decoder(_Subscribe).decode
_read_unsubscribe = msgspec.json.Decoder(_Unsubscribe).decode


class FoxgloveSession:
    """One connection; see ``contracts.recording.ObservationSession``. Not for two threads at once.

    Args:
        robots: That may be seen over it.
        name: What the other end shows as the name of this one.
    """

    def __init__(self, robots: Sequence[RecordedRobot], name: str) -> None:
        self._messages = FoxgloveMessages(robots)
        self._robots = tuple(robots)
        self._name = name
        self._channels: dict[str, int] = {}
        self._topics: dict[int, str] = {}
        self._next = 1
        self._subscribed: dict[int, int] = {}
        self._by_channel: dict[int, int] = {}
        self._newest: dict[int, EncodedMessage] = {}

    @property
    def wanted(self) -> frozenset[tuple[RobotId, ViewKind]]:
        """What robots are to show because somebody looks."""
        found = (self._topics[channel].strip("/").split("/") for channel in self._by_channel)
        return frozenset(
            (parts[0], SHOWN_BY[parts[-1]])
            for parts in found
            if len(parts) == 2 and parts[-1] in SHOWN_BY  # noqa: PLR2004 - robot, and what it shows
        )

    def begin(self) -> tuple[Frame, ...]:
        """Return what is said first: who this is, and what there is to see."""
        info = {
            "op": "serverInfo",
            "name": self._name,
            "capabilities": [],
            "supportedEncodings": ["json"],
            "metadata": {f"robot.{robot.id}": _plain(robot.shown) for robot in self._robots},
        }
        known = list(self._messages.expected())
        return (_json(info), _json({"op": "advertise", "channels": list(self._new(known))}))

    def heard(self, frame: Frame) -> tuple[Frame, ...]:
        """Take in what the other end says, and return what is answered. Never raises."""
        if isinstance(frame, bytes):
            return (_status(ERROR, READ_ONLY),)
        try:
            operation = _read_operation(frame).op
            if operation == "subscribe":
                return tuple(self._subscribe(_read_subscribe(frame).subscriptions))
            if operation == "unsubscribe":
                for number in _read_unsubscribe(frame).ids:
                    self._by_channel.pop(self._subscribed.pop(number, 0), None)
                return ()
        except (msgspec.MsgspecError, UnicodeError):
            return (_status(ERROR, NOT_READ),)
        return (_status(ERROR, READ_ONLY),)

    def _subscribe(self, wanted: Iterable[_Subscription]) -> Iterator[Frame]:
        for one in wanted:
            if one.channel not in self._topics:
                yield _status(WARNING, NO_CHANNEL)
            elif one.id in self._subscribed or one.channel in self._by_channel:
                yield _status(WARNING, ID_IN_USE)
            else:
                self._subscribed[one.id] = one.channel
                self._by_channel[one.channel] = one.id
                if (newest := self._newest.get(one.channel)) is not None:
                    yield _data(one.id, newest)

    def encode(self, seen: Iterable[Observation]) -> tuple[Frame, ...]:
        """Return what is said of what was seen: of what is subscribed to alone."""
        frames: list[Frame] = []
        for message in self._messages.messages(seen):
            channel = self._channels.get(message.channel.topic)
            if channel is None:
                new = list(self._new([message.channel]))
                frames.append(_json({"op": "advertise", "channels": new}))
                channel = self._channels[message.channel.topic]
            self._newest[channel] = message
            subscription = self._by_channel.get(channel)
            if subscription is not None:
                frames.append(_data(subscription, message))
        return tuple(frames)

    def forget(self, robot: RobotId) -> tuple[Frame, ...]:
        """Say that nothing of a robot is to be seen any more, and keep nothing of it."""
        self._messages.forget(robot)
        gone = [
            (topic, channel)
            for topic, channel in self._channels.items()
            if topic.startswith(f"/{robot}/")
        ]
        for topic, channel in gone:
            del self._channels[topic], self._topics[channel]
            self._newest.pop(channel, None)
            number = self._by_channel.pop(channel, None)
            if number is not None:
                del self._subscribed[number]
        # What is common to several robots may be its: nobody is shown that later.
        for topic in ("/tf", "/rosic/events"):
            self._newest.pop(self._channels.get(topic, 0), None)
        if not gone:
            return ()
        return (_json({"op": "unadvertise", "channelIds": [channel for _, channel in gone]}),)

    def _new(self, described: Iterable[ChannelDescription]) -> Iterator[dict[str, object]]:
        """Give channels their numbers, none of them twice, and yield how they are said."""
        for channel in described:
            number = self._channels[channel.topic] = self._next
            self._topics[number] = channel.topic
            self._next += 1
            yield {
                "id": number,
                "topic": channel.topic,
                "encoding": "json",
                "schemaName": channel.schema,
                "schema": channel.definition,
                "schemaEncoding": "jsonschema",
            }


def _json(told: dict[str, Any]) -> str:
    return msgspec.json.encode(told).decode()


def _status(level: int, text: str) -> str:
    return _json({"op": "status", "level": level, "message": text})


def _data(subscription: int, message: EncodedMessage) -> bytes:
    return _HEAD.pack(MESSAGE_DATA, subscription, message.at_ns) + message.content


def _plain(text: str) -> str:
    return text.encode("utf-8", "replace").decode()
