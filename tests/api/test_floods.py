"""Strangers, and people with few rights, who send much at once: nobody's stop waits for them."""

from __future__ import annotations

import asyncio
import json
from collections import Counter
from typing import TYPE_CHECKING, Any

import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed
from websockets.frames import Frame, Opcode
from websockets.protocol import State
from websockets.typing import Subprotocol

from rosic.api.connections import FRAGMENTS_AT_MOST, STEP_BYTES, LimitedHttp, LimitedSocket
from rosic.api.rosbridge.endpoint import EACH_AT_MOST, UNKNOWN_AT_MOST
from rosic.api.schemas import StopOut
from rosic.api.settings import ApiSettings, ServingLimits
from rosic.api.stops import EVERY_S, EVERYTHING, CallerStops
from rosic.features.recording.service import AT_ONCE
from tests.api.bridge_client import bridge
from tests.api.served import ANYWHERE, ServedGateway, problem, served
from tests.pace import pace

if TYPE_CHECKING:
    from contextlib import AbstractAsyncContextManager

    from websockets.asyncio.client import ClientConnection

    from rosic.api.callers import ApiCaller

FEW = ApiSettings(listen=ANYWHERE, limits=ServingLimits(connections=20))
SIGN_IN = (
    b"POST /v1/sessions HTTP/1.1\r\nHost: 127.0.0.1\r\n"
    b"Content-Type: application/json\r\nContent-Length: 100\r\n\r\n"
)


def events(place: ServedGateway, key: str) -> AbstractAsyncContextManager[ClientConnection]:
    headers = {"Authorization": f"Bearer {key}"}
    return connect(place.url.replace("http", "ws", 1) + "/v1/events", additional_headers=headers)


def mask(opcode: Opcode, content: bytes = b"", *, fin: bool = True) -> bytes:
    return Frame(opcode, content, fin=fin).serialize(mask=True)


