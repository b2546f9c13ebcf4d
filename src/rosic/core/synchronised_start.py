"""A common start: when a robot begins that is to begin with others, and when it is too late to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from msgspec.structs import replace

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.order import Order

TOGETHER_NS: Final = 500_000_000
"""Far enough ahead for all of them to have heard."""
TOO_LATE_NS: Final = 100_000_000
"""So long after a common start a robot may still begin.

Robots are promised to begin within 20 ms of each other. Five times that is still taken for one
moment by whoever looks, and a robot at walking pace is then 10 cm behind; beyond it they would not
begin together but one after another, which is another thing than what was asked. What is to begin
together is sent half a second ahead, so this is no narrow bound for what travels as it should.
"""


def begin_together(orders: Iterable[Order], now_ns: int) -> tuple[Order, ...]:
    """Return orders that begin at one moment, soon.

    Agreed once they are on disk: a slow disk would make all of them too late.
    """
    return tuple(replace(order, start_ns=now_ns + TOGETHER_NS) for order in orders)


def begins_ns(order: Order, now_ns: int) -> int | None:
    """Return the common start that an order is to keep, monotonic clock; None: it begins at once.

    A later line of a message waits until its robot has done the line before: its own common start
    may have passed meanwhile, and it begins when its turn comes.
    """
    start_ns = order.start_ns
    return None if start_ns is None or (order.sequel and start_ns < now_ns) else start_ns


def misses_start(order: Order, now_ns: int, wall_ns: int) -> bool:
    """Tell whether the others have begun too long ago for an order to begin with them.

    By either clock: while a virtual machine was paused, the others went on.
    """
    start_ns = begins_ns(order, now_ns)
    if start_ns is None:
        return False
    ahead_ns = order.expires_ns - order.deadline_ns
    return max(now_ns, wall_ns - ahead_ns) > start_ns + TOO_LATE_NS
