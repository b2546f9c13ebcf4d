"""Backlog, outages and rivals: when motion is frozen, and when it is not."""

from __future__ import annotations

import asyncio
import errno
from contextlib import contextmanager
from importlib.util import find_spec
from typing import TYPE_CHECKING

import pytest

from rosic.core.message import Button, ChatEventKind
from rosic.errors import ConfigurationError, MessengerFault
from rosic.testing.telegram import FakeTelegram, Settings
from tests.pace import pace
from tests.real.telegram.gateway import Gateway, is_backlog, to

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

MOVE = Button("Move", "omni move 1 m", "n-move")


async def test_what_was_sent_before_the_start_is_backlog_and_the_next_is_not(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async with gateway.listening():
        sent = int(await gateway.messenger.send(to(ada, "omni", buttons=((MOVE,),))))
    server.say(ada, ada, "omni move 1 m")
    server.tap(ada, ada, sent, "Move")
    async with gateway.listening():
        server.say(ada, ada, "omni move 2 m")
        server.tap(ada, ada, sent, "Move")
        heard = await gateway.hear(4)
    assert [is_backlog(inbound) for inbound in heard] == [True, True, False, False]


async def test_after_a_long_pause_what_was_sent_in_it_is_backlog(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async with gateway.listening():
        sent = int(await gateway.messenger.send(to(ada, "omni", buttons=((MOVE,),))))
        server.fail("bad_gateway", "getUpdates", times=1_000)
        await gateway.until(lambda: gateway.calls("getUpdates")[-1]["code"] == 502)
        server.say(ada, ada, "omni move 1 m")
        server.tap(ada, ada, sent, "Move")
        gateway.let_pass(5.1)
        server.calm()
        await gateway.hear(2)
        await gateway.until(lambda: not gateway.frozen)
        server.say(ada, ada, "omni move 2 m")
        server.tap(ada, ada, sent, "Move")
        heard = await gateway.hear(4)
    assert [is_backlog(inbound) for inbound in heard] == [True, True, False, False]


@contextmanager
def no_network(server: FakeTelegram, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Break the connection that is there; no other can be made meanwhile."""

    async def unreachable(*_: object, **__: object) -> None:
        raise OSError(errno.ENETUNREACH, "Network is unreachable")

    with monkeypatch.context() as away:
        away.setattr(asyncio.get_running_loop(), "create_connection", unreachable)
        server.fail("reset", "getUpdates", times=1)
        yield


async def test_that_the_network_was_away_is_known_of_what_was_sent_meanwhile(
    server: FakeTelegram, gateway: Gateway, ada: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    async with gateway.listening():
        with no_network(server, monkeypatch):
            await gateway.until(lambda: gateway.messenger._listener._failures > 2)
            gateway.let_pass(2)
            server.say(ada, ada, "omni move 1 m")
            gateway.let_pass(10)
        await gateway.hear(1)
        await gateway.until(lambda: not gateway.frozen)
        server.say(ada, ada, "omni move 2 m")
        server.fail("bad_gateway", "getUpdates", times=1_000)
        await gateway.until(lambda: gateway.calls("getUpdates")[-1]["code"] == 502)
        gateway.let_pass(2)
        server.say(ada, ada, "omni move 3 m")
        gateway.let_pass(10)
        server.calm()
        await gateway.hear(3)
    assert is_backlog(gateway.heard[0])
    assert is_backlog(await gateway.hears("omni move 3 m"))
    assert [inbound.network_away for inbound in gateway.heard] == [True, False, False]


async def test_before_a_start_it_was_not_the_network(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    server.say(ada, ada, "omni move 1 m")
    gateway.let_pass(100)
    async with gateway.listening():
        [heard] = await gateway.hear(1)
    assert is_backlog(heard)
    assert not heard.network_away


@pytest.mark.parametrize(
    "fault", ["bad_gateway", "truncated", "reset", "drop_answer", "error", "too_many_requests"]
)
async def test_a_short_failure_is_no_gap_and_loses_nothing(
    server: FakeTelegram, gateway: Gateway, ada: int, fault: str
) -> None:
    async with gateway.listening():
        server.fail(fault, "getUpdates", times=2)
        server.say(ada, ada, "omni move 1 m")
        heard = await gateway.hear(1)
        server.say(ada, ada, "omni move 2 m")
        await gateway.hear(2)
        await gateway.until(lambda: server.pending() == 0)
    assert gateway.texts == ["omni move 1 m", "omni move 2 m"]
    assert not any(is_backlog(inbound) for inbound in heard)
    assert gateway.alarms == []


async def test_a_rival_freezes_motion_raises_one_alarm_and_is_outlived(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    rival = Gateway(server)
    async with gateway.listening():
        async with rival.running():
            await gateway.until(lambda: gateway.alarms)
            server.say(ada, ada, "omni move 1 m")
            await gateway.until(lambda: gateway.heard or rival.heard)
            assert gateway.frozen
            await gateway.until(lambda: rival.alarms)
        # What the rival took and did not settle is handed over as well, before or after.
        server.say(ada, ada, "omni move 2 m")
        assert is_backlog(await gateway.hears("omni move 2 m"))  # too soon to be sure
        gateway.let_pass(20)
        await gateway.until(lambda: not gateway.frozen)
        server.say(ada, ada, "omni move 3 m")
        heard = await gateway.hears("omni move 3 m")
    assert not is_backlog(heard)
    begun, over = map(str, gateway.alarms)
    assert begun.startswith("Another program")
    assert "a stop may not arrive" in begun
    assert over.startswith("Nobody else receives the messages of the bot of")
    assert gateway.calls("deleteWebhook") == []


@pytest.mark.parametrize("from_the_start", [True, False])
async def test_a_foreign_webhook_freezes_motion_and_is_left_alone(
    server: FakeTelegram, gateway: Gateway, ada: int, from_the_start: bool
) -> None:
    if from_the_start:
        server.foreign_webhook("https://example.org/thief")
    async with gateway.running():
        if not from_the_start:
            await gateway.until(lambda: not gateway.frozen)
            server.foreign_webhook("https://example.org/thief")
        await gateway.until(lambda: gateway.alarms)
        server.say(ada, ada, "omni move 1 m")
        assert gateway.frozen
        assert gateway.heard == []
        server.foreign_webhook("")
        await gateway.hear(1)
        assert is_backlog(gateway.heard[0])
        gateway.let_pass(20)
        await gateway.until(lambda: not gateway.frozen)
        server.say(ada, ada, "omni move 2 m")
        await gateway.hear(2)
    assert not is_backlog(gateway.heard[1])
    begun, over = map(str, gateway.alarms)
    assert "webhook" in begun
    assert "a stop may not arrive" in begun
    assert over.startswith("Nobody else receives the messages of the bot of")
    assert gateway.calls("deleteWebhook") == []


async def test_telegram_is_away_and_comes_back(tmp_path: Path) -> None:
    state = tmp_path / "state"
    async with FakeTelegram(state_file=state, limits=None) as first:
        ada = first.create_user("Ada")
        gateway = Gateway(first)
        async with gateway.listening():
            first.say(ada, ada, "before")
            await gateway.hear(1)
            await first.stop()
            # Until a poll has failed, one that was under way may yet have been answered.
            await gateway.until(lambda: gateway.messenger._listener._failures)
            gateway.let_pass(10)
            async with FakeTelegram(state_file=state, port=first.port, limits=None) as second:
                second.say(ada, ada, "after")
                heard = await gateway.hear(2)
                await gateway.until(lambda: not gateway.frozen)
                assert second.violations == []
    assert [one.text for one in heard] == ["before", "after"]
    assert is_backlog(heard[1])


async def test_it_starts_without_a_network_and_listens_when_there_is_one() -> None:
    server = FakeTelegram(limits=None)
    await server.start()
    await server.stop()
    gateway = Gateway(server)
    async with gateway.running() as run:
        await asyncio.sleep(0.2)
        assert not run.done()
        async with FakeTelegram(port=server.port, limits=None) as again:
            ada = again.create_user("Ada")
            again.say(ada, ada, "hello")
            await gateway.hear(1)


@pytest.mark.parametrize("token", ["4242424242:a-wrong-token", "1:x"])
async def test_a_wrong_token_ends_it_with_a_sentence(server: FakeTelegram, token: str) -> None:
    gateway = Gateway(server, token=token)
    with pytest.raises(ConfigurationError, match="does not accept the token of the messenger lab"):
        await gateway.messenger.run(gateway.receive)
    with pytest.raises(MessengerFault, match="does not accept the token"):
        await gateway.messenger.send(to(1, "omni: done"))


async def test_a_proxy_that_cannot_be_used_ends_it_with_a_sentence(server: FakeTelegram) -> None:
    gateway = Gateway(server, proxy="socks5://ada:password@127.0.0.1:1")
    if find_spec("socksio") is not None:
        pytest.skip("socks is installed here; the sentence is for where it is not")
    with pytest.raises(ConfigurationError, match="proxy cannot be used") as raised:
        await gateway.messenger.run(gateway.receive)
    assert raised.value.__context__ is None
    with pytest.raises(MessengerFault):
        await gateway.messenger.send(to(1, "omni: done"))


async def test_it_goes_through_a_proxy(server: FakeTelegram, ada: int) -> None:
    asked: list[bytes] = []

    async def relay(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer as a proxy does that lets nobody through."""
        asked.append(await reader.readline())
        writer.write(b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\n\r\n")
        writer.close()

    proxy = await asyncio.start_server(relay, "127.0.0.1", 0)
    async with proxy:
        port = proxy.sockets[0].getsockname()[1]
        gateway = Gateway(server, proxy=f"http://127.0.0.1:{port}")
        with pytest.raises(MessengerFault):
            await gateway.messenger.send(to(ada, "omni: done"))
    assert asked[0].startswith(b"POST http://127.0.0.1:")
    assert gateway.calls("sendMessage") == []


async def test_a_proxy_carries_everything_both_ways(server: FakeTelegram, ada: int) -> None:
    carried: list[bytes] = []

    async def pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while chunk := await reader.read(65_536):
            carried.append(chunk)
            writer.write(chunk)
            await writer.drain()
        writer.close()

    async def relay(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there, here = await asyncio.open_connection(server.host, server.port)
        await asyncio.gather(pass_on(reader, here), pass_on(there, writer), return_exceptions=True)

    proxy = await asyncio.start_server(relay, "127.0.0.1", 0)
    async with proxy:
        port = proxy.sockets[0].getsockname()[1]
        gateway = Gateway(server, proxy=f"http://127.0.0.1:{port}")
        async with gateway.listening():
            server.say(ada, ada, "omni move 1 m")
            [heard] = await gateway.hear(1)
            assert heard.text == "omni move 1 m"
            message = await gateway.messenger.send(to(ada, "omni: running"))
            await gateway.messenger.edit(message, to(ada, "omni: done"))
    assert [one["text"] for one in server.messages(ada, by_bot=True)] == ["omni: done"]
    asked = b"".join(carried)
    for method in (b"getUpdates", b"sendMessage", b"editMessageText"):
        assert method in asked, "nothing goes round it"


async def test_a_token_that_is_revoked_ends_it_too(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async with gateway.listening() as run:
        for method in ("getUpdates", "getMe"):
            server.fail("error", method, times=100, code=401, description="Unauthorized")
        with pytest.raises(MessengerFault, match="no longer accepts the token"):
            await asyncio.wait_for(asyncio.shield(run), 60 * pace())
        server.calm()
    server.say(ada, ada, "hello")
    async with gateway.running():
        await gateway.hear(1)


async def test_it_does_not_run_twice(gateway: Gateway) -> None:
    async with gateway.listening():
        with pytest.raises(MessengerFault, match="listening already"):
            await gateway.messenger.run(gateway.receive)


async def test_a_clock_that_is_behind_is_told(
    server: FakeTelegram, gateway: Gateway, ada: int, caplog: pytest.LogCaptureFixture
) -> None:
    async with gateway.listening():
        server.shift_dates(30)
        server.say(ada, ada, "omni move 1 m")
        heard = await gateway.hear(1)
    assert heard[0].sent_ns == heard[0].received_ns
    assert "clock is at least" in caplog.text


@pytest.mark.parametrize("privacy", [True, False])
async def test_a_bot_that_hears_only_commands_in_groups_says_so(
    privacy: bool, caplog: pytest.LogCaptureFixture
) -> None:
    async with FakeTelegram(limits=None, settings=Settings(privacy=privacy)) as server:
        gateway = Gateway(server)
        async with gateway.listening():
            assert gateway.passings[0].what is (
                ChatEventKind.DEAF if privacy else ChatEventKind.HEARING
            )
    assert ("a plain stop does not arrive" in caplog.text) is privacy
