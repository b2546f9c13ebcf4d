"""The official client of rosbridge, unmodified, against a robot on a real ROS 2 graph."""

from __future__ import annotations

import asyncio
import base64
import json
import os
import re
import struct
import sys
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from rosic.api.settings import ApiSettings, OpenedTopicSettings
from rosic.app.config import read_config
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.testing.ros2.graph import RosGraph
from tests.api.bridge_client import bridge
from tests.api.served import ANYWHERE, ServedGateway, served
from tests.pace import pace
from tests.real.ros2.simulated import shipped, simulated, until

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator


CLIENT = Path(__file__).with_name("roslibpy_client.py")
PAGE = Path(__file__).parents[3] / "docs" / "howto" / "rosbridge.md"
LISTENER = Path(__file__).with_name("topic_listener.py")
BURST = 3_000
STRING = "std_msgs/msg/String"
BYTES = "std_msgs/msg/UInt8MultiArray"
TOPICS = (
    OpenedTopicSettings(name="/chatter", type=STRING, robot="omni", publish="share"),
    OpenedTopicSettings(name="/quiet", type=STRING, robot="omni"),
    OpenedTopicSettings(name="/bytes", type=BYTES, robot="omni", publish="share"),
)
SETTINGS = ApiSettings(listen=ANYWHERE, topics=TOPICS)
ROLES = {
    "sharer": Role(scopes=("omni:*", "omni:share")),
    "reader": Role(scopes=("omni:read",)),
    "other": Role(scopes=("kuka1:read",)),
}
RULES = RoleRules(roles=DEFAULT_ROLES | ROLES)


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory, interfaces: Path) -> Iterator[RosGraph]:  # noqa: ARG001 - built before
    folder = tmp_path_factory.mktemp("rosbridge")
    with RosGraph(folder) as graph, simulated(graph, folder, "omni"):
        yield graph


@pytest.fixture
async def place(graph: RosGraph) -> AsyncIterator[ServedGateway]:  # noqa: ARG001 - joined by its variables
    async with served(SETTINGS, rules=RULES, profiles=(shipped("omni"),)) as place:
        await until(lambda: place.gateway.rooms.linker.presence("omni").online is True)
        yield place


@pytest.fixture
async def onlooker(graph: RosGraph) -> AsyncIterator[RosRuntime]:
    types = TypeRegistry([STRING, BYTES])
    async with await RosRuntime.open(
        types, node_name="onlooker", domain_id=graph.domain_id
    ) as runtime:
        yield runtime


async def test_roslibpy_reads_publishes_drives_sends_goals_and_stops(place: ServedGateway) -> None:
    key = await place.key("sharer")
    url = place.url.replace("http", "ws", 1) + "/rosbridge"
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(CLIENT), url, key, stdout=asyncio.subprocess.PIPE
    )
    assert process.stdout is not None
    told: list[str] = []
    async with asyncio.timeout(120 * pace()):
        told += [line.decode().strip() async for line in process.stdout]
    await process.wait()
    assert told == [
        "topics True True False",
        "type nav_msgs/msg/Odometry",
        "time True",
        "chatter True",
        "drive True True",
        "goal SUCCEEDED True",
        "stop True",
        "over",
    ]
    assert place.gateway.rooms.stops["omni"].latched
    skills = [order.skill for order in place.server.context.feed.newest()]
    assert skills == ["move", "drive"]


