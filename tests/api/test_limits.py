"""What clients may take of the gateway: of time, room, connections, reads."""

from __future__ import annotations

import asyncio
import resource
import socket
from contextlib import ExitStack, suppress
from itertools import count
from time import monotonic
from typing import TYPE_CHECKING

import pytest
from websockets.exceptions import ConnectionClosed

from rosic.api.access_checks import BODY_BYTES
from rosic.api.settings import ApiSettings, ServingLimits
from rosic.core.identity import OPERATOR
from rosic.core.rate_limit import RateLimit
from tests.api.served import ANYWHERE, ServedGateway, problem, served
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from websockets.asyncio.client import ClientConnection

SHORT = ApiSettings(
    listen=ANYWHERE,
    limits=ServingLimits(head_s=0.5, body_s=0.5, idle_s=0.5, stalled_s=0.5, head_bytes=8_192),
)
LONG_WAITING = ApiSettings(
    listen=ANYWHERE, limits=ServingLimits(head_s=3_600.0, idle_s=3_600.0, head_bytes=8_192)
)
SOON_S = 20.0


async def ended_after(reader: asyncio.StreamReader) -> bytes:
    """Return what is answered until the other side ends the connection."""
    async with asyncio.timeout(SOON_S * pace()):
        with suppress(ConnectionError):
            return await reader.read()
    return b""


HEAD = b"GET /v1/me HTTP/1.1\r\nHost: 127.0.0.1\r\n"


async def test_a_connection_that_asks_nothing_is_ended() -> None:
    async with served(SHORT) as place:

        async def answer(said: bytes) -> bytes:
            reader, writer = await asyncio.open_connection("127.0.0.1", place.server.port)
            writer.write(said)
            try:
                return await ended_after(reader)
            finally:
                writer.close()

        silent = (b"", HEAD, b"\r\n")
        assert await asyncio.gather(*map(answer, silent)) == [b"", b"", b""]
        asked = (HEAD + b"\r\n", HEAD + b"\r\n\r\n")
        for answered in await asyncio.gather(*map(answer, asked)):
            assert answered.startswith(b"HTTP/1.1 401")


async def test_a_head_that_comes_byte_by_byte_is_ended_and_so_is_one_without_end() -> None:
    async with served(SHORT) as place:
        reader, writer = await asyncio.open_connection("127.0.0.1", place.server.port)
        began = monotonic()
        with suppress(ConnectionError):
            while monotonic() < began + SOON_S * pace():
                writer.write(b"X")
                await writer.drain()
                await asyncio.sleep(0.05)
                if reader.at_eof():
                    break
        assert reader.at_eof() or reader.exception()
        writer.close()
    async with served(LONG_WAITING) as place:
        reader, writer = await asyncio.open_connection("127.0.0.1", place.server.port)
        writer.write(b"GET / HTTP/1.1\r\n" + b"X-Much: of it\r\n" * 2_000)
        assert await ended_after(reader) == b""
        writer.close()


async def test_a_body_that_comes_too_slowly_is_refused() -> None:
    async with served(SHORT) as place:
        key = await place.key("operator")
        reader, writer = await asyncio.open_connection("127.0.0.1", place.server.port)
        head = (
            "POST /v1/robots/omni/orders HTTP/1.1\r\nHost: 127.0.0.1\r\n"
            f"Authorization: Bearer {key}\r\nContent-Type: application/json\r\n"
            "Content-Length: 50\r\n\r\n{"
        )
        writer.write(head.encode())
        answer = await ended_after(reader)
        assert answer.startswith(b"HTTP/1.1 408"), answer
        assert b'"code":"too-slow"' in answer
        writer.close()


async def _much(count: int) -> AsyncIterator[bytes]:
    for _ in range(count):
        yield b" " * 65_536


async def test_a_body_that_is_too_large_is_refused_whether_it_says_so_or_not() -> None:
    async with served() as place:
        hal = await place.program("operator")
        path = "/v1/robots/omni/orders"
        said = await hal.post(path, content=b" " * (BODY_BYTES + 1))
        assert problem(said)[:2] == (413, "too-large")
        unsaid = await hal.post(
            path, content=_much(5), headers={"Content-Type": "application/json"}
        )
        assert problem(unsaid)[:2] == (413, "too-large")
        reader, writer = await asyncio.open_connection("127.0.0.1", place.server.port)
        writer.write(
            b"POST /v1/chat HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 104857600\r\n\r\n"
        )
        answer = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), SOON_S * pace())
        assert answer.startswith(b"HTTP/1.1 413")
        writer.close()
        assert (await hal.get("/v1/me")).status_code == 200


async def test_five_thousand_connections_that_say_nothing_keep_nobody_from_stopping() -> None:
    files, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = min(12_000, most)
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(files, wanted), most))
    many = min(5_000, (max(files, wanted) - 3_000))
    try:
        async with served() as place:
            hal = await place.program("operator")
            with ExitStack() as stack:
                for number in range(many):
                    one = stack.enter_context(socket.socket())
                    one.setblocking(False)
                    with suppress(BlockingIOError):
                        one.connect(("127.0.0.1", place.server.port))
                    if number % 100 == 0:
                        await asyncio.sleep(0)
                await asyncio.sleep(0)
                began = monotonic()
                answer = await hal.post("/v1/stop", json={})
                took_s = monotonic() - began
                assert answer.json()["at_rest"] is True
                assert took_s < 5 * pace()
                assert place.server.connections <= 1_001
        assert many == 5_000, "too few files may be open on this machine for all of it"
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (files, most))


