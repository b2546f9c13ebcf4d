"""What can go wrong with a call to Telegram, as one type of ours that holds nothing of theirs.

No foreign exception is chained: python-telegram-bot and httpx put the token into messages and
requests, and a trace is read by more people than the token is meant for.
"""

from __future__ import annotations

import enum
import errno
import logging
import socket
import traceback
from typing import TYPE_CHECKING, Any, Final

from telegram import error as foreign

from rosic.core.secret import MASK
from rosic.errors import MessengerFault
from rosic.messengers.telegram.upload_stream import ChangedUpload

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from rosic.core.secret import Secret


# ---- log redaction ----

# Keeps tokens out of every log line and every trace that is logged.

SHORTEST = 8
"""What is shorter is no secret of anybody's, and hiding it would make every log unreadable."""

_hidden: set[str] = set()


class _Scrubbing:
    """A factory of log records that hides what must not be read.

    Filters of a logger do not see what its children log, and filters of a handler must be added
    to each one that ever comes. Every record of every library is made by the factory.
    """

    def __init__(self, make: Callable[..., logging.LogRecord]) -> None:
        self._make = make

    def __call__(self, *args: Any, **kwargs: Any) -> logging.LogRecord:  # noqa: ANN401
        record = self._make(*args, **kwargs)
        try:
            message = record.getMessage()
        except Exception:  # noqa: BLE001  (logging itself reports a broken format, as always)
            return record
        if _holds(message):
            record.msg, record.args = scrub(message), ()
        if record.exc_info and record.exc_info[0] is not None:
            trace = "".join(traceback.format_exception(*record.exc_info)).rstrip("\n")
            if _holds(trace):
                record.exc_info, record.exc_text = None, scrub(trace)
        return record


def hide(secret: Secret) -> None:
    """From now on, no log record of this process shows this secret.

    Of a bot token only the part after the colon is secret; the number before it is public, and
    an operator with several bots needs it to tell them apart.
    """
    text = secret.reveal()
    half = text.partition(":")[2] or text
    if len(half) >= SHORTEST:
        _hidden.add(half)
    make = logging.getLogRecordFactory()
    if not isinstance(make, _Scrubbing):
        logging.setLogRecordFactory(_Scrubbing(make))


def scrub(text: str) -> str:
    """Return the text without the secrets that are to be hidden."""
    for secret in _hidden:
        text = text.replace(secret, MASK)
    return text


def _holds(text: str) -> bool:
    return any(secret in text for secret in _hidden)


# ---- errors ----

TOO_FAST = 429
DEFAULT_WAIT_S = 1.0
_NO_CHAT = (
    "chat not found",
    "chat_write_forbidden",
    "not enough rights to send",
    "no rights to send",
    "need administrator rights in the channel",
    "chat was deactivated",
    "user is deactivated",
)
"""Telegram's words, besides 403, for a chat in which nothing more can be said."""
_NOT_SENT = frozenset({"ConnectError", "ConnectTimeout", "PoolTimeout", "ProxyError"})


class ErrorKind(enum.Enum):
    """What a caller can do about it."""

    UNUSABLE = "the account cannot be used"
    CONFLICT = "somebody else receives for this bot"
    TOO_FAST = "wait, then try again"
    MOVED = "the group has a new id"
    REFUSED = "this call will never succeed"
    GONE = "nobody can be spoken to in this chat any more"
    NOT_SENT = "it certainly did not arrive"
    LOST = "it may or may not have arrived"


class NetworkState(enum.Enum):
    """What a call that did not succeed shows of the network between Telegram and us."""

    AWAY = "there was no way to anybody"
    SILENT = "nobody answered"
    THERE = "somebody answered"


_NO_WAY: Final = frozenset(
    {
        errno.ENETDOWN,
        errno.ENETUNREACH,
        errno.EHOSTDOWN,
        errno.EHOSTUNREACH,
        errno.ETIMEDOUT,
    }
)
_SILENT: Final = frozenset({"TimedOut", "TimeoutError", "CancelledError"})
_BROKEN: Final = frozenset(
    {
        "ConnectError",
        "ReadError",
        "ReadTimeout",
        "RemoteProtocolError",
        "WriteError",
        "WriteTimeout",
    }
)
CAUSES_AT_MOST: Final = 20


class TelegramError(MessengerFault):
    """A call to Telegram did not succeed.

    Attributes:
        kind: What a caller can do.
        reason: What Telegram or the network said, without secrets; for the log.
        wait_s: How long Telegram asks to wait.
        new_chat: The group's new id.
        network: What it shows of the network.
    """

    network = NetworkState.THERE

    def __init__(
        self,
        sentence: str,
        kind: ErrorKind,
        reason: str,
        *,
        wait_s: float = 0.0,
        new_chat: str = "",
    ) -> None:
        super().__init__(sentence)
        self.kind = kind
        self.reason = reason
        self.wait_s = wait_s
        self.new_chat = new_chat
        self.perhaps_sent = kind is ErrorKind.LOST


