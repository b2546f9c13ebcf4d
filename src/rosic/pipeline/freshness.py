"""What is too old to act on, in the words of the person who sent it (I2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.saying import said
from rosic.errors import Expired

if TYPE_CHECKING:
    from rosic.core.message import Inbound
    from rosic.core.order import Request

MINUTE_S = 60
HOUR_S = 3600


def check_fresh(inbound: Inbound, request: Request, now_ns: int) -> None:
    """Let a request pass that is young enough, and was sent while somebody listened.

    Args:
        inbound: The message it came in.
        request: Knows its deadline.
        now_ns: Monotonic clock.

    Raises:
        Expired: With the same command on offer.
    """
    if now_ns > request.deadline_ns:
        raise Expired(
            said(
                "Your command is {age} old (the network was away). Nothing was done.",
                age=age(request.age_ns),
            ),
            offers=(request.text,),
        )
    if request.skill.actuates and inbound.sent_ns < inbound.listening_since_ns:
        raise Expired(
            said("You sent this while I could not listen. Nothing was done."),
            offers=(request.text,),
        )


def age(age_ns: int) -> str:
    """Return an age as people say it."""
    seconds = age_ns / 1e9
    if seconds < 2 * MINUTE_S:
        return said("{seconds:.0f} seconds", seconds=seconds)
    if seconds < 2 * HOUR_S:
        return said("{seconds:.0f} minutes", seconds=seconds / MINUTE_S)
    return said("{seconds:.0f} hours", seconds=seconds / HOUR_S)
