"""Stops as they come in: whatever cannot be read of one, it is a stop, of everything.

Whoever asks for a stop means it, and a field too many is no reason to let a robot drive on.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

import msgspec
from litestar import Request
from litestar.exceptions import HTTPException

from rosic.api.body_limits import BodyDeadlineExceeded, BodyLimitExceeded
from rosic.api.schemas import NAME_MOST, ROBOTS_MOST, WAIT_MOST_S, StopIn

if TYPE_CHECKING:
    from collections.abc import Callable

_STOP: Final = re.compile(r"\bstop\b", re.IGNORECASE)
_BAD: Final = (msgspec.MsgspecError, UnicodeError, RecursionError)


class _Loose(msgspec.Struct):
    robots: Any = ()
    wait_s: Any = StopIn().wait_s


_read: Callable[[bytes], _Loose] = msgspec.json.Decoder(_Loose).decode


def read_stop(body: bytes) -> StopIn:
    """Return the stop that somebody wants; of everything where its robots cannot be read."""
    try:
        found = _read(body)
    except _BAD:
        return StopIn()
    wait_s = found.wait_s
    if isinstance(wait_s, bool) or not isinstance(wait_s, int | float):
        wait_s = StopIn().wait_s
    return StopIn(_named(found.robots), float(min(max(wait_s, 0), WAIT_MOST_S)))


def _named(robots: object) -> tuple[str, ...]:
    if not isinstance(robots, list) or len(robots) > ROBOTS_MOST:
        return ()
    named = tuple(each for each in robots if isinstance(each, str) and 0 < len(each) <= NAME_MOST)
    return named if len(named) == len(robots) else ()


def mentions_stop(text: str) -> bool:
    """Whether a message that cannot be read speaks of a stop, in whatever case and quotes."""
    return _STOP.search(text) is not None


class StopRequestBody(Request[Any, Any, Any]):
    """A request that stops: nothing about its body is a reason to refuse it."""

    async def body(self) -> bytes:
        """Return what is wanted, in a form that can be read."""
        try:
            body = await super().body()
        except (BodyLimitExceeded, BodyDeadlineExceeded, HTTPException):
            body = b""  # too long, too slow, or broken off: it is a stop all the same
        return msgspec.json.encode(read_stop(body))