class FloodControl(foreign.TelegramError):
    """429, raised by our own request class.

    python-telegram-bot's ``RetryAfter`` warns about its own attribute whenever it is made, and is
    not made at all when a proxy answers 429 without JSON.
    """

    def __init__(self, wait_s: float) -> None:
        super().__init__(f"Too many requests: wait {wait_s:g} s")
        self.wait_s = wait_s


def trouble(error: BaseException) -> TelegramError:
    """Return what a foreign exception means. Total: every exception means something."""
    found = _trouble(error)
    found.network = _network(error)
    return found


def _trouble(error: BaseException) -> TelegramError:
    reason = scrub(f"{type(error).__name__}: {error}")
    if isinstance(error, ChangedUpload):
        return TelegramError(error.sentence, ErrorKind.REFUSED, reason)
    if (wait_s := _wait_s(error)) is not None:
        return _too_fast(wait_s, reason)
    if isinstance(error, foreign.ChatMigrated):
        new_chat = str(error.new_chat_id)
        return TelegramError("The group has moved.", ErrorKind.MOVED, reason, new_chat=new_chat)
    for kinds, kind, sentence in _MEANINGS:
        if isinstance(error, kinds) and (kind is not ErrorKind.GONE or _is_gone(error, reason)):
            return TelegramError(sentence.format(reason=scrub(str(error))), kind, reason)
    if type(error.__cause__).__name__ in _NOT_SENT:
        return TelegramError(
            "Telegram cannot be reached. Nothing was sent.", ErrorKind.NOT_SENT, reason
        )
    return TelegramError(
        "Telegram did not answer. It may or may not have arrived.", ErrorKind.LOST, reason
    )


_MEANINGS: tuple[tuple[tuple[type[Exception], ...], ErrorKind, str], ...] = (
    (
        (foreign.InvalidToken, foreign.EndPointNotFound),
        ErrorKind.UNUSABLE,
        "Telegram does not accept the token of this bot.",
    ),
    (
        (foreign.Conflict,),
        ErrorKind.CONFLICT,
        "Another program receives the messages of this bot.",
    ),
    (
        (foreign.Forbidden, foreign.BadRequest),
        ErrorKind.GONE,
        "Nobody can be spoken to in that chat any more.",
    ),
    (
        (foreign.BadRequest, foreign.PassportDecryptionError),
        ErrorKind.REFUSED,
        "Telegram did not take the message ({reason}).",
    ),
)


def _network(error: BaseException) -> NetworkState:
    """Return what an exception shows of the network; in doubt, that it was there.

    A connection that is refused was refused by somebody. One that breaks, or an answer that does
    not come, shows nothing by itself.
    """
    causes = list(_causes(error))
    if any(isinstance(one, ConnectionRefusedError) for one in causes):
        return NetworkState.THERE
    if any(map(_is_no_way, causes)):
        return NetworkState.AWAY
    names = {type(one).__name__ for one in causes}
    return NetworkState.THERE if names.isdisjoint(_SILENT | _BROKEN) else NetworkState.SILENT


def _is_no_way(error: BaseException) -> bool:
    if isinstance(error, socket.gaierror):
        return error.errno == socket.EAI_AGAIN
    in_vain = isinstance(error, OSError) and error.errno in _NO_WAY
    return in_vain or type(error).__name__ == "ConnectTimeout"


def _causes(error: BaseException) -> Iterator[BaseException]:
    """Yield an exception and what led to it, as far as anybody looks."""
    waiting = [error]
    for _ in range(CAUSES_AT_MOST):
        if not waiting:
            return
        one = waiting.pop(0)
        yield one
        waiting += one.exceptions if isinstance(one, BaseExceptionGroup) else ()
        led = one.__cause__ or one.__context__  # httpcore names no cause
        waiting += [led] if led is not None else []


def _wait_s(error: BaseException) -> float | None:
    if isinstance(error, FloodControl):
        return error.wait_s
    if isinstance(error, foreign.RetryAfter):
        # Its attribute warns on every reading; what it keeps inside is a timedelta.
        return error._retry_after.total_seconds()  # noqa: SLF001
    return None


def _is_gone(error: BaseException, reason: str) -> bool:
    words = reason.casefold()
    return isinstance(error, foreign.Forbidden) or any(said in words for said in _NO_CHAT)


def _too_fast(wait_s: float, reason: str) -> TelegramError:
    return TelegramError(
        f"Telegram asks to wait {wait_s:g} s.", ErrorKind.TOO_FAST, reason, wait_s=max(wait_s, 0.1)
    )
