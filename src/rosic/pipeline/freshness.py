"""What is too old to act on, in the words of the person who sent it (I2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.saying import said
from rosic.errors import Expired

if TYPE_CHECKING:
    from rosic.core.message import Inbound
    from rosic.core.order import Request

MINUTE_S = 60
HOUR_S = 3600
ERRAND_LIFETIME_NS: Final = 30_000_000_000
MISSED: Final = said("You sent this while I could not listen. Nothing was done.")


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
        raise Expired(MISSED, offers=(request.text,))


def check_errand_fresh(inbound: Inbound, again: str) -> None:
    """Let an errand pass that robots move because of, if it was sent just now (I2).

    It also keeps a message that is brought once more after a crash from counting twice (I1): it was
    sent before anybody listened.

    Args:
        inbound: The message it came in.
        again: The same errand, as it would be typed.

    Raises:
        Expired: With the same errand on offer.
    """
    old = inbound.received_ns - inbound.sent_ns > ERRAND_LIFETIME_NS
    if old or inbound.sent_ns < inbound.listening_since_ns:
        raise Expired(MISSED, offers=(again,))


def age(age_ns: int) -> str:
    """Return an age as people say it."""
    seconds = age_ns / 1e9
    if seconds < 2 * MINUTE_S:
        return said("{seconds:.0f} seconds", seconds=seconds)
    if seconds < 2 * HOUR_S:
        return said("{seconds:.0f} minutes", seconds=seconds / MINUTE_S)
    return said("{seconds:.0f} hours", seconds=seconds / HOUR_S)