async def test_much_that_comes_at_once_is_looked_at_in_small_steps_and_whole(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sizes: list[int] = []
    for kind in (LimitedHttp, LimitedSocket):
        before = kind.take_in

        def noted(self: Any, data: bytes, take: Any = before) -> None:  # noqa: ANN401 - either
            sizes.append(len(data))
            take(self, data)

        monkeypatch.setattr(kind, "take_in", noted)
    async with served() as place, bridge(place, await place.key("operator")) as client:
        client.socket.transport.write(mask(Opcode.PONG) * 20_000)
        text = json.dumps({"op": "call_service", "service": "/rosapi/get_time", "id": "x" * 200})
        await client.socket.send(text + " " * 200_000)
        assert (await client.op("service_response"))["id"] == "x" * 200
    assert sum(sizes) > 320_000
    assert max(sizes) <= STEP_BYTES


async def test_heads_without_their_bodies_keep_nobody_from_stopping() -> None:
    async with served(FEW) as place:
        hal = await place.program("operator")
        strangers = [
            await asyncio.open_connection("127.0.0.1", place.server.port) for _ in range(30)
        ]
        for _, writer in strangers:
            writer.write(SIGN_IN)
            await writer.drain()
        await place.until(lambda: place.server.connections >= 20)
        answer = await hal.post("/v1/stop", json={})
        assert answer.json()["at_rest"] is True
        for _, writer in strangers:
            writer.close()


async def test_a_body_to_whoever_has_no_key_yet_is_small() -> None:
    async with served() as place:
        much = await place.http.post("/v1/sessions", json={"code": "x" * 20_000})
        assert problem(much)[:2] == (413, "too-large")


async def test_a_flood_of_stops_of_one_caller_is_given_as_few_and_none_is_lost() -> None:
    async with served() as place:
        key = await place.key("viewer")
        before = place.server.context.program.traffic.received
        async with events(place, key) as connection:
            for number in range(500):
                await connection.send(json.dumps({"op": "stop", "id": str(number)}))
            await connection.send('{"op": "ping", "id": "last"}')
            async with asyncio.timeout(60 * pace()):
                told: list[dict[str, Any]] = []
                while not told or told[-1].get("id") != "last":
                    told.append(json.loads(await connection.recv()))
            assert place.gateway.rooms.stops["omni"].latched
        assert 1 <= place.server.context.program.traffic.received - before < 50


async def test_a_stop_that_joins_others_is_given_after_it_came() -> None:
    given: list[tuple[str, frozenset[str]]] = []

    async def give(caller: ApiCaller, robots: frozenset[str]) -> StopOut:
        given.append((caller.name, robots))
        return StopOut(at_rest=True, text=str(len(given)))

    async with served() as place:
        callers = [
            place.server.context.callers.identify(f"Bearer {await place.key('viewer', name=n)}", "")
            for n in ("Hal", "Sal")
        ]
    stops, (hal, sal) = CallerStops(give), callers
    first = stops.give(hal, frozenset({"omni"}))
    assert (await first).text == "1"
    joined = [stops.give(hal, frozenset({name})) for name in ("omni", "kuka1")]
    assert not any(one.done() for one in joined)
    assert (await stops.give(sal, EVERYTHING)).text == "2"  # nobody else waits for it
    assert {(await one).text for one in joined} == {"3"}
    assert given == [
        ("Hal", frozenset({"omni"})),
        ("Sal", EVERYTHING),
        ("Hal", frozenset({"omni", "kuka1"})),
    ]
    everything = [stops.give(hal, frozenset({"omni"})), stops.give(hal, EVERYTHING)]
    assert {(await one).text for one in everything} == {"4"}
    assert given[-1] == ("Hal", EVERYTHING)
    await asyncio.sleep(EVERY_S)
    assert (await stops.give(hal, EVERYTHING)).text == "5"
    await stops.close()


async def test_what_an_onlooker_of_foxglove_says_is_bounded() -> None:
    async with served() as place:
        url = place.url.replace("http", "ws", 1) + "/foxglove"
        headers = {"Authorization": f"Bearer {await place.key('viewer')}"}
        async with connect(
            url, additional_headers=headers, subprotocols=[Subprotocol("foxglove.sdk.v1")]
        ) as connection:
            await connection.send(json.dumps({"op": "x", "a": "a" * 100_000}))
            async with asyncio.timeout(30 * pace()):
                await connection.wait_closed()
            assert connection.close_reason == "You say more than is read here."


async def test_empty_fragments_without_end_are_ended_with_a_reason() -> None:
    async with served() as place, bridge(place, await place.key("operator")) as client:
        client.socket.transport.write(mask(Opcode.TEXT, b"{", fin=False))
        client.socket.transport.write(mask(Opcode.CONT, fin=False) * FRAGMENTS_AT_MOST)
        with pytest.raises(ConnectionClosed) as closed:
            await client.until(lambda _: False)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.reason == "That message has too many fragments."


async def test_whoever_is_not_known_yet_has_few_places_and_few_words() -> None:
    async with served() as place:
        url = place.url.replace("http", "ws", 1) + "/rosbridge"
        strangers = [await connect(url) for _ in range(UNKNOWN_AT_MOST)]
        async with connect(url) as one_more:
            with pytest.raises(ConnectionClosed) as closed:
                await one_more.recv()
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.reason.startswith("Too many connections")
        async with bridge(place, await place.key("operator")) as client:
            await client.say("call_service", service="/rosapi/get_time", id="known")
            assert (await client.op("service_response"))["result"] is True
        key = await place.key("operator", name="Sal")
        await strangers[0].send(json.dumps({"op": "auth", "key": key, "id": "x" * 5_000}))
        assert "no JSON object" in json.loads(await strangers[0].recv())["msg"]
        for stranger in strangers:
            await stranger.close()


async def test_one_caller_has_no_more_places_for_coming_in_as_nobody() -> None:
    async with served() as place:
        key = await place.key("viewer")
        url = place.url.replace("http", "ws", 1) + "/rosbridge"
        headers = {"Authorization": f"Bearer {key}"}
        known = [await connect(url, additional_headers=headers) for _ in range(EACH_AT_MOST)]
        async with connect(url) as one_more:
            await one_more.send(json.dumps({"op": "auth", "key": key}))
            async with asyncio.timeout(30 * pace()):
                await one_more.wait_closed()
            assert one_more.close_code == 1013
            assert known[0].state is State.OPEN
        await asyncio.gather(*(one.close() for one in known))


async def test_so_many_recordings_and_no_more_are_made_at_once() -> None:
    async with served() as place:
        programs = [await place.program("operator", name=f"P{n}") for n in range(AT_ONCE + 4)]
        answers = await asyncio.gather(
            *(each.post("/v1/chat", json={"text": "/record omni 30 s"}) for each in programs)
        )
        states = Counter(answer.json()["state"] for answer in answers)
        assert states == {"final": AT_ONCE, "not-done": 4}


@pytest.mark.parametrize(
    ("head", "status"),
    [
        (b"POST /v1/stop HTTP/1.1\r\nHost: 127.0.0.1\r\nOrigin: http://[\r\n", b"403"),
        (b"GET /v1/me HTTP/1.1\r\nHost: [\r\n", b"421"),
    ],
)
async def test_an_address_that_cannot_be_read_is_refused_like_any_other(
    head: bytes, status: bytes
) -> None:
    async with served() as place:
        reader, writer = await asyncio.open_connection("127.0.0.1", place.server.port)
        writer.write(head + b"Content-Length: 0\r\n\r\n")
        assert (await reader.readline()).split()[1] == status
        writer.close()


async def test_what_is_nested_too_deeply_is_refused_and_no_fault(
    caplog: pytest.LogCaptureFixture,
) -> None:
    async with served() as place:
        deep = b'{"code":' + b"[" * 5_000 + b"]" * 5_000 + b"}"
        answer = await place.http.post(
            "/v1/sessions", content=deep, headers={"Content-Type": "application/json"}
        )
        assert problem(answer)[0] == 400
        url = place.url.replace("http", "ws", 1) + "/rosbridge?" + "a=1&" * 9
        async with connect(url) as connection:
            with pytest.raises(ConnectionClosed) as closed:
                await connection.recv()
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.reason.startswith("That address cannot be read.")
    assert not [record for record in caplog.records if record.exc_info]