async def test_the_program_on_the_page_drives(graph: RosGraph, tmp_path: Path) -> None:  # noqa: ARG001 - joined by its variables
    page = PAGE.read_text()
    [table] = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    [program] = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    config = tmp_path / "rosic.toml"
    config.write_text(
        '[[robot]]\nprofile = "omni"\nlink = "ros2"\n[[messenger]]\nkind = "terminal"\n' + table
    )
    config.chmod(0o600)
    read = read_config(config, environ={})
    assert read.config is not None
    assert read.config.api is not None
    asked = replace(read.config.api, listen=ANYWHERE, rosbridge=ANYWHERE)
    async with served(asked, rules=read.config.rulebook, profiles=(shipped("omni"),)) as place:
        await until(lambda: place.gateway.rooms.linker.presence("omni").online is True)
        there = {
            "ROSBRIDGE_URL": f"ws://127.0.0.1:{place.server.rosbridge_port}",
            "ROSIC_KEY": await place.key("panel"),
        }
        running = await asyncio.create_subprocess_exec(
            *(sys.executable, "-c", program),
            env={**os.environ, **there},
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.STDOUT,
        )
        async with asyncio.timeout(120 * pace()):
            out, _ = await running.communicate()
        lines = out.decode().splitlines()
        assert {"heard on the way", "moved True", "at rest True"} <= set(lines), lines
        assert [order.skill for order in place.server.context.feed.newest()] == ["drive"]


async def test_of_what_is_published_nothing_is_lost_and_every_field_is_checked(
    graph: RosGraph, place: ServedGateway
) -> None:
    # A process of its own: one that shared ours would have its turn when the burst is over.
    listener = graph.start(LISTENER, "/chatter", str(2 * BURST), ready=None)
    async with (
        asyncio.timeout(120 * pace()),
        bridge(place, await place.key("sharer")) as client,
    ):
        await client.say("advertise", topic="/chatter", type=STRING)
        found = asyncio.ensure_future(asyncio.to_thread(listener.expect, "heard"))
        while not found.done():
            await client.say("publish", topic="/chatter", msg={"data": "hello"})
            await asyncio.wait((found,), timeout=0.05)
        await found
        for number in range(BURST):
            await client.say("publish", topic="/chatter", msg={"data": str(number)})
        for wrong, why in (
            ({"data": 7}, "data must be text, not a whole number"),
            ({"data": None}, "data must be text, not nothing"),
            ({"datum": "x"}, "has no field 'datum'; did you mean data?"),
        ):
            await client.say("publish", topic="/chatter", msg=wrong)
            assert why in await client.status()
        await client.say("publish", topic="/chatter", msg={"data": "last"})
        heard = await asyncio.to_thread(listener.expect, "all")
    assert heard.split() == [*(str(number) for number in range(BURST)), "last"]


async def test_what_was_published_is_sent_before_its_topic_is_given_up(
    graph: RosGraph, place: ServedGateway
) -> None:
    listener = graph.start(LISTENER, "/chatter", str(2 * BURST), ready=None)
    async with (
        asyncio.timeout(120 * pace()),
        bridge(place, await place.key("sharer")) as held,
        bridge(place, await place.key("sharer", name="Sal")) as client,
    ):
        for each in (held, client):
            await each.say("advertise", topic="/chatter", type=STRING)
        found = asyncio.ensure_future(asyncio.to_thread(listener.expect, "heard"))
        while not found.done():
            await held.say("publish", topic="/chatter", msg={"data": "hello"})
            await asyncio.wait((found,), timeout=0.05)
        for word in ("0", "1"):  # each in one piece with what gives its topic up
            await client.say("advertise", topic="/chatter", type=STRING)
            client.socket.transport.write(
                masked({"op": "publish", "topic": "/chatter", "msg": {"data": word}})
                + masked({"op": "unadvertise", "topic": "/chatter"})
            )
        await client.say("call_service", service="/rosapi/get_time", id="after")
        await client.op("service_response")
        await held.say("publish", topic="/chatter", msg={"data": "last"})
        heard = await asyncio.to_thread(listener.expect, "all")
    assert heard.split() == ["0", "1", "last"]


def masked(message: dict[str, Any]) -> bytes:
    """Return a message as the frame in which a client sends it."""
    content = json.dumps(message).encode()
    return bytes([0x81, 0x80 | len(content), 0, 0, 0, 0]) + content


