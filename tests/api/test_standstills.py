"""What comes while the gateway stands still is looked at before anything that is due then."""

from __future__ import annotations

import asyncio
import json
import selectors
import socket
from time import sleep

from rosic.api.settings import ApiSettings, ServingLimits
from tests.api.served import ANYWHERE, served
from tests.pace import pace

IDLE_S = 0.3
SHORT = ApiSettings(listen=ANYWHERE, limits=ServingLimits(idle_s=IDLE_S))
HEAD = "Host: 127.0.0.1\r\nAuthorization: Bearer {}\r\n"


class FreezingSelector(selectors.DefaultSelector):
    """One that, as after a SIGCONT, says once that nothing has come although it has."""

    frozen_s = 0.0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if self.frozen_s:
            sleep(self.frozen_s)
            self.frozen_s = 0.0
            return []
        return super().select(timeout)


async def answered(client: socket.socket) -> tuple[bytes, dict[str, object]]:
    """Return the status line of an answer, and its body."""
    loop, got = asyncio.get_running_loop(), b""
    async with asyncio.timeout(30 * pace()):
        while not got.endswith(b"}"):
            more = await loop.sock_recv(client, 65_536)
            assert more, "the connection was ended"
            got += more
    head, body = got.split(b"\r\n\r\n", 1)
    return head.split(b"\r\n")[0], json.loads(body)


async def stop_in_a_standstill(selector: FreezingSelector) -> None:
    async with served(SHORT) as place:
        head = HEAD.format(await place.key("operator"))
        with socket.create_connection(("127.0.0.1", place.server.port)) as client:
            client.setblocking(False)
            client.sendall(f"GET /v1/me HTTP/1.1\r\n{head}\r\n".encode())
            await answered(client)
            client.sendall(
                f"POST /v1/stop HTTP/1.1\r\n{head}Content-Type: application/json\r\n"
                "Content-Length: 2\r\n\r\n{}".encode()
            )
            selector.frozen_s = 2 * IDLE_S
            status, body = await answered(client)
        assert status == b"HTTP/1.1 200 OK"
        assert body["at_rest"] is True
        assert place.gateway.rooms.stops["omni"].latched


def test_a_stop_that_comes_on_an_idle_connection_in_a_standstill_is_given() -> None:
    selector = FreezingSelector()
    with asyncio.Runner(loop_factory=lambda: asyncio.SelectorEventLoop(selector)) as runner:
        runner.run(stop_in_a_standstill(selector))


async def test_answers_go_at_once_on_a_connection_that_is_kept() -> None:
    """Else the kernel holds each back for 40 ms, until the client has said that it got the last."""
    async with served(ApiSettings(listen=ANYWHERE, rosbridge=ANYWHERE)) as place:
        for port in (place.server.port, place.server.rosbridge_port):
            with socket.create_connection(("127.0.0.1", port)) as client:
                await place.until(lambda: place.server.connections)
                (accepted,) = (
                    connection.transport.get_extra_info("socket")
                    for uvicorn in place.server._uvicorns
                    for connection in uvicorn.server_state.connections
                )
                assert accepted.getpeername() == client.getsockname()
                assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
            await place.until(lambda: not place.server.connections)
