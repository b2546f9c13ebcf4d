"""Clients of rosbridge on a port of their own, and pages elsewhere that the configuration names."""

from __future__ import annotations

from typing import TYPE_CHECKING

import httpx
import pytest
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from rosic.api.settings import ApiSettings, parse_origin
from tests.api.bridge_client import BridgeClient
from tests.api.served import ANYWHERE, ServedGateway, served

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

PANEL = "https://panel.example.org"
SETTINGS = ApiSettings(listen=ANYWHERE, rosbridge=ANYWHERE, origins=(PANEL,))


@pytest.fixture
async def place() -> AsyncIterator[ServedGateway]:
    async with served(SETTINGS) as place:
        yield place


def url(place: ServedGateway, *, alone: bool, path: str = "") -> str:
    port = place.server.rosbridge_port if alone else place.server.port
    return f"ws://127.0.0.1:{port}{path if alone else path or '/rosbridge'}"


@pytest.mark.parametrize("path", ["", "/", "/rosbridge"])
async def test_a_client_that_names_no_path_is_let_in_with_its_key_alone(
    place: ServedGateway, path: str
) -> None:
    assert place.server.rosbridge_port not in {0, place.server.port}
    async with connect(url(place, alone=True, path=path)) as socket:
        client = BridgeClient(socket)
        await client.say("call_service", service="/rosapi/get_time", id="1")
        assert "Show a key" in await client.status()
        await client.say("auth", key=await place.key("viewer"))
        await client.say("call_service", service="/rosapi/get_time", id="2")
        assert (await client.op("service_response"))["result"] is True


async def test_on_that_port_there_is_nothing_else(place: ServedGateway) -> None:
    async with httpx.AsyncClient(
        base_url=f"http://127.0.0.1:{place.server.rosbridge_port}"
    ) as http:
        for path in ("/", "/v1/robots", "/console"):
            found = await http.get(path)
            assert (found.status_code, "WebSocket" in found.text) == (426, True)
        wrong = await http.get("/", headers={"Host": "elsewhere.example"})
        assert wrong.status_code == 421
    with pytest.raises(InvalidStatus):
        await connect(url(place, alone=True, path="/v1/events"))


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize(
    ("origin", "let_in"),
    [(PANEL, True), ("https://other.example.org", False), ("null", False), (PANEL + ":1", False)],
)
async def test_pages_elsewhere_are_let_in_by_name_alone(
    place: ServedGateway, origin: str, *, alone: bool, let_in: bool
) -> None:
    site = {"Sec-Fetch-Site": "cross-site"}
    where = url(place, alone=alone)
    if not let_in:
        with pytest.raises(InvalidStatus):
            await connect(where, origin=origin, additional_headers=site)  # type: ignore[arg-type]
        return
    async with connect(where, origin=origin, additional_headers=site) as socket:  # type: ignore[arg-type]
        client = BridgeClient(socket)
        await client.say("auth", key=await place.key("viewer"))
        await client.say("call_service", service="/rosapi/get_time")
        assert (await client.op("service_response"))["result"] is True


async def test_a_cookie_is_worth_nothing_to_a_page_elsewhere(place: ServedGateway) -> None:
    person = await place.person("Ada")
    cookie = {"Cookie": "; ".join(f"{k}={v}" for k, v in person.cookies.items())}
    for alone in (True, False):
        where = url(place, alone=alone)
        async with connect(where, origin=PANEL, additional_headers=cookie) as socket:  # type: ignore[arg-type]
            client = BridgeClient(socket)
            await client.say("call_service", service="/rosapi/get_time")
            first = await client.until(lambda _: True)
            assert "Show a key" in first.get("msg", "")
    own = place.url  # the same cookie counts on the gateway's own page
    async with connect(url(place, alone=False), origin=own, additional_headers=cookie) as socket:  # type: ignore[arg-type]
        client = BridgeClient(socket)
        await client.say("call_service", service="/rosapi/get_time")
        assert (await client.op("service_response"))["result"] is True


async def test_a_page_elsewhere_comes_nowhere_else(place: ServedGateway) -> None:
    key = await place.key("viewer")
    headers = {"Authorization": f"Bearer {key}", "Origin": PANEL}
    assert (await place.http.post("/v1/stop", headers=headers, json={})).status_code == 403
    with pytest.raises((InvalidStatus, ConnectionClosed)):
        await connect(url(place, alone=False, path="/v1/events"), additional_headers=headers)


@pytest.mark.parametrize("wrong", ["*", "null", "panel.example.org", "https://a.example/x", ""])
def test_what_is_no_origin_is_said(wrong: str) -> None:
    with pytest.raises(ValueError, match="is no origin of a page"):
        parse_origin(wrong)
