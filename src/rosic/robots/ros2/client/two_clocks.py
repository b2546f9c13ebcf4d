"""The wall clock and the monotonic one, read as if in one moment."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

# Two readings one after the other take less than a microsecond, unless somebody else was given the
# processor in between: robots that begin together would then begin apart by so much.
CLOSE_NS = 20_000
LOOKS = 20


def ahead_ns(wall_ns: Callable[[], int], monotonic_ns: Callable[[], int]) -> int:
    """Return by how much the wall clock is ahead of the monotonic one.

    The wall clock is read between two looks at the other; of some tries the closest counts.
    """
    closest_ns = ahead = 0
    for look in range(LOOKS):
        before_ns = monotonic_ns()
        now_ns = wall_ns()
        took_ns = monotonic_ns() - before_ns
        if look == 0 or took_ns < closest_ns:
            closest_ns, ahead = took_ns, now_ns - before_ns - took_ns // 2
        if closest_ns < CLOSE_NS:
            break
    return ahead
