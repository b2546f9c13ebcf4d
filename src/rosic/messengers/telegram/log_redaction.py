"""Keeps tokens out of every log line and every trace that is logged."""

from __future__ import annotations

import logging
import traceback
from typing import TYPE_CHECKING, Any

from rosic.core.secret import MASK

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.secret import Secret

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
