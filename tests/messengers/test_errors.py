"""Every exception of python-telegram-bot means something to us, and none comes through."""

from __future__ import annotations

import errno
import inspect
import socket
import warnings
from itertools import pairwise

import httpx
import pytest
from telegram import error as foreign

from rosic.core.secret import Secret
from rosic.errors import MessengerFault
from rosic.messengers.telegram.errors import (
    ErrorKind,
    FloodControl,
    NetworkState,
    TelegramError,
    hide,
    trouble,
)

TOKEN = "777:another-token-that-opens-nothing"  # noqa: S105
MEANING = {
    foreign.BadRequest: ErrorKind.REFUSED,
    foreign.ChatMigrated: ErrorKind.MOVED,
    foreign.Conflict: ErrorKind.CONFLICT,
    foreign.EndPointNotFound: ErrorKind.UNUSABLE,
    foreign.Forbidden: ErrorKind.GONE,
    foreign.InvalidToken: ErrorKind.UNUSABLE,
    foreign.NetworkError: ErrorKind.LOST,
    foreign.PassportDecryptionError: ErrorKind.REFUSED,
    foreign.RetryAfter: ErrorKind.TOO_FAST,
    foreign.TelegramError: ErrorKind.LOST,
    foreign.TimedOut: ErrorKind.LOST,
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
    assert trouble(FloodControl(3.0)).wait_s == 3


@pytest.mark.parametrize("error", [ValueError("x"), TimeoutError(), RuntimeError("closed")])
def test_anything_else_is_trouble_too(error: Exception) -> None:
    assert trouble(error).kind is ErrorKind.LOST


def test_it_never_speaks_of_what_people_need_not_know() -> None:
    for kind in FOREIGN:
        sentence = str(TelegramError.__str__(trouble(made(kind))))
        assert "httpx" not in sentence
        assert "!" not in sentence


def caused(*chain: BaseException) -> BaseException:
    """Return the first of some exceptions, each raised because of the next."""
    for error, cause in pairwise(chain):
        error.__cause__ = cause
    return chain[0]


SEVERAL = ExceptionGroup("all", [OSError(errno.EHOSTUNREACH, "v6"), OSError(errno.ENETUNREACH, "")])


@pytest.mark.parametrize(
    ("chain", "shown"),
    [
        ((httpx.ConnectError("x"), OSError(errno.ENETUNREACH, "no way")), NetworkState.AWAY),
        ((httpx.ConnectError("x"), OSError("all failed"), SEVERAL), NetworkState.AWAY),
        ((httpx.ConnectError("x"), socket.gaierror(socket.EAI_AGAIN, "later")), NetworkState.AWAY),
        ((httpx.ConnectTimeout("x"),), NetworkState.AWAY),
        ((httpx.ConnectError("x"), socket.gaierror(socket.EAI_NONAME, "no")), NetworkState.SILENT),
        ((httpx.ReadError("x"),), NetworkState.SILENT),
        ((httpx.ReadTimeout("x"),), NetworkState.SILENT),
        ((httpx.ConnectError("x"), ConnectionRefusedError()), NetworkState.THERE),
        ((), NetworkState.THERE),  # an answer that was none: 502
    ],
)
def test_it_is_told_what_a_failure_shows_of_the_network(
    chain: tuple[Exception, ...], shown: NetworkState
) -> None:
    assert trouble(caused(foreign.NetworkError("x"), *chain)).network is shown


def test_whoever_answers_is_there() -> None:
    assert trouble(FloodControl(3.0)).network is NetworkState.THERE
    assert trouble(made(foreign.Conflict)).network is NetworkState.THERE
    assert trouble(TimeoutError()).network is NetworkState.SILENT


def test_causes_that_go_round_are_not_followed_for_ever() -> None:
    one, other = foreign.NetworkError("x"), httpx.ReadError("x")
    one.__cause__, other.__cause__ = other, one
    assert trouble(one).network is NetworkState.SILENT
