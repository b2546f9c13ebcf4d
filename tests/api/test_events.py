"""What happens, over a WebSocket: robots, orders, one's own conversation, and stops."""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any, cast

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from rosic.api.event_schemas import Pong
from rosic.core.i18n import titled
from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.stores.memory import MemoryStore
from rosic.testing.factories import a_claim
from tests.api.served import served
from tests.gateway.test_rights import rules
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable

    from websockets.asyncio.client import ClientConnection


async def told(
    connection: ClientConnection, event: str, holds: Callable[[dict[str, Any]], object] = bool
) -> dict[str, Any]:
    """Return the next event of a kind that is as wanted, whatever else is told before."""
    async with asyncio.timeout(60 * pace()):
        while True:
            found: dict[str, Any] = json.loads(await connection.recv())
            if found["event"] == event and holds(found):
                return found


async def everything(connection: ClientConnection) -> None:
    """Take whatever comes until the connection ends."""
    async with asyncio.timeout(60 * pace()):
        while True:
            await connection.recv()


async def says(connection: ClientConnection, **message: Any) -> None:  # noqa: ANN401 - JSON
    await connection.send(json.dumps(message))


async def test_whoever_listens_sees_the_robots_and_an_order_come_and_end() -> None:
    async with served() as place:
        eve, hal = await place.program("viewer", name="Eve"), await place.program("operator")
        async with place.listening(eve) as connection:
            hello = json.loads(await connection.recv())
            assert (hello["event"], hello["me"]["name"]) == ("hello", "Eve")
            await says(connection, op="subscribe", topics=["robots", "orders"])
            seen = {
                (await told(connection, "robot"))["robot"]["id"]
                for _ in place.gateway.rooms.profiles
            }
            assert seen == set(place.gateway.rooms.profiles)
            body = {"skill": "move", "arguments": {"distance": 0.3}}
            placed = (await hal.post("/v1/robots/omni/orders", json=body)).json()
            moves = await told(connection, "robot", lambda e: e["robot"]["presence"]["doing"])
            assert (moves["robot"]["id"], moves["robot"]["holder"]) == ("omni", "Hal")
            ended = await told(connection, "order", lambda e: e["order"]["over"])
            assert (ended["order"]["id"], ended["order"]["state"]) == (placed["id"], "done")


async def test_whoever_listens_is_told_once_how_an_order_of_a_killed_run_ended() -> None:
    store = MemoryStore()
    await store.open()
    left = a_claim("an order of a run that died")
    await store.write(left)
    async with served(store=store) as place:
        eve = await place.program("viewer", name="Eve")
        async with place.listening(eve) as connection:
            await says(connection, op="subscribe", topics=["orders"])
            ended = (await told(connection, "order"))["order"]
            assert (ended["id"], ended["robot"]) == (left.cid.hex(), "omni")
            assert (ended["state"], ended["over"], ended["n"]) == ("unknown", True, 1)
            await says(connection, op="subscribe", topics=["orders"])
            await says(connection, op="ping", id="1")
            assert json.loads(await connection.recv())["event"] == "pong"


async def test_what_does_not_change_is_not_told_again() -> None:
    async with served() as place:
        eve = await place.program("viewer")
        async with place.listening(eve) as connection:
            await says(connection, op="subscribe", topics=["robots"])
            for _ in place.gateway.rooms.profiles:
                await told(connection, "robot")
            await says(connection, op="ping", id="1")
            assert (await told(connection, "pong"))["id"] == "1"
            await asyncio.sleep(1.0)
            await says(connection, op="ping", id="2")
            news = []
            while (event := json.loads(await connection.recv()))["event"] != "pong":
                news.append(event)
            reporting = {r for r, p in place.gateway.rooms.profiles.items() if p.telemetry}
            assert {event["robot"]["id"] for event in news} <= reporting
            assert reporting < set(place.gateway.rooms.profiles)


async def test_a_person_reads_their_conversation_and_nobody_elses() -> None:
    async with served() as place:
        ada, bo = await place.person("Ada"), await place.person("Bo")
        async with place.listening(ada) as hers, place.listening(bo) as his:
            for connection in (hers, his):
                await says(connection, op="subscribe", topics=["chat"])
            await ada.post("/v1/chat", json={"text": "status omni"})
            own = await told(hers, "message", lambda e: e["message"]["own"])
            answer = await told(hers, "message", lambda e: not e["message"]["own"])
            assert own["message"]["text"] == "status omni"
            assert answer["message"]["text"].startswith("omni:")
            await bo.post("/v1/chat", json={"text": "hello"})
            assert (await told(his, "message"))["message"]["text"] == "hello"


@pytest.mark.parametrize(
    "message", ["", "{}", "[]", b"\xff", '{"op": "dance"}', '{"op": "subscribe"}', "x" * 70_000]
)
async def test_what_cannot_be_read_is_answered_and_the_connection_stays(
    message: str | bytes,
) -> None:
    async with served() as place:
        hal = await place.program("operator")
        async with place.listening(hal) as connection:
            await connection.send(message)
            problem = (await told(connection, "problem"))["problem"]
            assert problem["detail"] == "That is no message of this protocol."
            await says(connection, op="ping")
            await told(connection, "pong")
            assert not any(stop.latched for stop in place.gateway.rooms.stops.values())