async def test_reads_are_counted_told_and_refused_in_time() -> None:
    limits = ServingLimits(reads=RateLimit(burst=5.0, per_s=0.001))
    async with served(ApiSettings(listen=ANYWHERE, limits=limits)) as place:
        hal, sal = await place.program("operator"), await place.program("viewer", name="Sal")
        first = await hal.get("/v1/me")
        assert first.headers["ratelimit-policy"] == '"reads";q=5;w=5000'
        assert first.headers["ratelimit"] == '"reads";r=4;t=1000'
        answers = [await hal.get("/v1/robots") for _ in range(5)]
        assert [answer.status_code for answer in answers] == [200, 200, 200, 200, 429]
        refused = answers[-1]
        assert problem(refused)[1:] == (
            "too-many-requests",
            "You ask too often. Wait a moment, then ask again. Nothing was done.",
        )
        assert refused.headers["ratelimit"].startswith('"reads";r=0;')
        assert 1 <= int(refused.headers["retry-after"]) <= 1_000
        assert (await sal.get("/v1/me")).status_code == 200
        order = {"skill": "move", "arguments": {"distance": 0.1}}
        check = await hal.post("/v1/robots/omni/orders/check", json=order)
        assert check.status_code == 429
        placed = await hal.post("/v1/robots/omni/orders", json=order)
        assert placed.status_code == 202
        for _ in range(20):
            assert (await hal.post("/v1/stop", json={})).status_code == 200


async def test_whoever_guesses_keys_is_told_to_wait_and_nobody_else_is() -> None:
    limits = ServingLimits(reads=RateLimit(burst=5.0, per_s=0.001))
    async with served(ApiSettings(listen=ANYWHERE, limits=limits)) as place:
        hal = await place.program("operator")
        answers = [await place.http.get("/v1/me") for _ in range(6)]
        assert [answer.status_code for answer in answers] == [401] * 5 + [429]
        assert (await hal.get("/v1/me")).status_code == 200


async def test_a_listener_that_takes_nothing_is_dropped_and_others_hear_everything() -> None:
    async with served(SHORT) as place:
        hal, sal = await place.program("operator"), await place.program("operator", name="Sal")
        stalled = await _stalled(place, hal.headers["authorization"])
        longest_s = 0.0
        async with place.listening(sal) as connection:
            await connection.recv()
            async with asyncio.timeout(60 * pace()):
                for number in count():
                    names = (b"%d " % each + b"x" * 120 for each in range(200))
                    pings = (b'{"op":"ping","id":"%d %s"}' % (number, name) for name in names)
                    stalled.write(b"".join(map(_frame, pings)))
                    began = monotonic()
                    await connection.send('{"op": "ping", "id": "1"}')
                    assert await connection.recv() == '{"event":"pong","id":"1"}'
                    longest_s = max(longest_s, monotonic() - began)
                    if number > 10 and len(place.server.stream.listeners) == 1:
                        break
        assert longest_s < 1.0 * pace()
        stalled.transport.abort()


async def test_a_key_that_ends_ends_what_it_had_opened() -> None:
    async with served() as place:
        secret = await place.key("operator")
        hal = place.client({"Authorization": f"Bearer {secret}"})
        async with place.listening(hal) as connection:
            await connection.recv()
            access = place.gateway.access
            await access.changes.take_away(
                access.keys.revoke(secret.split("_")[1], OPERATOR).records
            )
            with pytest.raises(ConnectionClosed) as closed:
                await _to_its_end(connection)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 4401
        assert problem(await hal.get("/v1/me"))[:2] == (401, "unrecognised")


async def test_a_person_who_is_locked_out_sees_nothing_and_one_who_is_let_go_is_signed_out() -> (
    None
):
    async with served() as place:
        bo = await place.person("Bo")
        assert (await bo.get("/v1/robots")).json()
        async with place.listening(bo) as connection:
            await connection.recv()
            place.chat.say("/lock Bo", account="ada")
            await place.until(lambda: place.chat.told)
            assert (await bo.get("/v1/robots")).json() == []
            assert problem(await bo.get("/v1/robots/omni"))[:2] == (404, "not-found")
            access, directory = place.gateway.access, place.gateway.rooms.authoriser.directory
            who = place.principal("Bo")
            own = [key for key in directory.keys() if key.principal == who]  # noqa: SIM118
            for key in own:
                await access.changes.take_away(access.keys.revoke(key.id, OPERATOR).records)
            with pytest.raises(ConnectionClosed) as closed:
                await _to_its_end(connection)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 4401
        assert (await bo.get("/v1/me")).status_code == 401


async def _to_its_end(connection: ClientConnection) -> None:
    async with asyncio.timeout(SOON_S * pace()):
        while True:
            await connection.recv()


def _frame(text: bytes) -> bytes:
    """Return a text frame as a client sends it; the mask is all zeros."""
    length = len(text)
    size = bytes((0x80 | length,)) if length < 126 else b"\xfe" + length.to_bytes(2, "big")
    return b"\x81" + size + bytes(4) + text


async def _stalled(place: ServedGateway, authorization: str) -> asyncio.StreamWriter:
    """Open a connection to the events whose client reads nothing after the handshake."""
    own = socket.socket()
    own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4_096)
    own.setblocking(False)
    await asyncio.get_running_loop().sock_connect(own, ("127.0.0.1", place.server.port))
    reader, writer = await asyncio.open_connection(sock=own, limit=1_024)
    head = (
        "GET /v1/events HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        f"Sec-WebSocket-Version: 13\r\nAuthorization: {authorization}\r\n\r\n"
    )
    writer.write(head.encode())
    assert (await reader.readuntil(b"\r\n")).startswith(b"HTTP/1.1 101")
    return writer
