"""Every switch that makes a call fail."""

from __future__ import annotations

import asyncio
import json

import aiohttp
import pytest

from rosic.testing.telegram import ControlError, FakeTelegram
from tests.testing.telegram.asking import Api


async def send(api: Api, chat: int) -> int:
    """Send one message; return the status."""
    body = {"chat_id": chat, "text": "x"}
    async with api.session.post(api.url("sendMessage"), json=body) as response:
        await response.read()
        return response.status


async def test_too_many_requests(server: FakeTelegram, api: Api, ada: int) -> None:
    server.fail("too_many_requests", "sendMessage", 2, retry_after_s=3)
    for _ in range(2):
        answer = await api.raw("sendMessage", chat_id=ada, text="x")
        assert answer["parameters"] == {"retry_after": 3}
    server.advance(1)
    assert await send(api, ada) == 200
    assert len(server.messages(ada)) == 1
    assert "2.00 s before retry_after" in server.violations[0]["reason"]


async def test_bad_gateway_is_a_page(server: FakeTelegram, api: Api) -> None:
    server.fail("bad_gateway")
    async with api.session.get(api.url("getMe")) as response:
        assert response.status == 502
        assert response.content_type == "text/html"
        assert b"Bad Gateway" in await response.read()
    assert await api.ok("getMe")
    assert [call.get("fault") for call in server.calls] == ["bad_gateway", None]


async def test_any_error(server: FakeTelegram, api: Api) -> None:
    server.fail("error", "getMe", code=500, description="Internal Server Error: restart")
    assert await api.refusal("getMe") == "500 Internal Server Error: restart"


async def test_a_truncated_answer_after_the_effect(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    server.fail("truncated", "sendMessage")
    body = {"chat_id": ada, "text": "x"}
    async with api.session.post(api.url("sendMessage"), json=body) as response:
        assert response.status == 200
        with pytest.raises(json.JSONDecodeError):
            await response.json()
    assert len(server.messages(ada)) == 1


@pytest.mark.parametrize(
    ("kind", "effects"), [("reset", 0), ("drop_answer", 1), ("hang", 0), ("hang_after", 1)]
)
async def test_a_connection_that_breaks(
    server: FakeTelegram, api: Api, ada: int, kind: str, effects: int
) -> None:
    server.fail(kind, "sendMessage", seconds=0.05)
    with pytest.raises(aiohttp.ClientOSError):  # a reset, not merely an end
        await send(api, ada)
    assert len(server.messages(ada)) == effects
    assert await send(api, ada) == 200


async def test_a_hang_outlasts_the_client_and_not_the_server() -> None:
    loop = asyncio.get_running_loop()
    server = FakeTelegram()
    await server.start()
    async with Api(server) as api:
        server.fail("hang", "getMe", seconds=60)
        hanging = asyncio.create_task(api.ok("getMe"))
        await server.wait(0, kinds=["call"])
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(asyncio.shield(hanging), 0.1)
        began_s = loop.time()
        await server.stop()
        assert loop.time() - began_s < 25
        with pytest.raises(aiohttp.ClientOSError):
            await hanging


async def test_a_fault_for_one_chat_and_one_method(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    bob = server.create_user("Bob")
    server.fail("bad_gateway", "sendMessage", 9, chat_id=bob)
    assert await send(api, ada) == 200
    assert await send(api, bob) == 502
    assert await api.ok("getMe")
    server.calm()
    assert await send(api, bob) == 200


async def test_latency_lies_half_before_and_half_after(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    loop = asyncio.get_running_loop()
    server.set_latency(1.0)
    began_s = loop.time()
    sending = asyncio.create_task(send(api, ada))
    await server.wait(server.seq, kinds=["sent"])
    assert loop.time() - began_s > 0.49
    assert not sending.done()
    await sending
    assert loop.time() - began_s > 0.99


async def test_a_narrow_network_takes_longer_for_longer_messages(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    loop = asyncio.get_running_loop()

    async def took_s(text: str) -> float:
        began_s = loop.time()
        await api.ok("sendMessage", chat_id=ada, text=text)
        return loop.time() - began_s

    server.set_latency(0.0, bits_per_s=80_000)  # 10 kB a second, there and back
    short_s, long_s = await took_s("."), await took_s("." * 4_000)
    assert long_s - short_s > 0.7
    server.calm()
    assert await took_s("." * 4_000) < long_s / 2


async def test_a_fault_that_there_is_not(server: FakeTelegram) -> None:
    with pytest.raises(ControlError):
        server.fail("earthquake")
    with pytest.raises(ControlError):
        server.fail("hang", minutes=3)


async def test_dates_can_be_wrong(server: FakeTelegram, api: Api, ada: int) -> None:
    server.shift_dates(-30)
    server.say(ada, ada, "from a slow clock")
    (update,) = await api.ok("getUpdates")
    assert update["message"]["date"] == int(server.world.clock.now_s()) - 30