async def test_bytes_are_base64_and_forms_are_none_png_and_cbor(
    place: ServedGateway, onlooker: RosRuntime
) -> None:
    publisher = await onlooker.publisher("/bytes", BYTES)
    async with bridge(place, await place.key("sharer")) as client:
        message = {"data": base64.b64encode(bytes(range(256))).decode()}
        for form in ("none", "png", "cbor"):
            await client.say("subscribe", topic="/bytes", id=form, compression=form)
            await until(lambda: publisher.listeners >= 1)
            await client.say("publish", topic="/bytes", msg=message)
            raw = await client.socket.recv()
            if form == "cbor":
                assert isinstance(raw, bytes)
                assert b"data\x59\x01\x00" + bytes(range(256)) in raw
            else:
                told: dict[str, Any] = json.loads(raw)
                told = json.loads(pixels(told["data"])) if form == "png" else told
                assert (told["op"], told["topic"]) == ("publish", "/bytes")
                assert told["msg"]["data"] == message["data"]
            await client.say("unsubscribe", topic="/bytes")
            await until(lambda: publisher.listeners == 0)


def pixels(data: str) -> str:
    """Return the text in the pixels of a picture, as a client would."""
    content = base64.b64decode(data)
    width, _ = struct.unpack(">II", content[16:24])
    at, lines = 8, b""
    while at < len(content):
        (size,) = struct.unpack(">I", content[at : at + 4])
        if content[at + 4 : at + 8] == b"IDAT":
            lines += content[at + 8 : at + 8 + size]
        at += size + 12
    plain = zlib.decompress(lines)
    row = width * 3 + 1
    return b"".join(plain[n + 1 : n + row] for n in range(0, len(plain), row)).decode()


@pytest.mark.parametrize(
    ("role", "op", "topic", "allowed"),
    [
        ("sharer", "publish", "/chatter", True),
        ("reader", "publish", "/chatter", False),
        ("sharer", "publish", "/quiet", False),
        ("sharer", "publish", "/omni/odom", False),
        ("sharer", "publish", "/elsewhere", False),
        ("other", "subscribe", "/chatter", False),
        ("reader", "subscribe", "/chatter", True),
        ("reader", "subscribe", "/omni/odom", True),
        ("reader", "subscribe", "/rosout", False),
    ],
)
async def test_a_topic_is_used_by_whoever_may(
    place: ServedGateway, role: str, op: str, topic: str, *, allowed: bool
) -> None:
    async with bridge(place, await place.key(role)) as client:
        fields = {"msg": {"data": "x"}} if op == "publish" else {}
        await client.say(op, topic=topic, id="asked", **fields)
        await asyncio.sleep(0.2)
        await client.say("call_service", service="/rosapi/get_time", id="after")
        found = await client.until(
            lambda m: m["op"] == "service_response" or m.get("id") == "asked"
        )
        assert (found["op"] == "service_response") is allowed


async def test_a_client_that_takes_nothing_costs_the_others_nothing(
    place: ServedGateway, onlooker: RosRuntime
) -> None:
    publisher = await onlooker.publisher("/chatter", STRING)
    key, text = await place.key("sharer"), "x" * 30_000
    async with bridge(place, key) as stalled, bridge(place, key) as client:
        stalled.socket.transport.pause_reading()
        for each in (stalled, client):
            await each.say("subscribe", topic="/chatter")
        await until(lambda: publisher.listeners >= 1)
        for number in range(400):
            publisher.publish({"data": f"{number} {text}"})
            told = json.loads(await client.socket.recv())
            assert told["msg"]["data"].startswith(f"{number} ")


async def test_after_a_stop_nothing_is_published(place: ServedGateway) -> None:
    hal = await place.program("operator")
    async with (
        bridge(place, await place.key("sharer", name="Sal")) as before,
        bridge(place, await place.key("sharer", name="Sue")) as after,
    ):
        await before.say("advertise", topic="/chatter", type=STRING)
        await before.say("call_service", service="/rosapi/get_time")
        await before.op("service_response")
        await hal.post("/v1/stop", json={"robots": ["omni"]})
        for client in (before, after):
            await client.say("publish", topic="/chatter", msg={"data": "x"}, id="p")
            assert "is stopped" in await client.status()
