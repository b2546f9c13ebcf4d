"""Foxglove's WebSocket protocol, as its specification has it; and whatever else is said over it."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from rosic.core.robot.observation import (
    NoticeObservation,
    Observation,
    PresenceObservation,
    RecordedRobot,
    ViewObservation,
)
from rosic.core.robot.profile import Presence
from rosic.core.robot.view import OccupancyMap, Pose, ViewKind
from rosic.foxglove.session import FoxgloveSession

NOW_NS = 1_800_000_000_000_000_000
OMNI = RecordedRobot("omni", "Omni", {"battery": "%"}, (ViewKind.MAP, ViewKind.PICTURE))
KUKA = RecordedRobot("kuka1", "KUKA", {})


class Client:
    """The other end, as simple as can be."""

    def __init__(self) -> None:
        self.session = FoxgloveSession([OMNI, KUKA], "lab")
        self.channels: dict[str, dict[str, Any]] = {}
        self.told: list[dict[str, Any]] = []
        self.data: list[tuple[int, int, dict[str, Any]]] = []
        self.take(self.session.begin())

    def take(self, frames: tuple[str | bytes, ...]) -> None:
        for frame in frames:
            if isinstance(frame, bytes):
                code, subscription, at_ns = struct.unpack_from("<BIQ", frame)
                assert code == 1
                self.data.append((subscription, at_ns, json.loads(frame[13:])))
                continue
            message = json.loads(frame)
            self.told.append(message)
            if message["op"] == "advertise":
                for channel in message["channels"]:
                    assert channel["topic"] not in self.channels
                    self.channels[channel["topic"]] = channel
            elif message["op"] == "unadvertise":
                gone = set(message["channelIds"])
                self.channels = {t: c for t, c in self.channels.items() if c["id"] not in gone}

    def say(self, **message: Any) -> None:  # noqa: ANN401
        self.take(self.session.heard(json.dumps(message)))

    def subscribe(self, number: int, topic: str) -> None:
        self.say(
            op="subscribe",
            subscriptions=[{"id": number, "channelId": self.channels[topic]["id"]}],
        )

    def see(self, *seen: Observation) -> None:
        self.take(self.session.encode(seen))


def presence(robot: str = "omni", *, tenths: int = 0, battery: float = 80.0) -> Observation:
    reported = Presence(online=True, values={"battery": battery}, pose=Pose(1, 2, frame="odom"))
    at_ns = NOW_NS + tenths * 100_000_000
    return PresenceObservation(at_ns=at_ns, robot=robot, presence=reported)


def test_it_says_first_who_it_is_and_what_there_is() -> None:
    client = Client()
    first, second = client.told
    assert (first["op"], first["name"], first["capabilities"]) == ("serverInfo", "lab", [])
    assert second["op"] == "advertise"
    assert {"/omni/orders", "/omni/state", "/omni/telemetry/battery"} <= client.channels.keys()
    assert "/kuka1/camera" not in client.channels
    for channel in client.channels.values():
        assert (channel["encoding"], channel["schemaEncoding"]) == ("json", "jsonschema")
        definition = json.loads(channel["schema"])
        Draft202012Validator.check_schema(definition)
        assert definition["title"] == channel["schemaName"]


def test_what_is_subscribed_to_comes_and_nothing_else() -> None:
    client = Client()
    client.see(presence())
    assert client.data == []
    client.subscribe(7, "/omni/telemetry/battery")
    [(number, at_ns, value)] = client.data  # the newest at once
    assert (number, at_ns, value["value"], value["unit"]) == (7, NOW_NS, 80.0, "%")
    client.see(presence(tenths=1, battery=79.0))
    assert [(n, v["value"]) for n, _, v in client.data[1:]] == [(7, 79.0)]
    client.say(op="unsubscribe", subscriptionIds=[7])
    client.see(presence(tenths=2, battery=78.0))
    assert len(client.data) == 2
    client.subscribe(7, "/omni/pose")  # an id may be used again
    assert client.data[-1][2]["frame_id"] == "omni/odom"


def test_of_a_robot_that_may_not_be_seen_any_more_nothing_is_left() -> None:
    client = Client()
    client.see(presence(), presence("kuka1"))
    client.subscribe(1, "/omni/state")
    client.subscribe(2, "/tf")
    client.subscribe(3, "/kuka1/state")
    client.take(client.session.forget("omni"))
    assert not any(topic.startswith("/omni/") for topic in client.channels)
    before = len(client.data)
    client.see(presence(tenths=20), presence("kuka1", tenths=20))
    assert {number for number, _, _ in client.data[before:]} == {2, 3}
    assert "omni" not in json.dumps([message for _, _, message in client.data[before:]])
    client.say(op="unsubscribe", subscriptionIds=[2])
    client.take(client.session.forget("kuka1"))
    before = len(client.data)
    client.subscribe(4, "/tf")
    assert len(client.data) == before
    assert client.session.forget("omni") == ()


def test_what_is_looked_at_is_wanted() -> None:
    client = Client()
    assert client.session.wanted == frozenset()
    client.subscribe(1, "/omni/camera")
    client.subscribe(2, "/omni/map")
    assert client.session.wanted == {("omni", ViewKind.PICTURE), ("omni", ViewKind.MAP)}
    grid = OccupancyMap(1, 1, 0.05, Pose(0, 0, frame="map"), b"\0")
    client.see(ViewObservation(at_ns=NOW_NS, robot="omni", content=grid))
    assert [number for number, _, _ in client.data] == [2]
    client.say(op="unsubscribe", subscriptionIds=[1])
    assert client.session.wanted == {("omni", ViewKind.MAP)}


@pytest.mark.parametrize(
    "message",
    [
        {"op": "advertise", "channels": [{"id": 1, "topic": "/omni/cmd_vel", "encoding": "json"}]},
        {"op": "setParameters", "parameters": [{"name": "a", "value": 1}]},
        {"op": "getParameters", "parameterNames": []},
        {"op": "subscribeConnectionGraph"},
        {"op": "fetchAsset", "uri": "file:///etc/passwd", "requestId": 1},
    ],
)
def test_nothing_can_be_published_called_or_set(message: dict[str, Any]) -> None:
    client = Client()
    client.say(**message)
    assert client.told[-1] == {
        "op": "status",
        "level": 2,
        "message": "This connection only shows: nothing was published, called or set.",
    }


def test_a_message_of_a_client_to_a_robot_is_told_that_nothing_came_of_it() -> None:
    client = Client()
    client.take(client.session.heard(struct.pack("<BI", 1, 1) + b"{}"))
    assert client.told[-1]["level"] == 2


def test_wrong_subscriptions_are_answered() -> None:
    client = Client()
    client.say(op="subscribe", subscriptions=[{"id": 1, "channelId": 9_999}])
    assert client.told[-1]["message"] == "There is no such channel here."
    client.subscribe(1, "/omni/state")
    client.subscribe(1, "/omni/orders")
    assert client.told[-1]["message"] == "A subscription of that id is there already."
    client.subscribe(2, "/omni/state")
    assert client.told[-1]["message"] == "A subscription of that id is there already."
    client.say(op="unsubscribe", subscriptionIds=[77])
    client.see(NoticeObservation(at_ns=NOW_NS, robot="omni", text="was stopped"))


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=8,
)


@given(
    st.text()
    | st.binary()
    | st.builds(
        lambda op, more: json.dumps({"op": op, **more}),
        st.sampled_from(["subscribe", "unsubscribe", "advertise", "x"]),
        st.dictionaries(
            st.sampled_from(["subscriptions", "subscriptionIds", "channels"]), JSON, max_size=2
        ),
    )
)
@settings(deadline=None, max_examples=300)
def test_whatever_is_said_is_answered_and_breaks_nothing(frame: str | bytes) -> None:
    client = Client()
    client.take(client.session.heard(frame))
    client.subscribe(123, "/omni/state")
    client.see(presence())
    assert client.data[-1][0] == 123