async def test_a_topic_that_there_is_not_is_named_with_those_that_there_are() -> None:
    async with served() as place:
        hal, bo = await place.program("operator"), await place.person("Bo")
        async with place.listening(hal) as connection:
            await says(connection, op="subscribe", topics=["orders"])
            await says(connection, op="subscribe", topics=["robots", "stops"])
            problem = (await told(connection, "problem"))["problem"]
            assert (problem["code"], problem["status"]) == ("not-found", 404)
            assert problem["detail"] == (
                "There is no topic 'stops'. There are robots, orders, chat, rates. "
                "You are told what you were told before."
            )
            assert not any(stop.latched for stop in place.gateway.rooms.stops.values())
            body = {"skill": "move", "arguments": {"distance": 0.1}}
            await bo.post("/v1/robots/omni/orders", json=body)
            await told(connection, "order")  # the first subscription counts still
            (listener,) = place.server.stream.listeners
            assert listener.topics == {"orders"}


async def test_nobody_listens_without_a_key() -> None:
    async with served() as place:
        with pytest.raises(InvalidStatus) as refused:
            async with place.listening(place.http):
                pass
        assert refused.value.response.status_code == 403


async def test_a_session_that_ends_ends_its_connection() -> None:
    async with served() as place:
        ada = await place.person("Ada")
        async with place.listening(ada) as connection:
            await told(connection, "hello")
            await ada.delete("/v1/sessions/current")
            with pytest.raises(ConnectionClosed) as closed:
                await everything(connection)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 4401
            assert closed.value.rcvd.reason == "Sign in first: write /signin in your own chat."


async def test_whoever_takes_nothing_is_dropped_and_nobody_waits_for_them() -> None:
    async with served() as place:
        ada, bo = await place.person("Ada"), await place.person("Bo")
        async with place.listening(ada) as connection:
            await told(connection, "hello")
            [listener] = place.server.stream.listeners
            for number in range(5_000):  # more than is kept, and nothing of it is taken meanwhile
                listener.put(f"pong {number}", Pong(str(number)))
            with pytest.raises(ConnectionClosed) as closed:
                await everything(connection)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 1013
        assert (await bo.get("/v1/robots")).status_code == 200


async def test_what_passes_is_told_once_a_second_of_robots_that_one_sees() -> None:
    rules = RoleRules(roles={**DEFAULT_ROLES, "lookout": Role(scopes=("omni:read",))})
    async with served(rules=rules) as place:
        ole = await place.program("lookout", name="Ole")
        hal = await place.program("operator")
        async with place.listening(ole) as connection:
            await says(connection, op="subscribe", topics=["rates"])
            await told(connection, "rates")
            body = {"skill": "move", "arguments": {"distance": 0.3}}
            assert (await hal.post("/v1/robots/omni/orders", json=body)).status_code == 202
            heard = sent = 0.0
            while not (heard and sent):  # they may fall into different seconds
                found = await told(connection, "rates")
                [omni] = found["robots"]
                [api] = [each for each in found["messengers"] if each["name"] == "api"]
                assert omni["robot"] == "omni"
                assert api["in_bytes_s"] >= api["in_per_s"] * len("omni move")
                heard, sent = heard + api["in_per_s"], sent + omni["sent_per_s"]


async def test_a_name_in_several_languages_is_told_and_what_cannot_be_written_ends_nothing(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with served() as place, place.listening(await place.program("viewer")) as connection:
        await told(connection, "hello")
        (listener,) = place.server.stream.listeners
        listener.put("odd", Pong(cast("str", object())))
        listener.put("named", Pong(titled("you", {"de": "Gast"})))
        assert (await told(connection, "pong"))["id"] == "you"
    assert "an event of Pong cannot be written" in caplog.text


async def test_of_many_stops_at_once_each_is_given_and_has_an_answer_of_its_own_id() -> None:
    async with served() as place:
        hal = await place.program("operator")
        async with place.listening(hal) as connection:
            for number in range(60):
                await connection.send(json.dumps({"op": "stop", "id": f"s{number}"}))
            answered = set[str]()
            async with asyncio.timeout(60 * pace()):
                while len(answered) < 60:
                    told = json.loads(await connection.recv())
                    if told["event"] in {"stop", "problem"}:
                        answered.add(told["id"])
            assert answered == {f"s{number}" for number in range(60)}


async def test_what_comes_back_as_an_id_is_no_longer_than_an_id() -> None:
    async with served() as place:
        hal = await place.program("operator")
        async with place.listening(hal) as connection:
            await connection.recv()
            for op, event in (("ping", "pong"), ("stop", "stop")):
                await connection.send(json.dumps({"op": op, "id": op + "x" * 60_000}))
                answer = await told(connection, event)
                assert answer["id"] == (op + "x" * 60_000)[:128]


async def test_nobody_hears_of_orders_of_a_robot_that_they_may_not_see() -> None:
    book = rules(elsewhere=Role(scopes=("kuka1:read",)))
    async with served(rules=book) as place:
        hal, eve = await place.program("operator"), await place.program("elsewhere", name="Eve")
        async with place.listening(eve) as connection:
            await connection.send('{"op":"subscribe","topics":["orders"]}')
            for robot, skill, arguments in (
                ("omni", "move", {"distance": 0.1}),
                ("kuka1", "home", {}),
            ):
                order = {"skill": skill, "arguments": arguments, "wait_s": 30}
                await hal.post(f"/v1/robots/{robot}/orders", json=order)
            first = await told(connection, "order")
            assert first["order"]["robot"] == "kuka1"
