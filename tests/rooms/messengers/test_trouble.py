"""Every exception of python-telegram-bot means something to us, and none comes through."""

from __future__ import annotations

import inspect
import warnings

import pytest
from telegram import error as foreign

from rosic.core.secret import Secret
from rosic.errors import MessengerFault
from rosic.messengers.telegram.scrub import hide
from rosic.messengers.telegram.trouble import Kind, TooFast, Trouble, trouble

TOKEN = "777:another-token-that-opens-nothing"  # noqa: S105
MEANING = {
    foreign.BadRequest: Kind.REFUSED,
    foreign.ChatMigrated: Kind.MOVED,
    foreign.Conflict: Kind.CONFLICT,
    foreign.EndPointNotFound: Kind.UNUSABLE,
    foreign.Forbidden: Kind.GONE,
    foreign.InvalidToken: Kind.UNUSABLE,
    foreign.NetworkError: Kind.LOST,
    foreign.PassportDecryptionError: Kind.REFUSED,
    foreign.RetryAfter: Kind.TOO_FAST,
    foreign.TelegramError: Kind.LOST,
    foreign.TimedOut: Kind.LOST,
}
FOREIGN = [
    kind
    for _, kind in inspect.getmembers(foreign, inspect.isclass)
    if issubclass(kind, Exception) and kind.__module__ == foreign.__name__
]


def made(kind: type[Exception]) -> Exception:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # RetryAfter warns about itself
        return kind(7) if kind in {foreign.ChatMigrated, foreign.RetryAfter} else kind(TOKEN)


def test_every_class_of_the_library_is_known_here() -> None:
    assert set(FOREIGN) == set(MEANING)


@pytest.mark.parametrize("kind", FOREIGN)
def test_each_is_a_messenger_fault_without_secrets(kind: type[Exception]) -> None:
    hide(Secret(TOKEN))
    found = trouble(made(kind))
    assert isinstance(found, MessengerFault)
    assert found.kind is MEANING[kind]
    assert "another-token" not in f"{found} {found.reason} {found!r}"
    assert found.__cause__ is None


def test_what_an_exception_carries_is_kept() -> None:
    assert trouble(made(foreign.ChatMigrated)).new_chat == "7"
    assert trouble(made(foreign.RetryAfter)).wait_s == 7
    assert trouble(TooFast(3.0)).wait_s == 3


@pytest.mark.parametrize("error", [ValueError("x"), TimeoutError(), RuntimeError("closed")])
def test_anything_else_is_trouble_too(error: Exception) -> None:
    assert trouble(error).kind is Kind.LOST


def test_it_never_speaks_of_what_people_need_not_know() -> None:
    for kind in FOREIGN:
        sentence = str(Trouble.__str__(trouble(made(kind))))
        assert "httpx" not in sentence
        assert "!" not in sentence
