"""The table of a Matrix account, and the sentence for each thing that is wrong with it."""

from __future__ import annotations

from typing import Any

import pytest

from rosic.contracts.messenger import admins_of
from rosic.core.secret import Secret
from rosic.errors import ConfigurationError
from rosic.messengers.matrix.messenger import matrix_messenger
from rosic.messengers.matrix.settings import read_settings
from rosic.testing.clock import ManualClock

TABLE: dict[str, Any] = {
    "kind": "matrix",
    "name": "lab",
    "homeserver": "https://matrix.example.org/",
    "user": "@robots:example.org",
    "password": Secret("correct horse"),
    "folder": "/var/lib/rosic/matrix",
}


def test_what_is_needed_is_enough() -> None:
    settings = read_settings("lab", TABLE)
    assert settings.homeserver == "https://matrix.example.org"
    assert settings.require_verified
    assert not settings.trust_on_first_use
    assert "correct horse" not in repr(settings)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"homeserver": "http://matrix.example.org"}, "without encryption"),
        ({"homeserver": "https://user:secret@example.org"}, "is not an address"),
        ({"homeserver": "https://example.org/_matrix"}, "is not an address"),
        ({"homeserver": None}, "is not an address"),
        ({"user": "robots"}, "is not an account"),
        ({"user": "@robots"}, "is not an account"),
        ({"password": ""}, "no password and no token"),
        ({"folder": ""}, "has no folder"),
        ({"folder": "matrix"}, "full path"),
        ({"device_name": "two\nlines"}, "a short name"),
        ({"require_verified": "no"}, "must be true or false"),
        ({"trust_on_first_use": 1}, "must be true or false"),
        ({"pasword": "x"}, "does not know the setting pasword"),
    ],
)
def test_what_is_wrong_is_named(change: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigurationError, match=words) as raised:
        read_settings("lab", TABLE | change)
    assert "secret" not in str(raised.value)


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1", "127.8.0.1", "[::1]"])
def test_on_this_computer_nothing_need_be_encrypted(host: str) -> None:
    address = f"http://{host}:8008"
    assert read_settings("lab", TABLE | {"homeserver": address}).homeserver == address


def test_an_assurance_is_claimed_only_where_devices_are_verified() -> None:
    clock = ManualClock()
    assert matrix_messenger("lab", TABLE, clock).assurance == "e2ee-verified"
    for key, value in (("require_verified", False), ("trust_on_first_use", True)):
        made = matrix_messenger("lab", TABLE | {key: value}, clock)
        assert made.assurance == "provider-readable"


@pytest.mark.parametrize("account", ["@ada:example.org", "@ada:example.org:8448"])
def test_an_account_is_an_id(account: str) -> None:
    assert matrix_messenger("lab", TABLE, ManualClock()).is_account(account)


@pytest.mark.parametrize("account", ["ada", "Ada Lovelace", "1001", "@ada", "ada:example.org", ""])
def test_a_name_is_no_account(account: str) -> None:
    assert not matrix_messenger("lab", TABLE, ManualClock()).is_account(account)


def test_power_levels_make_nobody_an_admin() -> None:
    """A homeserver writes them; so nobody is asked for by them whose stop has no name."""
    assert admins_of(matrix_messenger("lab", TABLE, ManualClock())) is None
