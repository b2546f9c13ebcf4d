"""What clients of rosbridge are refused: how it is named, and when a robot is seen no more."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any, Final

from rosic.api.rosbridge.shared import GOES_ON_S, WRITTEN
from rosic.stores.memory import MemoryStore
from tests.api.bridge_client import bridge, later
from tests.api.served import problem, served
from tests.api.test_rosbridge import AHEAD, CMD_VEL, StoppedGraph, drive, x_m
from tests.pace import pace

if TYPE_CHECKING:
    import httpx
    import pytest


MOVE: Final = {"skill": "move", "arguments": {"distance": 0.1}}


async def written(hal: httpx.AsyncClient, asked: str) -> list[str]:
    """Return the codes of refusals in the record, of what was asked so."""
    found = (await hal.get("/v1/history", params={"limit": 1_000})).json()
    return [one["outcome"] for one in found if one["asked"].startswith(asked)]


async def until_written(hal: httpx.AsyncClient, asked: str, number: int) -> list[str]:
    async with asyncio.timeout(30 * pace()):
        while True:
            found = await written(hal, asked)
            if len(found) >= number:
                return found
            await asyncio.sleep(0.05)


async def test_what_was_refused_is_named_in_the_words_of_the_protocol() -> None:
    said: tuple[tuple[dict[str, Any], str], ...] = (
        ({"op": "subscribe", "topic": "/nope1"}, "subscribe /nope1"),
        ({"op": "advertise", "topic": "/nope2", "type": "a/B"}, "advertise /nope2"),
        ({"op": "publish", "topic": "/nope3", "msg": {}}, "publish /nope3"),
        ({"op": "cancel_action_goal", "action": "/nope4"}, "cancel_action_goal /nope4"),
        ({"op": "fly", "id": "7"}, "fly"),
        ({"op": "publish", "id": "8"}, "publish"),
        ({}, "message"),
    )
    async with served() as place:
        key = await place.key("operator")
        async with bridge(place, key) as client:
            for message, _ in said:
                await client.socket.send(json.dumps(message))
                await client.status()
        hal, noted = place.client({"Authorization": f"Bearer {key}"}), set[str]()
        async with asyncio.timeout(30 * pace()):
            while len(noted) < len(said):
                await asyncio.sleep(0.05)
                noted = {one["asked"] for one in (await hal.get("/v1/history")).json()}
        assert noted == {words for _, words in said}


async def test_what_was_told_at_once_is_not_said_again_by_the_next_run() -> None:
    store, nowhere = MemoryStore(), MOVE | {"arguments": {"distance": 1_000}}
    async with served(store=store) as place:
        key = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {key}"})
        async with bridge(place, key) as client:
            await client.say("publish", topic="/nope", msg={})
            await client.status()
        await until_written(hal, "publish /nope", 1)
        refused = await hal.post("/v1/robots/omni/orders", json=nowhere)
        assert problem(refused)[1] == "out-of-bounds"
        await hal.post("/v1/robots/omni/orders", json=MOVE | {"wait_s": 20})
        await hal.post("/v1/stop", json={"robots": ["omni"]})
        stopped = await hal.post("/v1/robots/omni/orders", json=MOVE)
        assert problem(stopped)[1] == "robot-stopped"
    async with served(store=store) as place:
        hal = place.client({"Authorization": f"Bearer {key}"})
        answer = (await hal.post("/v1/chat", json={"text": "status omni"})).json()
        assert answer["besides"] == []


class OpenGraph:
    """What stands for a graph with many topics, each of which is opened at once."""

    stop_service, reported = StoppedGraph.stop_service, StoppedGraph.reported

    def __init__(self) -> None:
        self.looked = 0

    def of(self, robot: str) -> OpenGraph | None:
        self.looked += 1
        return self if robot == "omni" else None

    async def listen(self, *_: object) -> OpenGraph:
        return self

    async def close(self) -> None:
        """Nothing is listened to."""


async def test_who_sees_a_robot_no_more_is_told_nothing_of_it_and_looking_costs_little(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    graph = OpenGraph()
    async with served() as place, bridge(place, await place.key("operator")) as client:
        monkeypatch.setattr(place.gateway.rooms.linker, "graph_topics", graph.of)
        for name in graph.reported:
            await client.say("subscribe", topic=name)
        await client.say("set_level", level="info")
        await client.say("unsubscribe", topic="/none", id="all was heard")
        await client.say("call_service", service="/rosapi/get_time", id="heard")
        await client.op("service_response")
        graph.looked = 0
        monkeypatch.setattr(type(place.server.context), "visible", lambda *_: frozenset())
        over = {await client.status() for _ in graph.reported}
        assert over == {
            f"There is no topic {name} here that you may use." for name in graph.reported
        }
        assert graph.looked == 0


async def test_motion_that_is_refused_for_want_of_zeros_is_in_the_record_but_not_all_the_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place:
        key = await place.key("operator")
        hal, asked = place.client({"Authorization": f"Bearer {key}"}), f"publish {CMD_VEL}"
        async with bridge(place, key) as client:
            driving = asyncio.create_task(drive(client, 60 * pace()))
            await place.until(lambda: x_m(place) > 0.02)
            driving.cancel()
            await client.until(lambda m: "the controls fell silent" in m.get("msg", ""))
            for _ in range(3):
                await client.say("publish", topic=CMD_VEL, msg=AHEAD)
                assert "Publish zeros" in await client.status()
                later(monkeypatch, 2.0)
            assert await until_written(hal, asked, 1) == ["order-void"]
            later(monkeypatch, GOES_ON_S)
            await client.say("publish", topic=CMD_VEL, msg=AHEAD)
            assert await until_written(hal, asked, 2) == ["order-void"] * 2
            place.chat.say("stop", account="ada")
            await place.until(lambda: place.gateway.rooms.stops["omni"].latched)
            await client.say("publish", topic=CMD_VEL, msg=AHEAD)
            assert "robot-stopped" in await until_written(hal, asked, 3)


async def test_a_flood_of_what_is_refused_fills_no_record() -> None:
    flood = 4 * int(WRITTEN.burst)
    async with served() as place:
        key = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {key}"})
        async with bridge(place, key) as client:
            for number in range(flood):
                await client.say("publish", topic=f"/nope{number}", msg={})
            for _ in range(flood):
                await client.status()
        most = int(WRITTEN.burst)
        assert most <= len(await until_written(hal, "publish /nope", most)) < flood / 2


async def test_every_spelling_of_a_topic_is_the_same_publisher_until_it_is_given_up() -> None:
    async with served() as place:
        key = await place.key("operator")
        async with bridge(place, key) as client:
            await client.say("set_level", level="info")
            for topic in ("omni/cmd_vel", "/omni/cmd_vel", "//omni/cmd_vel/"):
                await client.say("publish", topic=topic, msg=AHEAD)
            assert await client.status("info") == "omni is driven by /omni/cmd_vel now."
            await client.say("unadvertise", topic="omni/cmd_vel/")
            await client.say("unadvertise", topic="/omni/cmd_vel")
            assert await client.status("warning") == "You publish to no /omni/cmd_vel."
            told = [one["msg"] for one in client.told if one["op"] == "status"]
            assert len([one for one in told if "is driven by" in one]) == 1
