"""The client against a real gateway: typed, once, by itself again, and honest about silence."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from contextlib import asynccontextmanager, suppress
from typing import TYPE_CHECKING, Self

import pytest
from aiohttp import web

from rosic.api.event_schemas import OrderEvent, RobotEvent
from rosic.api.settings import ApiSettings
from rosic.client import RosicClient
from rosic.client.errors import (
    GatewayUnreachable,
    NotAGateway,
    NotAllowed,
    NotKnown,
    NotNow,
    NotRecognised,
    NotThere,
    NotTrusted,
    WrongRequest,
)
from rosic.client.events import Connected, Disconnected
from rosic.errors import ConfigurationError
from tests.api.served import ANYWHERE, served
from tests.pace import pace, patience

if TYPE_CHECKING:
    import ssl
    from collections.abc import AsyncIterator, Awaitable, Callable
    from pathlib import Path

    from tests.api.served import ServedGateway

KEY = "rosic_k0000000000000000_notakeyofanygatewayanywhere"
MOVE: dict[str, float | str] = {"distance": 0.1, "direction": "left"}


@asynccontextmanager
async def client_of(place: ServedGateway, *roles: str) -> AsyncIterator[RosicClient]:
    async with RosicClient(place.url, await place.key(*roles)) as client:
        yield client


@asynccontextmanager
async def answering(
    handler: Callable[[web.Request], Awaitable[web.StreamResponse]],
    context: ssl.SSLContext | None = None,
) -> AsyncIterator[str]:
    """Yield the address of something that answers like this."""
    app = web.Application()
    app.router.add_route("*", "/{path:.*}", handler)
    runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.1)
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", 0, ssl_context=context)
    await site.start()
    try:
        port = runner.addresses[0][1]
        yield f"http{'s' if context else ''}://127.0.0.1:{port}"
    finally:
        await runner.cleanup()


class Relay:
    """Passes bytes on to a port of this machine, until it cuts all connections."""

    def __init__(self, port: int) -> None:
        self._port, self._open = port, set[asyncio.StreamWriter]()

    async def __aenter__(self) -> Self:
        self._server = await asyncio.start_server(self._serve, "127.0.0.1", 0)
        self.url = f"http://127.0.0.1:{self._server.sockets[0].getsockname()[1]}"
        return self

    async def __aexit__(self, *_: object) -> None:
        self._server.close()
        self.cut()

    def cut(self) -> None:
        for writer in self._open:
            writer.transport.abort()
        self._open.clear()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        back, to = await asyncio.open_connection("127.0.0.1", self._port)
        self._open |= {writer, to}
        await asyncio.gather(_pass(reader, to), _pass(back, writer))


async def _pass(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with suppress(OSError):
        while data := await reader.read(65_536):
            writer.write(data)
            await writer.drain()
    writer.close()


async def collected(client: RosicClient, seen: list[object], *topics: str) -> None:
    async for event in client.events(*topics):
        seen.append(event)  # noqa: PERF401 - looked at meanwhile


# ---- what it does ----


async def test_it_says_who_i_am_and_what_there_is() -> None:
    async with served() as place, client_of(place, "operator") as client:
        me = await client.me()
        assert (me.name, me.kind) == ("Hal", "program")
        robots = {robot.id: robot for robot in await client.robots()}
        assert "move" in robots["omni"].skills
        assert (await client.robot("omni")).id == "omni"
        [move] = [skill for skill in await client.skills("omni") if skill.id == "move"]
        assert move.class_ == "motion"
        checked = await client.check("omni", "move", MOVE)
        assert (checked.allowed, checked.sent) == (True, "move, 0.10 m left")
        assert await client.orders() == []


async def test_an_order_is_followed_until_it_is_done() -> None:
    async with served() as place, client_of(place, "operator") as client:
        order = await client.order("omni", "move", MOVE)
        states = [found.state async for found in client.follow(order)]
        assert states[-1] == "done"
        assert len(set(states)) == len(states) or "running" in states
        assert (await client.wait(order, 5)).state == "done"
        assert [found.id for found in await client.orders("omni")] == [order.id]
        assert (await client.order("omni", "move", MOVE, wait_s=30 * pace())).state == "done"


async def test_the_same_key_gives_an_order_once() -> None:
    async with served() as place, client_of(place, "operator") as client:
        given = [await client.order("omni", "move", MOVE, key="one") for _ in range(3)]
        assert len({order.id for order in given}) == 1
        with pytest.raises(NotNow) as refused:
            await client.order("omni", "move", {"distance": 0.2}, key="one")
        assert refused.value.kind == "repeated"


async def test_what_is_refused_is_an_error_with_code_sentence_and_offers() -> None:
    async with served() as place, client_of(place, "operator") as client:
        with pytest.raises(WrongRequest) as far:
            await client.order("omni", "move", {"distance": 50})
        assert far.value.kind == "out-of-bounds"
        assert str(far.value) == "omni: one move may be at most 5 m. Nothing was done."
        with pytest.raises(NotThere):
            await client.order("nobody", "move", MOVE)
        with pytest.raises(NotThere):
            await client.robot("../me")
        await client.stop("omni")
        with pytest.raises(NotNow) as stopped:
            await client.order("omni", "move", MOVE)
        assert stopped.value.kind == "robot-stopped"
        async with RosicClient(place.url, await place.key("viewer", name="Eve")) as eve:
            with pytest.raises(NotAllowed):
                await eve.order("kuka1", "home")


async def test_a_stop_is_answered_with_measured_rest_and_a_resume_lets_it_go_on() -> None:
    async with served() as place, client_of(place, "operator") as client:
        going = await client.order("omni", "move", {"distance": 5})
        stopped = await client.stop("omni")
        assert stopped.at_rest is True
        assert (await client.wait(going, 10)).state == "cancelled"
        assert (await client.robot("omni")).stopped
        await client.chat("resume omni")
        assert not (await client.robot("omni")).stopped


async def test_what_is_under_way_is_cancelled() -> None:
    async with served() as place, client_of(place, "operator") as client:
        going = await client.order("omni", "move", {"distance": 5})
        await place.until(lambda: place.gateway.rooms.linker.presence("omni").doing)
        await client.cancel(going)
        assert (await client.wait(going, 10)).state == "cancelled"


async def test_events_come_as_they_happen_and_end_with_the_key() -> None:
    async with served() as place, client_of(place, "operator") as client:
        seen: list[object] = []

        listening = asyncio.create_task(collected(client, seen, "robots", "orders"))
        await place.until(lambda: any(isinstance(e, RobotEvent) for e in seen))
        assert isinstance(seen[0], Connected)
        order = await client.order("omni", "move", MOVE)
        await place.until(
            lambda: any(
                isinstance(e, OrderEvent) and e.order.id == order.id and e.order.over for e in seen
            )
        )
        access = place.gateway.access
        for key in access.keys.of(place.principal("Hal")):
            await access.changes.take_away(access.keys.revoke(key.id, "operator").records)
        async with asyncio.timeout(30 * pace()):
            with pytest.raises(NotRecognised):
                await listening


# ---- what does not answer ----


async def test_nobody_there_is_said_so_and_soon() -> None:
    async with RosicClient("http://127.0.0.1:9", KEY) as client:
        with pytest.raises(GatewayUnreachable, match="No gateway can be reached at http://127"):
            async with asyncio.timeout(30 * pace()):
                await client.me()


async def test_a_wrong_key_is_said_so_at_once() -> None:
    async with served() as place, RosicClient(place.url, KEY) as client:
        for asked in (client.me(), client.stop(), client.order("omni", "move", MOVE)):
            with pytest.raises(NotRecognised, match="That is no key of a program here"):
                await asked
        with pytest.raises(NotRecognised):
            async for _ in client.events("orders"):
                pass


@pytest.mark.parametrize(
    ("url", "key", "why"),
    [
        ("robots.example.org", KEY, "is no address of a gateway"),
        ("ftp://robots.example.org", KEY, "is no address of a gateway"),
        ("https://robots.example.org/?a=b", KEY, "is no address of a gateway"),
        ("https://[::1", KEY, "is no address of a gateway"),
        ("https://robots.example.org", "hunter2", "That is no key of a gateway"),
        ("https://robots.example.org", "", "That is no key of a gateway"),
        ("http://robots.example.org", KEY, "is not encrypted, and the key would be read"),
    ],
)
def test_what_cannot_be_an_address_or_a_key_is_said_before_anything_is_sent(
    url: str, key: str, why: str
) -> None:
    with pytest.raises(ConfigurationError, match=why) as wrong:
        RosicClient(url, key)
    assert "hunter2" not in str(wrong.value)


async def test_what_is_no_gateway_is_said_so_and_is_sent_no_order_twice() -> None:
    asked: list[str] = []

    async def site(request: web.Request) -> web.Response:
        asked.append(request.path)
        if request.path == "/v1/robots":
            raise web.HTTPFound("http://127.0.0.1:9/elsewhere")
        return web.Response(text="<html>Welcome</html>", content_type="text/html")

    async with answering(site) as url, RosicClient(url, KEY) as client:
        with pytest.raises(NotAGateway, match="it is no ROSIC gateway"):
            await client.me()
        with pytest.raises(NotAGateway, match="sends on to"):
            await client.robots()
        with pytest.raises(NotAGateway):
            await client.order("omni", "move", MOVE)
        with pytest.raises(NotAGateway):
            await client.stop()
        with pytest.raises(NotAGateway):
            async for _ in client.events("orders"):
                pass
        assert asked.count("/v1/robots/omni/orders") == 1


async def test_an_order_that_is_not_answered_is_given_again_under_the_same_key() -> None:
    keys: list[str] = []

    async def site(request: web.Request) -> web.Response:
        keys.append(request.headers["Idempotency-Key"])
        return web.Response(status=502)

    async with answering(site) as url, RosicClient(url, KEY) as client:
        with pytest.raises(NotKnown):
            await client.order("omni", "move", MOVE)
    assert len(keys) > 1
    assert len(set(keys)) == 1


async def test_what_may_have_been_heard_is_said_once_and_never_again() -> None:
    asked: list[str] = []

    async def site(request: web.Request) -> web.Response:
        asked.append(request.path)
        assert request.transport is not None
        request.transport.abort()
        return web.Response()

    async with answering(site) as url, RosicClient(url, KEY) as client:
        with pytest.raises(NotKnown, match="It may have been done"):
            await client.chat("omni move 1 m left")
    assert asked == ["/v1/chat"]


async def test_a_stop_is_asked_for_until_it_is_answered_and_says_why_not_yet() -> None:
    troubles: list[str] = []
    async with served() as place:
        key, asked = await place.key("operator"), 0

        async def flaky(request: web.Request) -> web.StreamResponse:
            nonlocal asked
            asked += 1
            if asked <= 3:  # as behind a proxy whose gateway is away
                return web.Response(status=502)
            answer = await place.http.post(
                "/v1/stop",
                content=await request.read(),
                headers={"Authorization": request.headers["Authorization"]},
            )
            return web.Response(
                body=answer.content, status=answer.status_code, content_type="application/json"
            )

        async with answering(flaky) as url, RosicClient(url, key) as client:
            stopped = await client.stop("omni", on_trouble=lambda why: troubles.append(str(why)))
        assert stopped.at_rest is True
        assert place.gateway.rooms.stops["omni"].latched
    assert len(troubles) == 3
    assert all("says 502" in why for why in troubles)


async def test_a_stop_for_which_nobody_is_there_goes_on_until_it_is_left_off() -> None:
    troubles: list[Exception] = []
    async with RosicClient("http://127.0.0.1:9", KEY) as client:
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(1.5 * patience()):
                await client.stop(on_trouble=troubles.append)
    assert len(troubles) > 1
    assert all(isinstance(why, GatewayUnreachable) for why in troubles)


async def test_events_come_again_by_themselves_and_say_when_they_did_not() -> None:
    async with served() as place, Relay(place.server.port) as relay:
        client = RosicClient(relay.url, await place.key("operator"))
        seen: list[object] = []

        listening = asyncio.create_task(collected(client, seen, "orders"))
        await place.until(lambda: any(isinstance(e, Connected) for e in seen))
        relay.cut()
        await place.until(lambda: sum(isinstance(e, Connected) for e in seen) == 2)
        assert any(isinstance(e, Disconnected) for e in seen)
        assert (await client.me()).name == "Hal"
        listening.cancel()
        await asyncio.gather(listening, return_exceptions=True)
        await client.close()


# ---- whom it trusts ----


def certificate(folder: Path) -> tuple[Path, Path]:
    """Return a certificate for 127.0.0.1 that signs itself, and its key."""
    crt, key = folder / "ca.pem", folder / "key.pem"
    subprocess.run(  # noqa: S603 - a fixed command
        [
            *("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"),
            *("-nodes", "-days", "2", "-subj", "/CN=gateway", "-keyout", str(key)),
            *("-addext", "subjectAltName=IP:127.0.0.1", "-out", str(crt)),
        ],
        check=True,
        capture_output=True,
    )
    return crt, key


async def test_a_private_authority_is_trusted_where_it_is_named_and_nowhere_else(
    tmp_path: Path,
) -> None:
    crt, key = certificate(tmp_path)
    settings = ApiSettings(listen=ANYWHERE, certificate=str(crt), private_key=str(key))
    async with served(settings) as place:
        url, secret = place.url.replace("http://", "https://"), await place.key("operator")
        async with RosicClient(url, secret, ca=crt) as client:
            order = await client.order("omni", "move", MOVE)
            assert [found.state async for found in client.follow(order)][-1] == "done"
        async with RosicClient(url, secret) as client:
            for asked in (client.me(), client.stop()):
                with pytest.raises(NotTrusted, match=r"The certificate of https://127\S+ is not"):
                    await asked
            with pytest.raises(NotTrusted):
                async for _ in client.events("orders"):
                    pass
        async with RosicClient(place.url, secret) as client:
            with pytest.raises((NotKnown, NotTrusted, NotAGateway)):
                await client.me()
    with pytest.raises(ConfigurationError, match="cannot be used to know the gateway by"):
        RosicClient("https://127.0.0.1:1", KEY, ca=tmp_path / "none.pem")
    with pytest.raises(ConfigurationError, match="cannot be used to know the gateway by"):
        RosicClient("https://127.0.0.1:1", KEY, ca=key)


def test_importing_the_client_imports_nothing_of_a_server() -> None:
    script = (
        "import sys, rosic.client\n"
        "heavy = ('litestar', 'uvicorn', 'sqlalchemy', 'rosic.gateway', 'rosic.authoriser',"
        " 'rosic.messengers', 'rosic.app', 'rosic.stores', 'rosic.config')\n"
        "print([m for m in sys.modules if f'{m}.'.startswith(tuple(h + '.' for h in heavy))])"
    )
    run = subprocess.run(  # noqa: S603 - this interpreter
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert run.stdout.strip() == "[]"


async def test_what_there_is_beside_orders_is_asked_for_by_methods_of_its_own() -> None:
    async with served() as place, client_of(place, "operator") as gateway:
        await gateway.give_task("omni", "move 2 m left")
        [task] = await gateway.tasks()
        await gateway.act_on_task(task.id, "cancel")
        assert (await gateway.missions()).missions == ()
        assert await gateway.queue() == []
        assert await gateway.history(text="nonsense") == []
        async with RosicClient(place.url, await place.key("viewer", name="Eve")) as eve:
            asked = await eve.ask_for("omni", "move", 30)
            assert asked.state == "final"
            [waiting] = await eve.access_requests()
            assert (waiting.own, waiting.kind) == (True, "right")


async def test_files_are_sent_listed_fetched_and_deleted() -> None:
    content = b"one two three\n" * 20_000
    async with served() as place, client_of(place, "operator") as client:
        kept = await client.send_file("notes und mehr.txt", content)
        assert (kept.name, kept.size) == ("notes und mehr.txt", len(content))
        assert await client.files() == [kept]
        assert await client.file_content(kept.id) == content
        await client.delete_file(kept.id)
        assert await client.files() == []
        with pytest.raises(NotThere):
            await client.file_content(kept.id)
        with pytest.raises(WrongRequest):
            await client.send_file("empty.txt", b"")


async def test_pictures_and_the_past_are_asked_for_as_they_are() -> None:
    async with served() as place, client_of(place, "operator") as client:
        shown = await client.picture("omni", "map")
        assert shown.media_type.startswith("image/")
        assert shown.content[:4] in {b"\x89PNG", b"\xff\xd8\xff\xe0"}
        assert shown.taken.endswith("Z")
        with pytest.raises(NotThere, match="map"):
            await client.picture("kuka1", "map")
        await client.order("omni", "move", MOVE, wait_s=30 * pace())
        table = (await client.history_table("omni")).decode().splitlines()
        assert table[0].startswith("at,who,kind,robot,skill,asked")
        assert any("0.10 m left" in line for line in table[1:])
        assert (await client.history_table(text="nonsense")).decode().splitlines() == table[:1]
        assert (await client.telemetry("omni")).robot == "omni"
        assert await client.alerts() == []


async def test_what_is_no_picture_of_a_gateway_is_none() -> None:
    async def site(_: web.Request) -> web.Response:
        return web.Response(text="<html>Welcome</html>", content_type="text/html")

    async with answering(site) as url, RosicClient(url, KEY) as client:
        with pytest.raises(NotAGateway):
            await client.picture("omni")
        with pytest.raises(NotAGateway):
            await client.send_file("notes.txt", b"one two three")
