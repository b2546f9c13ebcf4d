"""Robots shown live to Foxglove: with a key that is good, as far as it reaches, and read-only."""

from __future__ import annotations

import asyncio
import json
import logging
from contextlib import AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest
from jsonschema import Draft202012Validator
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from rosic.app.admin.api import AdminVerb
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from tests.api.served import served
from tests.gateway.place import ask_as_operator
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable

    from websockets.asyncio.client import ClientConnection
    from websockets.typing import Subprotocol

    from tests.api.served import ServedGateway

PROTOCOL: Subprotocol = "foxglove.sdk.v1"  # type: ignore[assignment]
OLDER: Subprotocol = "foxglove.websocket.v1"  # type: ignore[assignment]


class Viewer:
    """An independent client of the protocol."""

    def __init__(self, connection: ClientConnection) -> None:
        self.connection = connection
        self.channels: dict[str, dict[str, Any]] = {}
        self.told: list[dict[str, Any]] = []
        self.data: dict[str, list[dict[str, Any]]] = {}
        self._topics: dict[int, str] = {}

    async def listen(self) -> None:
        async for frame in self.connection:
            if isinstance(frame, bytes):
                assert frame[0] == 1
                topic = self._topics[int.from_bytes(frame[1:5], "little")]
                message = json.loads(frame[13:])
                Draft202012Validator(json.loads(self.channels[topic]["schema"])).validate(message)
                self.data.setdefault(topic, []).append(message)
                continue
            told = json.loads(frame)
            self.told.append(told)
            for channel in told.get("channels", ()):
                self.channels[channel["topic"]] = channel

    async def subscribe(self, *topics: str) -> None:
        for topic in topics:
            await self.until(lambda topic=topic: topic in self.channels)  # type: ignore[misc]
            number = len(self._topics) + 1
            self._topics[number] = topic
            wanted = {"id": number, "channelId": self.channels[topic]["id"]}
            await self.say(op="subscribe", subscriptions=[wanted])

    async def say(self, **message: Any) -> None:  # noqa: ANN401 - JSON
        await self.connection.send(json.dumps(message))

    async def until(self, holds: Callable[[], object]) -> None:
        async with asyncio.timeout(20 * pace()):
            while not holds():  # noqa: ASYNC110 - whoever listens tells nobody
                await asyncio.sleep(0.01)


@asynccontextmanager
async def viewer(place: ServedGateway, key: str, **how: Any) -> AsyncIterator[Viewer]:  # noqa: ANN401
    url = place.url.replace("http", "ws", 1) + f"/foxglove?key={key}"
    how.setdefault("subprotocols", [PROTOCOL])
    async with connect(url, max_size=None, **how) as connection:
        found = Viewer(connection)
        listening = asyncio.create_task(found.listen())
        try:
            yield found
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)


async def test_a_robot_is_seen_while_it_moves_beside_what_was_asked_of_it() -> None:
    async with served() as place:
        hal = await place.program("operator")
        async with viewer(place, await place.key("viewer", name="Eve")) as eve:
            await eve.subscribe("/omni/orders", "/omni/state", "/omni/pose", "/tf")
            body = {"skill": "move", "arguments": {"distance": 0.3}, "wait_s": 20}
            placed = (await hal.post("/v1/robots/omni/orders", json=body)).json()
            assert placed["state"] == "done"
            await eve.until(lambda: any(one["over"] for one in eve.data.get("/omni/orders", ())))
            assert eve.told[0]["capabilities"] == []
            stages = [one["stage"] for one in eve.data["/omni/orders"]]
            assert stages[0] == "accepted"
            assert stages[-1] == "done"
            # A viewer sees that there was an order, and not what somebody else has said.
            assert all(not one["words"] and not one["by"] for one in eve.data["/omni/orders"])
            places = [one["pose"]["position"]["x"] for one in eve.data["/omni/pose"]]
            assert max(places) - min(places) == pytest.approx(0.3, abs=0.05)
            assert any(one["doing"] == "move" for one in eve.data["/omni/state"])


async def test_a_camera_and_a_map_come_while_they_are_looked_at() -> None:
    async with served() as place, viewer(place, await place.key("viewer")) as eve:
        await eve.subscribe("/omni/camera", "/omni/map")
        await eve.until(lambda: {"/omni/camera", "/omni/map"} <= eve.data.keys())
        assert eve.data["/omni/camera"][0]["format"] == "jpeg"


async def test_a_key_shows_the_robots_that_it_reaches_and_no_other() -> None:
    rules = RoleRules(roles={**DEFAULT_ROLES, "lookout": Role(scopes=("omni:read",))})
    async with served(rules=rules) as place, viewer(place, await place.key("lookout")) as eve:
        await eve.until(lambda: "/omni/state" in eve.channels)
        named = {topic.split("/")[1] for topic in eve.channels}
        assert named <= {"omni", "rosic", "tf"}


