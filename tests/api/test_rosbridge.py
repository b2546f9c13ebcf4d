"""rosbridge over simulated robots: who is let in, what is refused, how a robot is driven."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any

import pytest

from rosic.api.rosbridge.connection import TASKS_AT_MOST
from rosic.app.admin.api import AdminVerb
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules, SkillPrecondition
from rosic.stores.memory import MemoryStore
from tests.api.bridge_client import BridgeClient, bridge, closed
from tests.api.served import ServedGateway, served
from tests.gateway.place import ask_as_operator
from tests.pace import pace

if TYPE_CHECKING:
    from rosic.core.records import Record

AHEAD = {"linear": {"x": 0.2, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
REST = {"linear": {"x": 0, "y": 0, "z": 0}, "angular": {"x": 0, "y": 0, "z": 0}}
CMD_VEL = "/omni/cmd_vel"


async def drive(client: BridgeClient, seconds: float, message: dict[str, Any] = AHEAD) -> None:
    """Publish a velocity ten times a second."""
    for _ in range(int(seconds / 0.05)):
        await client.say("publish", topic=CMD_VEL, msg=message)
        await asyncio.sleep(0.05)


def x_m(place: ServedGateway) -> float:
    pose = place.gateway.rooms.linker.presence("omni").pose
    assert pose is not None
    return pose.x_m


# ---- who is let in ----


async def test_a_key_is_shown_in_a_header_by_the_op_auth_or_by_a_ticket_once() -> None:
    async with served() as place:
        hal = await place.program("viewer")
        key = str(hal.headers["authorization"]).removeprefix("Bearer ")
        ask = {"service": "/rosapi/get_time", "id": "t"}
        async with bridge(place, key) as client:
            await client.say("call_service", **ask)
            assert (await client.op("service_response"))["result"] is True
        async with bridge(place) as client:
            await client.say("call_service", **ask)
            assert "Show a key" in await client.status()
            await client.say("auth", mac="rosic_no", client="", dest="", rand="", t=0, level="")
            await client.status()
            await client.say("auth", mac=key, client="", dest="", rand="", t=0, level="")
            await client.say("call_service", **ask)
            assert (await client.op("service_response"))["result"] is True
        ticket = (await hal.post("/v1/tickets")).json()["ticket"]
        path = f"/rosbridge?ticket={ticket}"
        async with bridge(place, path=path) as client:
            await client.say("call_service", **ask)
            assert (await client.op("service_response"))["result"] is True
        async with bridge(place, path=path) as client:
            assert await closed(client) == (
                4401,
                "That ticket is void: each is good once, for a minute.",
            )


async def test_who_shows_three_wrong_keys_or_one_in_a_header_is_told_and_dropped() -> None:
    async with served() as place:
        async with bridge(place, "rosic_no") as client:
            assert (await closed(client))[0] == 4401
        async with bridge(place) as client:
            for _ in range(3):
                await client.say("auth", key="rosic_no")
            assert await closed(client) == (
                4401,
                "Too many keys were shown that are not known here, or not any more.",
            )


async def test_whose_key_is_taken_back_is_dropped_with_a_reason() -> None:
    async with served() as place:
        key = await place.key("viewer")
        async with bridge(place, key) as client:
            await ask_as_operator(place.gateway, AdminVerb.REVOKE, "Hal")
            code, why = await closed(client)
            assert code == 4401
            assert why


async def test_a_page_of_another_site_is_turned_away() -> None:
    async with served() as place:
        key = await place.key("viewer")
        with pytest.raises(Exception, match="403"):
            async with bridge(place, key, Origin="http://elsewhere.example"):
                pass


# ---- what cannot be read, or is not done ----


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{", "That is no JSON object with an op."),
        ("[1]", "That is no JSON object with an op."),
        ('{"op": 7}', "That is no JSON object with an op."),
        ('{"op": "publish"}', "publish: Object missing required field `topic`"),
        ('{"op": "publish", "topic": "/omni/cmd_vel", "msg": {"x": NaN}}', "That is no JSON"),
        ('{"op": "fly", "id": "7"}', "There is no such op here."),
        ("[" * 8_000, "That is no JSON object with an op."),
        ("[" * 8_001, "That has more than 8000 lists, objects and fields."),
        ('"" :' * 8_001, "That has more than 8000 lists, objects and fields."),
        (
            '{"op": "fragment", "id": "1", "data": "{", "num": 0, "total": 2}',
            "Fragments are not put together here. Send each message whole.",
        ),
        (
            '{"op": "advertise_service", "type": "a/B", "service": "/c"}',
            "Nobody offers services or actions from here.",
        ),
        ('{"op": "subscribe", "topic": "/chatter"}', "There is no topic /chatter here"),
        ('{"op": "publish", "topic": "/chatter", "msg": {}}', "There is no topic /chatter here"),
        (
            '{"op": "subscribe", "topic": "/omni/cmd_vel", "compression": "cbor-raw"}',
            "cbor-raw is not sent here. There are: none, png, cbor.",
        ),
        (
            '{"op": "advertise", "topic": "/omni/cmd_vel", "type": "std_msgs/String"}',
            "/omni/cmd_vel is of the type geometry_msgs/msg/Twist.",
        ),
        (
            '{"op": "publish", "topic": "/omni/cmd_vel", "msg": {"linear": {"w": 1}}}',
            "linear.w must be 0: omni is not driven by it here.",
        ),
        ('{"op": "cancel_action_goal", "action": "/omni/move", "id": "9"}', "no such goal"),
    ],
)
async def test_what_is_wrong_is_told_and_the_connection_goes_on(text: str, sentence: str) -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        await client.socket.send(text)
        assert sentence in await client.status()
        await client.socket.send(b"\x00\x01")
        await client.say("call_service", service="/rosapi/topics", id="still there")
        assert (await client.op("service_response"))["id"] == "still there"


async def test_an_id_comes_back_and_levels_are_kept() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        await client.say("publish", topic="/nowhere", msg={}, id="p1")
        assert (await client.op("status"))["id"] == "p1"
        await client.say("set_level", level="none")
        await client.say("publish", topic="/nowhere/else", msg={}, id="p2")
        await client.say("call_service", service="/rosapi/services", id="c")
        assert (await client.until(lambda _: True))["op"] == "service_response"


# ---- driving ----


async def test_publishing_a_velocity_is_a_live_order_of_its_skill() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        await client.say("set_level", level="info")
        await client.say("advertise", topic=CMD_VEL, type="geometry_msgs/Twist")
        driving = asyncio.create_task(drive(client, 60 * pace()))
        await place.until(lambda: x_m(place) > 0.1)
        driving.cancel()
        await client.until(lambda m: m.get("msg") == "omni is driven by /omni/cmd_vel now.")
        await drive(client, 0.1, REST)
        await client.until(lambda m: "driven no further: drove live for" in m.get("msg", ""))
        [order] = place.server.context.feed.newest()
        assert (order.skill, order.ending) == ("drive", "done")
        assert place.gateway.rooms.linker.presence("omni").at_rest


async def test_silence_ends_it_and_only_zeros_let_it_drive_again() -> None:
    async with served() as place:
        key = await place.key("operator")
        async with bridge(place, key) as client:
            await client.say("set_level", level="warning")
            driving = asyncio.create_task(drive(client, 60 * pace()))
            await place.until(lambda: x_m(place) > 0.02)
            driving.cancel()
            ended = await client.until(lambda m: "the controls fell silent" in m.get("msg", ""))
            assert ended["level"] == "error"
            await drive(client, 0.3)
            assert "Publish zeros" in await client.status()
            place.chat.say("stop", account="ada")
            await place.until(lambda: place.gateway.rooms.stops["omni"].latched)
            await drive(client, 0.1)
            await client.until(lambda m: "is stopped. Nothing was sent" in m.get("msg", ""))
            place.chat.say("resume omni", account="ada")
            await place.until(lambda: not place.gateway.rooms.stops["omni"].latched)
        async with bridge(place, key) as client:
            await client.say("set_level", level="info")
            await drive(client, 0.3)
            assert "Publish zeros" in await client.status()
            await drive(client, 0.1, REST)
            await drive(client, 0.3)
            assert "is driven by" in await client.status("info")


async def test_what_is_published_too_fast_is_brought_within_bounds() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        await client.say("set_level", level="warning")

        async def push() -> None:
            while True:  # on a crowded machine the first messages may be too old to be followed
                await drive(client, 0.4, {"linear": {"x": 99.0}})
                await drive(client, 0.4, REST)

        pushing = asyncio.create_task(push())
        try:
            await client.until(lambda m: m.get("msg") == "Brought within what is allowed: linear.")
        finally:
            pushing.cancel()


async def test_after_a_stop_and_a_resume_it_does_not_drive_on_by_itself() -> None:
    async with served() as place:
        hal = await place.program("operator")
        key = str(hal.headers["authorization"]).removeprefix("Bearer ")
        async with bridge(place, key) as client:
            publishing = asyncio.create_task(drive(client, 6.0))
            await place.until(lambda: x_m(place) > 0.02)
            stopped = await hal.post("/v1/stop", json={"robots": ["omni"]})
            assert stopped.json()["at_rest"] is True
            resting_m = x_m(place)
            await hal.post("/v1/chat", json={"text": "resume omni"})
            await place.until(lambda: not place.gateway.rooms.stops["omni"].latched)
            await publishing
            assert x_m(place) == pytest.approx(resting_m, abs=1e-3)
            await client.until(lambda m: "Publish zeros" in m.get("msg", ""))
            assert not any("id" in each for each in client.told)


async def test_whoever_only_looks_drives_nothing_and_is_told_and_it_is_recorded() -> None:
    async with served() as place, bridge(place, await place.key("viewer")) as client:
        await drive(client, 0.3)
        assert "Nothing was done" in await client.status() or client.told
        assert x_m(place) == 0


async def test_whoever_needs_somebody_to_agree_is_told_how_and_nobody_is_asked_in_vain() -> None:
    care = (SkillPrecondition(scopes=("omni:drive",), confirm=True),)
    async with served(rules=RoleRules(roles=DEFAULT_ROLES, care=care)) as place:
        async with bridge(place, await place.key("operator")) as client:
            driving = asyncio.create_task(drive(client, 60.0))  # until the refusal is told
            assert await client.status() == (
                "Somebody has to agree to drive first, so /omni/cmd_vel does not drive omni. Give "
                "it as an order (POST /v1/robots/omni/orders), or in a chat. Nothing was sent."
            )
            driving.cancel()
        assert list(place.server.context.feed.newest()) == []
        assert list(place.chat.told) == []


async def test_a_second_who_drives_is_refused() -> None:
    async with served() as place:
        first, second = await place.key("operator"), await place.key("operator", name="Sal")
        async with bridge(place, first) as one, bridge(place, second) as two:
            driving = asyncio.create_task(drive(one, 2.0))
            await place.until(lambda: x_m(place) > 0.02)
            await drive(two, 0.2)
            assert "Hal" in await two.status()
            await driving


# ---- services and actions ----


async def test_a_goal_is_an_order_with_feedback_and_a_result() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        args = {"direction": "left", "distance_m": 0.2, "speed_m_s": 0.25}
        await client.say(
            "send_action_goal",
            action="/omni/move",
            action_type="rosic_interfaces/action/Move",
            args=args,
            feedback=True,
            id="g1",
        )
        result = await client.op("action_result")
        assert (result["id"], result["status"], result["result"]) == ("g1", 4, True)
        assert result["values"]["success"] is True
        assert any(each["op"] == "action_feedback" for each in client.told)
        [order] = place.server.context.feed.newest()
        assert order.arguments == {"direction": "left", "distance": 0.2, "speed": 0.25}


async def test_an_angle_in_a_goal_is_in_radians_and_in_the_order_likewise() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        args = {"direction": "left", "angle_rad": 0.5}
        await client.say("send_action_goal", action="/omni/turn", args=args, id=1)
        assert (await client.op("action_result"))["status"] == 4
        [order] = place.server.context.feed.newest()
        assert order.arguments["angle"] == pytest.approx(0.5)


async def test_a_goal_is_cancelled() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        args = {"direction": "left", "distance_m": 4.0, "speed_m_s": 0.25}
        await client.say("send_action_goal", action="/omni/move", args=args, id="g")
        await place.until(lambda: place.gateway.rooms.linker.presence("omni").doing)
        await client.say("cancel_action_goal", action="/omni/move", id="g")
        result = await client.op("action_result")
        assert (result["status"], result["values"]["ending"]) == (5, "cancelled")


@pytest.mark.parametrize(
    ("args", "sentence"),
    [
        ({"direction": "left", "distance_m": 99.0}, "at most 5 m"),
        ({"direction": "left"}, "distance has to be said, too."),
        ({"direction": "up", "distance_m": 1.0}, "direction"),
        ({"distance_m": 1.0, "height": 3.0}, "height must be 0 here."),
        ({"distance_m": "far"}, "distance_m is no finite number."),
        ([1, 2], "Give the arguments by the names of their fields."),
    ],
)
async def test_a_goal_that_cannot_be_is_refused_in_a_sentence(args: Any, sentence: str) -> None:  # noqa: ANN401 - JSON
    async with served() as place, bridge(place, await place.key("operator")) as client:
        await client.say("send_action_goal", action="/omni/move", args=args, id="g")
        result = await client.op("action_result")
        assert result["result"] is False
        assert sentence in result["values"]
        assert not list(place.server.context.feed.newest())


async def test_rosapi_tells_only_of_what_one_may_use() -> None:
    roles = DEFAULT_ROLES | {"other": Role(scopes=("kuka1:*",))}
    async with served(rules=RoleRules(roles=roles)) as place:
        async with bridge(place, await place.key("other")) as client:
            await client.say("call_service", service="/rosapi/topics", id=1)
            topics = (await client.op("service_response"))["values"]["topics"]
            assert not any(topic.startswith("/omni") for topic in topics)
            await client.say("call_service", service="/rosapi/action_servers", id=2)
            servers = (await client.op("service_response"))["values"]["action_servers"]
            assert any(each.startswith("/kuka1") for each in servers)
            assert not any(each.startswith("/omni") for each in servers)
        async with bridge(place, await place.key("viewer", name="Vi2")) as client:
            await client.say("call_service", service="/rosapi/topics", id=1)
            values = (await client.op("service_response"))["values"]
            known = dict(zip(values["topics"], values["types"], strict=True))
            assert known[CMD_VEL] == "geometry_msgs/msg/Twist"


async def test_a_flood_keeps_no_stop_waiting() -> None:
    async with served() as place:
        hal = await place.program("operator")
        key = str(hal.headers["authorization"]).removeprefix("Bearer ")
        async with bridge(place, key) as client:
            await client.say("set_level", level="none")
            text = json.dumps({"op": "publish", "topic": CMD_VEL, "msg": AHEAD})

            async def flood() -> None:
                while True:
                    await client.socket.send(text)

            flooding = asyncio.create_task(flood())
            try:
                await place.until(lambda: x_m(place) > 0.02)
                stopped = await hal.post("/v1/stop", json={"robots": ["omni"]})
                assert stopped.json()["at_rest"] is True
            finally:
                flooding.cancel()


async def test_zeros_of_another_connection_let_nobody_drive_on_after_a_stop() -> None:
    async with served() as place:
        hal = await place.program("operator")
        key = str(hal.headers["authorization"]).removeprefix("Bearer ")
        async with bridge(place, key) as controller, bridge(place, key) as stick:
            publishing = asyncio.create_task(drive(controller, 4.0))
            await place.until(lambda: x_m(place) > 0.02)
            await hal.post("/v1/stop", json={"robots": ["omni"]})
            resting_m = x_m(place)
            await hal.post("/v1/chat", json={"text": "resume omni"})
            await drive(stick, 0.5, REST)
            await publishing
            assert x_m(place) == pytest.approx(resting_m, abs=1e-3)
            await controller.until(lambda m: "Publish zeros" in m.get("msg", ""))
            await controller.say("set_level", level="info")
            await drive(controller, 0.1, REST)
            await drive(controller, 0.5)
            assert "is driven by" in await controller.status("info")


async def test_what_is_out_of_a_base_s_plane_is_left_out_told_and_counts_as_no_zeros() -> None:
    up = {"linear": {"x": 0.0, "y": 0.0, "z": 0.5}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
    rising = {"linear": {"x": 0.3, "y": 0.0, "z": 0.5}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
    async with served() as place:
        hal = await place.program("operator")
        key = str(hal.headers["authorization"]).removeprefix("Bearer ")
        async with bridge(place, key) as client:
            await client.say("set_level", level="warning")
            publishing = asyncio.create_task(drive(client, 4.0, rising))
            await place.until(lambda: x_m(place) > 0.02)
            await client.until(lambda m: "so linear.z is not followed" in m.get("msg", ""))
            await hal.post("/v1/stop", json={"robots": ["omni"]})
            await hal.post("/v1/chat", json={"text": "resume omni"})
            resting_m = x_m(place)
            await publishing
            await drive(client, 0.3, up)
            await drive(client, 0.3, rising)
            assert x_m(place) == pytest.approx(resting_m, abs=1e-3)
            await client.until(lambda m: "Publish zeros" in m.get("msg", ""))


async def test_a_connection_is_of_one_key() -> None:
    async with served() as place:
        first, second = await place.key("operator"), await place.key("viewer", name="Sal")
        async with bridge(place, first) as client:
            await client.say("auth", key=second)
            assert "known by another key" in await client.status()
            await client.say("set_level", level="info")
            await client.say("auth", key=first)
            assert await client.status("info") == "You are known by that key now."


class SlowStore(MemoryStore):
    """A store whose disk takes its time, once it is told to."""

    slow_s = 0.0

    async def write(self, *records: Record) -> None:
        await asyncio.sleep(self.slow_s)
        await super().write(*records)


async def test_a_message_that_has_waited_for_a_slow_disk_moves_nothing() -> None:
    store = SlowStore()
    async with served(store=store) as place, bridge(place, await place.key("operator")) as client:
        store.slow_s = 0.6
        await client.say("set_level", level="info")
        await client.say("publish", topic=CMD_VEL, msg=AHEAD)
        assert "is driven by" in await client.status("info")
        store.slow_s = 0.0
        assert "never said anything" in await client.status("error")
        assert x_m(place) == 0


class StoppedGraph:
    """What stands for a graph whose topics are opened for ever, and that has a stop service."""

    stop_service, stop_service_type = "/omni/stop", "std_srvs/srv/SetBool"
    releases_by: dict[str, object] = {}  # noqa: RUF012
    reported = dict.fromkeys((f"/omni/t{n}" for n in range(TASKS_AT_MOST)), "std_msgs/msg/String")

    async def listen(self, *_: object) -> None:
        await asyncio.Event().wait()


async def test_a_stop_service_is_called_however_much_is_under_way(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        linker = place.gateway.rooms.linker
        graph = {"omni": StoppedGraph()}
        monkeypatch.setattr(linker, "graph_topics", graph.get)
        for name in StoppedGraph.reported:
            await client.say("subscribe", topic=name)
        await client.say("call_service", service="/omni/home", id="more")
        assert "Too much of yours is under way. Wait" in await client.status()
        await client.say("call_service", service="/omni/stop", id="stop")
        assert await client.status() == (
            "The stop was given. Too much of yours is under way to answer it."
        )
        await place.until(lambda: place.gateway.rooms.stops["omni"].latched)
