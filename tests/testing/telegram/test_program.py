"""The control side over HTTP, and the server as a program of its own."""

from __future__ import annotations

import asyncio
import signal
import sys
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import aiohttp
import pytest

from rosic.testing.telegram import DEFAULT_TOKEN, Control, ControlError, FakeTelegram
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from tests.testing.telegram.asking import Api

KEYBOARD = {"inline_keyboard": [[{"text": "Go", "callback_data": "go"}]]}


@pytest.fixture
async def control(server: FakeTelegram) -> AsyncIterator[Control]:
    async with Control(server.url) as client:
        yield client


async def test_a_conversation_over_http(api: Api, control: Control) -> None:
    ada = await control.create_user("Ada")
    said = await control.say(ada, ada, "hello", age_s=5)
    await control.edit(ada, said, "hello again")
    seen = await control.seq()
    sent = await api.ok("sendMessage", chat_id=ada, text="?", reply_markup=KEYBOARD)
    (change,) = await control.wait(seen, kinds=["sent"])
    assert change["message_id"] == sent["message_id"]
    pressed = await control.tap(ada, ada, sent["message_id"], "Go")
    await api.ok("answerCallbackQuery", callback_query_id=pressed, text="yes")
    assert (await control.call("press", query_id=pressed))["answers"][0]["text"] == "yes"
    assert (await control.message(ada, said))["versions"][0]["text"] == "hello"
    assert [seen["text"] for seen in await control.messages(ada, by_bot=True)] == ["?"]
    assert await control.pending() == 3
    assert [call["method"] for call in await control.calls()] == [
        "sendMessage",
        "answerCallbackQuery",
    ]
    assert await control.violations() == []


async def test_every_verb_is_reached(api: Api, control: Control) -> None:
    ada = await control.create_user("Ada", username="ada")
    lab = await control.create_chat("group", "Lab", members=[ada], bot="administrator")
    numbers = await control.backlog(lab, ada, "line {n}", 3, age_s=60)
    await control.call("react", chat=lab, user=ada, message=numbers[0], emoji=["👍"])
    await control.call("delete", chat=lab, message=numbers[1])
    await control.call("set_latency", seconds=0.001)
    await control.call("set_limits", limits={"chat_per_s": 5.0})
    await control.call("set_limits", limits=None)
    await control.call("advance", seconds=1)
    await control.call("duplicate", new_id=True)
    await control.call("reorder")
    await control.call("calm")
    await control.fail("bad_gateway", "getMe")
    async with api.session.get(api.url("getMe")) as response:
        assert response.status == 502
    new = await control.call("migrate", group=lab)
    assert (await control.messages(new))[0]["extra"] == {"migrate_from_chat_id": lab}
    file = await control.send_file(ada, ada, "map.bin", b"\x00\x01")
    document = (await control.message(ada, file))["document"]
    assert await control.file(document["file_id"]) == b"\x00\x01"
    await control.call("clear_record")
    assert await control.calls() == []


async def test_get_works_for_reading(server: FakeTelegram, api: Api, ada: int) -> None:
    await api.refusal("noSuchMethod")
    async with api.session.get(f"{server.url}/_control/violations") as response:
        assert (await response.json())["result"][0]["method"] == "noSuchMethod"
    async with api.session.get(f"{server.url}/_control/messages?chat={ada}") as response:
        assert (await response.json())["result"] == []


async def test_a_wrong_order_says_why(control: Control, ada: int) -> None:
    with pytest.raises(ControlError, match="no such verb"):
        await control.call("dance")
    with pytest.raises(ControlError, match="no chat 5"):
        await control.say(5, ada, "x")
    with pytest.raises(ControlError, match="unexpected keyword"):
        await control.call("pending", why=1)


async def test_waiting_ends_with_nothing_in_time(control: Control) -> None:
    assert await control.wait(await control.seq(), timeout_s=0.05) == []


# ---- as a program ----


@asynccontextmanager
async def program(*arguments: str) -> AsyncIterator[tuple[asyncio.subprocess.Process, str]]:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rosic.testing.telegram",
        *arguments,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    assert process.stdout is not None
    try:
        line = (await asyncio.wait_for(process.stdout.readline(), 60 * pace())).decode()
        word, _, url = line.strip().partition(" ")
        assert word == "ready"
        yield process, url
    finally:
        if process.returncode is None:
            process.kill()
        await process.communicate()


async def test_it_is_ready_works_and_ends() -> None:
    loop = asyncio.get_running_loop()
    async with program() as (process, url), Control(url) as control:
        ada = await control.create_user("Ada")
        async with aiohttp.ClientSession() as session:
            polling = asyncio.create_task(
                _json(session, f"{control.api_base}{DEFAULT_TOKEN}/getUpdates?timeout=50")
            )
            await control.wait(0, kinds=["call"])
            await control.say(ada, ada, "hello")
            assert (await polling)["result"][0]["message"]["text"] == "hello"
            await _json(session, f"{control.api_base}{DEFAULT_TOKEN}/getMe?colour=red")
            seen = await control.seq()
            # Another poll waits when the end comes.
            polling = asyncio.create_task(
                _json(session, f"{url}/bot{DEFAULT_TOKEN}/getUpdates?offset=100000002&timeout=50")
            )
            await control.wait(seen, kinds=["call"])
            began_s = loop.time()
            process.send_signal(signal.SIGTERM)
            assert await asyncio.wait_for(process.wait(), 60 * pace()) == 0
            assert loop.time() - began_s < 25
            assert await polling == {"ok": True, "result": []}
        assert process.stderr is not None
        said = (await process.stderr.read()).decode()
        assert said == "telegram: violation: getMe: unknown parameter 'colour'\n"


async def _json(session: aiohttp.ClientSession, url: str) -> dict[str, Any]:
    async with session.get(url) as response:
        answer: dict[str, Any] = await response.json()
        return answer


async def test_an_outage_keeps_everything(tmp_path: Path) -> None:
    state = tmp_path / "telegram.json"
    arguments = ("--state", str(state), "--token", "77:of-this-test", "--no-limits")
    async with program(*arguments) as (process, url), Control(url) as control:
        ada = await control.create_user("Ada")
        said = await control.say(ada, ada, "before the outage")
        await control.call("advance", seconds=100)
        process.send_signal(signal.SIGTERM)
        await process.wait()
    assert "of-this-test" not in state.read_text()
    port = url.rpartition(":")[2]
    async with program(*arguments, "--port", port) as (process, again), Control(again) as control:
        assert again == url
        assert (await control.message(ada, said))["text"] == "before the outage"
        assert await control.pending() == 1
        async with aiohttp.ClientSession() as session:
            answer = await _json(session, f"{again}/bot77:of-this-test/getUpdates")
            assert answer["result"][0]["message"]["text"] == "before the outage"


async def test_embedded_state_survives_too(tmp_path: Path) -> None:
    state = tmp_path / "telegram.json"
    async with FakeTelegram(state_file=state) as server:
        ada = server.create_user("Ada")
        number = server.send_file(ada, ada, "log.txt", b"\x00\xff")
        document = server.message(ada, number)["document"]
    async with FakeTelegram(state_file=state) as server:
        assert server.file(document["file_id"]) == b"\x00\xff"
        assert server.pending() == 1
        assert server.say(ada, ada, "on") == number + 1
