from __future__ import annotations

import copy
import json
import logging
import pickle

import msgspec
import pytest

from rosic.core.secret import Secret

# The token of Telegram's own manual.
TOKEN = "110201543:AAHdqTcvCH1vGWJxfSeofSAs0K5PALDsaw"  # noqa: S105 - nobody's


class Settings(msgspec.Struct):
    token: Secret
    name: str = "bot"


def test_it_is_revealed_only_when_asked() -> None:
    assert Secret(TOKEN).reveal() == TOKEN


@pytest.mark.parametrize(
    "shown",
    [
        repr(Secret(TOKEN)),
        str(Secret(TOKEN)),
        f"{Secret(TOKEN)}",
        f"{Secret(TOKEN):>20}",
        "%s %r" % (Secret(TOKEN), Secret(TOKEN)),  # noqa: UP031 - the old way leaks too, or not
        repr({"token": Secret(TOKEN)}),
        repr(Settings(Secret(TOKEN))),
        str(vars(type(Secret(TOKEN)))),
    ],
)
def test_whatever_shows_it_shows_a_mask(shown: str) -> None:
    assert TOKEN not in shown


def test_a_log_shows_a_mask(caplog: pytest.LogCaptureFixture) -> None:
    logging.getLogger("rosic.test").error("token %s", Secret(TOKEN))
    assert "token ***" in caplog.text
    assert TOKEN not in caplog.text


@pytest.mark.parametrize(
    "leak",
    [json.dumps, msgspec.json.encode, msgspec.msgpack.encode, msgspec.to_builtins, pickle.dumps],
)
def test_what_would_write_it_down_refuses(leak: object) -> None:
    assert callable(leak)
    for value in (Secret(TOKEN), Settings(Secret(TOKEN)), [Secret(TOKEN)]):
        with pytest.raises(TypeError) as refused:
            leak(value)
        assert TOKEN not in str(refused.value)


def test_it_is_no_text() -> None:
    with pytest.raises(TypeError):
        "".join([Secret(TOKEN)])  # type: ignore[list-item]
    with pytest.raises(TypeError):
        "bot" + Secret(TOKEN)  # type: ignore[operator]
    assert not hasattr(Secret(TOKEN), "__dict__")


def test_it_is_compared_by_what_it_holds() -> None:
    assert Secret("a") == Secret("a")
    assert Secret("a") != Secret("b")
    assert Secret("a") != "a"
    assert len({Secret("a"), Secret("a")}) == 1


def test_a_copy_within_the_process_is_the_same() -> None:
    secret = Secret(TOKEN)
    assert copy.copy(secret) is secret
    assert copy.deepcopy({"token": secret})["token"] is secret


def test_an_empty_one_is_refused() -> None:
    with pytest.raises(ValueError, match="never empty"):
        Secret("")
