"""What is too old to act on, in the words of the person who sent it (I2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.errors import Expired

if TYPE_CHECKING:
    from rosic.core.message import Inbound
    from rosic.core.order import Request

MINUTE_S = 60
HOUR_S = 3600
ERRAND_LIFETIME_NS: Final = 30_000_000_000
MISSED: Final = said("You sent this while I could not listen. Nothing was done.")
NETWORK_AWAY: Final = said("You sent this while the network was away. Nothing was done.")


def check_fresh(inbound: Inbound, request: Request, now_ns: int) -> None:
    """Let a request pass that is young enough, and was sent while somebody listened.

    Args:
        inbound: The message it came in.
        request: Knows its deadline.
        now_ns: Monotonic clock.

    Raises:
        Expired: With the same command on offer.
    """
    lifetime_ns = request.skill.order_lifetime_ns
    if now_ns > request.deadline_ns:
        total_ns = now_ns - (request.deadline_ns - lifetime_ns)
        raise Expired(too_old(inbound, total_ns, lifetime_ns), offers=(request.text,))
    if request.skill.actuates and inbound.sent_ns < inbound.listening_since_ns:
        raise Expired(_missed(inbound), offers=(request.text,))


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
    check_heard_in_time(inbound, ERRAND_LIFETIME_NS, again)


def check_heard_in_time(inbound: Inbound, lifetime_ns: int, again: str) -> None:
    """Let a message pass that took no longer to get here, and was sent while somebody listened.

    Raises:
        Expired: With the same on offer.
    """
    age_ns = inbound.received_ns - inbound.sent_ns
    if age_ns > lifetime_ns:
        raise Expired(too_old(inbound, age_ns, lifetime_ns), offers=(again,))
    if is_missed(inbound):
        raise Expired(_missed(inbound), offers=(again,))


def is_missed(inbound: Inbound) -> bool:
    """Whether it was sent while nobody listened."""
    return inbound.sent_ns < inbound.listening_since_ns


def _missed(inbound: Inbound) -> str:
    return NETWORK_AWAY if inbound.network_away else MISSED


def too_old(inbound: Inbound, age_ns: int, lifetime_ns: int) -> str:
    """Return how old a command is, and where it was meanwhile, as far as is known here.

    Args:
        inbound: The message it came in.
        age_ns: Now, since it was sent.
        lifetime_ns: For how long it would have been good.
    """
    if is_missed(inbound) and inbound.network_away:
        return said(
            "Your command is {age} old (the network was away). Nothing was done.", age=age(age_ns)
        )
    if is_missed(inbound):
        return said(
            "Your command is {age} old: you sent it while I could not listen. Nothing was done.",
            age=age(age_ns),
        )
    if inbound.received_ns - inbound.sent_ns > lifetime_ns:
        return said(
            "Your command is {age} old: it reached me late. Nothing was done.", age=age(age_ns)
        )
    return said(
        "Your command is {age} old: it waited here behind others. Nothing was done.",
        age=age(age_ns),
    )


def age(age_ns: int) -> str:
    """Return an age as people say it."""
    seconds = age_ns / 1e9
    if seconds < 2 * MINUTE_S:
        return said("{seconds:.0f} seconds", seconds=seconds)
    if seconds < 2 * HOUR_S:
        return said("{seconds:.0f} minutes", seconds=seconds / MINUTE_S)
    return said("{seconds:.0f} hours", seconds=seconds / HOUR_S)
