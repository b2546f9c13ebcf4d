from __future__ import annotations

import pytest

from rosic.core.secret import Secret
from rosic.errors import ConfigurationError
from rosic.messengers.memory import memory_messenger
from rosic.messengers.telegram.messenger import telegram_messenger
from rosic.messengers.telegram.settings import API_BASE, read_settings
from rosic.testing.clock import ManualClock

TOKEN = "123456:a-token-that-opens-nothing"  # noqa: S105


def test_a_token_is_all_it_needs() -> None:
    settings = read_settings("lab", {"kind": "telegram", "name": "lab", "token": TOKEN})
    assert settings.token == Secret(TOKEN)
    assert (settings.api_base, settings.proxy, settings.poll_timeout_s) == (API_BASE, None, 3)


def test_a_secret_may_come_as_a_secret() -> None:
    assert read_settings("lab", {"token": Secret(TOKEN + "\n")}).token == Secret(TOKEN)


@pytest.mark.parametrize("given", ["http://127.0.0.1:8081", "http://127.0.0.1:8081/bot/"])
def test_the_address_of_the_api_is_understood_with_and_without_its_end(given: str) -> None:
    assert read_settings("lab", {"token": TOKEN, "api_base": given}).api_base == (
        "http://127.0.0.1:8081/bot"
    )


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({}, "has no token"),
        ({"token": ""}, "has no token"),
        ({"token": 5}, "has no token"),
        ({"token": "my token"}, "does not look like a Telegram token"),
        ({"token": f"{TOKEN}/../x"}, "does not look like a Telegram token"),
        ({"token": TOKEN, "tokn": "x"}, "does not know the setting tokn"),
        ({"token": TOKEN, "api_base": "127.0.0.1"}, "api_base .* is not an address"),
        ({"token": TOKEN, "api_base": "http://x/?a"}, "api_base .* is not an address"),
        ({"token": TOKEN, "proxy": "proxy:3128"}, "proxy .* is not an address"),
        ({"token": TOKEN, "poll_timeout_s": 30}, "poll_timeout_s .* from 1 to 4"),
        ({"token": TOKEN, "poll_timeout_s": True}, "poll_timeout_s .* from 1 to 4"),
        ({"token": TOKEN, "poll_timeout_s": 0}, "poll_timeout_s .* from 1 to 4"),
    ],
)
def test_what_is_wrong_is_named(settings: dict[str, object], sentence: str) -> None:
    with pytest.raises(ConfigurationError, match=sentence) as raised:
        telegram_messenger("lab", settings, ManualClock())
    assert "lab" in str(raised.value)
    assert TOKEN not in str(raised.value)


def test_nothing_shows_the_token() -> None:
    settings = read_settings("lab", {"token": TOKEN, "proxy": "http://ada:secret@127.0.0.1:3128"})
    messenger = telegram_messenger("lab", {"token": TOKEN}, ManualClock())
    for shown in (repr(settings), repr(messenger), f"{messenger}", repr(vars(messenger))):
        assert TOKEN.partition(":")[2] not in shown
        assert "ada:secret" not in shown


def test_the_memory_messenger_knows_one_setting() -> None:
    assert memory_messenger("m", {"kind": "memory", "edits": False}, ManualClock()).edits is False
    with pytest.raises(ConfigurationError, match="does not know the setting token"):
        memory_messenger("m", {"token": TOKEN}, ManualClock())