@pytest.mark.parametrize("key", ["", "rosic_k1_wrong", "%00", "x" * 4_000])
async def test_without_a_good_key_nobody_looks(key: str) -> None:
    async with served() as place:
        with pytest.raises((InvalidStatus, ConnectionClosed)):
            async with viewer(place, key) as eve:
                await eve.connection.recv()


async def test_a_page_of_another_site_needs_the_key_and_no_cookie_will_do() -> None:
    async with served() as place:
        elsewhere = {"origin": "https://app.foxglove.dev"}
        async with viewer(place, await place.key("viewer"), **elsewhere) as eve:
            await eve.until(lambda: eve.channels)
        ada = await place.person("Ada")
        cookies = "; ".join(f"{name}={value}" for name, value in ada.cookies.items())
        for query in ("?", "?key=", "?akey=x", "?key=rosic_k1_wrong"):
            url = place.url.replace("http", "ws", 1) + f"/foxglove{query}"
            with pytest.raises((InvalidStatus, ConnectionClosed)):
                async with connect(
                    url,
                    additional_headers={"cookie": cookies},
                    subprotocols=[PROTOCOL],
                    **elsewhere,  # type: ignore[arg-type]
                ) as connection:
                    await connection.recv()
        url = place.url.replace("http", "ws", 1) + "/foxglove"
        async with connect(  # our own page may
            url,
            additional_headers={"cookie": cookies},
            subprotocols=[PROTOCOL],
            origin=place.url,  # type: ignore[arg-type]
        ) as connection:
            assert json.loads(await connection.recv())["op"] == "serverInfo"


async def test_whose_key_is_taken_back_sees_nothing_more() -> None:
    async with served() as place:
        key = await place.key("viewer", name="Eve")
        async with viewer(place, key) as eve:
            await eve.subscribe("/omni/state")
            await eve.until(lambda: eve.data.get("/omni/state"))
            await ask_as_operator(place.gateway, AdminVerb.TAKE_KEY, "Eve")
            await eve.until(lambda: eve.connection.close_code is not None)
            assert eve.connection.close_code == 4401


async def test_nothing_can_be_published() -> None:
    async with served() as place, viewer(place, await place.key("senior")) as eve:
        channel = {"id": 1, "topic": "/omni/cmd_vel", "encoding": "json", "schemaName": "Twist"}
        await eve.say(op="advertise", channels=[channel])
        await eve.connection.send(b"\x01\x01\x00\x00\x00{}")
        await eve.until(lambda: sum(one["op"] == "status" for one in eve.told) == 2)
        assert not len(place.gateway.pipeline.executor)


async def test_the_older_protocol_is_spoken_and_no_other() -> None:
    async with served() as place:
        key = await place.key("viewer")
        async with viewer(place, key, subprotocols=[OLDER]) as eve:
            assert eve.connection.subprotocol == OLDER
            await eve.until(lambda: eve.channels)
        async with viewer(place, key, subprotocols=None) as eve:
            await eve.until(lambda: eve.connection.close_code is not None)
            assert eve.connection.close_code == 1002


async def test_one_key_looks_four_times_at_most() -> None:
    async with served() as place:
        key = await place.key("viewer")
        async with AsyncExitStack() as four:
            for _ in range(4):
                await four.enter_async_context(viewer(place, key))
            fifth = await four.enter_async_context(viewer(place, key))
            await fifth.until(lambda: fifth.connection.close_code is not None)
            assert fifth.connection.close_code == 1013
        async with viewer(place, key) as again:
            await again.until(lambda: again.channels)


async def flood(eve: Viewer) -> None:
    async with asyncio.timeout(20 * pace()):
        while True:
            await eve.connection.send("{}")
            await asyncio.sleep(0)  # the other end lives in the same process


async def test_a_flood_of_a_client_ends_its_connection_and_nothing_else() -> None:
    async with served() as place:
        key = await place.key("viewer")
        async with viewer(place, key) as eve, viewer(place, key) as bob:
            with pytest.raises(ConnectionClosed):
                await flood(eve)
            await bob.subscribe("/omni/state")
            await bob.until(lambda: bob.data)


async def test_a_key_stands_in_no_log(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    async with served() as place:
        key = await place.key("viewer")
        async with viewer(place, key) as eve:
            await eve.until(lambda: eve.channels)
        with pytest.raises((InvalidStatus, ConnectionClosed)):
            async with viewer(place, f"{key}wrong") as eve:
                await eve.connection.recv()
    assert key not in caplog.text
