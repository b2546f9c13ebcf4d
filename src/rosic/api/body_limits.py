"""How long the body of a request may be, and how long it may take to come."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, MutableMapping
    from typing import TypeAlias

    Receive: TypeAlias = Callable[[], Awaitable[MutableMapping[str, Any]]]


class BodyLimitExceeded(Exception):
    """A body is longer than is taken; it was not read to its end."""


class BodyDeadlineExceeded(Exception):
    """A body takes longer than is waited for it; it was not read to its end."""


def bounded(receive: Receive, most: int, within_s: float) -> Receive:
    """Return what receives no more than so many bytes, in no more than so many seconds.

    A body need not say how long it is, and may come a byte at a time.
    """
    got, more, until_s = 0, True, asyncio.get_running_loop().time() + within_s

    async def limited() -> MutableMapping[str, Any]:
        nonlocal got, more
        if not more:  # what comes now is that the client has left, whenever that is
            return await receive()
        try:
            async with asyncio.timeout_at(until_s):
                message = await receive()
        except TimeoutError:
            raise BodyDeadlineExceeded from None
        more = bool(message.get("more_body"))
        got += len(message.get("body", b""))
        if got > most:
            raise BodyLimitExceeded
        return message

    return limited
