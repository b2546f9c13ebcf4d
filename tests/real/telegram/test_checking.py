"""Whose account it is, asked once and without listening."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING

import pytest

from rosic.contracts.console import AccountProbe
from rosic.errors import ConfigurationError, MessengerFault
from tests.pace import patience
from tests.real.telegram.gateway import Gateway
from tests.real.telegram.test_secrecy import WRONG, everything_about

if TYPE_CHECKING:
    from rosic.testing.telegram import FakeTelegram


async def test_it_names_the_bot_and_receives_nothing(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    server.say(ada, ada, "omni move 1 m")
    assert isinstance(gateway.messenger, AccountProbe)

    said = await gateway.messenger.check()

    [asked] = server.calls
    assert asked["method"] == "getMe"
    assert said == f"@{server.world.state.bot.username} answers"
    assert server.pending() == 1
    assert gateway.messenger._line._bot is None, "a connection was left open"


async def test_a_request_looks_for_no_module(
    gateway: Gateway, monkeypatch: pytest.MonkeyPatch
) -> None:
    await gateway.messenger.check()  # what is imported once is
    looked: list[str] = []

    class Noting:
        @staticmethod
        def find_spec(name: str, *_more: object) -> None:
            looked.append(name)

    monkeypatch.setattr(sys, "meta_path", [Noting, *sys.meta_path])
    await gateway.messenger.check()

    assert looked == []


async def test_a_wrong_token_is_a_sentence_without_it(server: FakeTelegram) -> None:
    gateway = Gateway(server, token=WRONG)

    with pytest.raises(ConfigurationError) as raised:
        await gateway.messenger.check()

    assert str(raised.value).startswith("Telegram does not accept the token of the messenger lab. ")
    assert "api_base leads to another server" in str(raised.value)
    assert WRONG.partition(":")[2] not in everything_about(raised.value)


async def test_telegram_that_is_away_may_come_back(server: FakeTelegram, gateway: Gateway) -> None:
    await server.stop()
    with pytest.raises(MessengerFault, match="cannot be reached"):
        await gateway.messenger.check()

    await server.start()
    assert (await gateway.messenger.check()).endswith(" answers")


async def test_telegram_that_is_silent_is_not_waited_for(
    server: FakeTelegram, gateway: Gateway
) -> None:
    server.fail("hang", "getMe", seconds=30)
    begun_s = time.monotonic()

    with pytest.raises(MessengerFault, match="did not answer"):
        await gateway.messenger.check(within_s=0.3)

    assert time.monotonic() - begun_s < 3 * patience()


async def test_a_proxy_that_cannot_be_used_is_not_taken_for_silence(server: FakeTelegram) -> None:
    gateway = Gateway(server, proxy="socks5://ada:password@127.0.0.1:1")

    with pytest.raises(ConfigurationError, match="proxy cannot be used"):
        await gateway.messenger.check()


async def test_checking_while_it_listens_disturbs_nothing(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    async with gateway.listening():
        await gateway.messenger.check()
        server.say(ada, ada, "status")
        await gateway.hear(1)
    assert gateway.alarms == []
