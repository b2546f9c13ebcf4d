"""One robot's slots in order; no two of them overlap."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from typing import TYPE_CHECKING

from rosic.core.order import FOREVER_NS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.identity import PrincipalId
    from rosic.core.slot import BookedSlot

MOST_REMEMBERED = 256


class Timeline:
    """Asked for each order who has the robot now, it remembers the answer until that changes.

    It remembers too when the robot is free next, because that is told with each refusal, and in a
    calendar without gaps many slots have to be looked at to find out.

    Attributes:
        until_ns: For how long what `present` answered last is so.
    """

    __slots__ = ("_free", "_present", "_since_ns", "_slots", "_starts", "until_ns")

    def __init__(self) -> None:
        self._starts: list[int] = []
        self._slots: list[BookedSlot] = []
        self._free: dict[tuple[int, PrincipalId | None], tuple[int, int]] = {}
        self._present: BookedSlot | None = None
        self._since_ns = self.until_ns = 0  # for this long the answer holds: not at all yet

    def __len__(self) -> int:
        return len(self._slots)

    def add(self, slot: BookedSlot) -> bool:
        """Put a slot in; return False, and change nothing, if it overlaps another."""
        if self.overlapping(slot.start_ns, slot.end_ns) is not None:
            return False
        at = bisect_left(self._starts, slot.start_ns)
        self._starts.insert(at, slot.start_ns)
        self._slots.insert(at, slot)
        self._forget()
        return True

    def remove(self, slot: BookedSlot) -> None:
        """Take a slot out that is in."""
        at = bisect_left(self._starts, slot.start_ns)
        del self._starts[at], self._slots[at]
        self._forget()

    def present(self, now_ns: int) -> BookedSlot | None:
        """Return the slot that is now."""
        if self._since_ns <= now_ns < self.until_ns:
            return self._present
        after = bisect_right(self._starts, now_ns)
        before = self._slots[after - 1] if after else None
        next_ns = self._starts[after] if after < len(self._starts) else FOREVER_NS
        if before is not None and now_ns < before.end_ns:
            self._present, self._since_ns, self.until_ns = before, before.start_ns, before.end_ns
        else:
            ended_ns = before.end_ns if before is not None else -FOREVER_NS
            self._present, self._since_ns, self.until_ns = None, ended_ns, next_ns
        return self._present

    def next_after(self, now_ns: int) -> BookedSlot | None:
        """Return the first slot that starts after a moment."""
        at = bisect_right(self._starts, now_ns)
        return self._slots[at] if at < len(self._slots) else None

    def overlapping(self, from_ns: int, to_ns: int) -> BookedSlot | None:
        """Return the first slot that takes some of this time."""
        at = self._first_ending_after(from_ns)
        if at < len(self._slots) and self._starts[at] < to_ns:
            return self._slots[at]
        return None

    def between(self, from_ns: int, to_ns: int) -> Iterator[BookedSlot]:
        """Yield the slots that take some of this time."""
        at = self._first_ending_after(from_ns)
        while at < len(self._slots) and self._starts[at] < to_ns:
            yield self._slots[at]
            at += 1

    def free_from(self, from_ns: int, length_ns: int, principal: PrincipalId | None) -> int:
        """Return from when on so much time is nobody's.

        Args:
            from_ns: Not earlier.
            length_ns: How much; at least 1.
            principal: Whose own slots count as free; None: nobody's.
        """
        asked = length_ns, principal
        since_ns, free_ns = self._free.get(asked, (FOREVER_NS, 0))
        if since_ns <= from_ns <= free_ns:
            return free_ns
        if len(self._free) >= MOST_REMEMBERED:
            self._free.clear()
        free_ns = self._search(from_ns, length_ns, principal)
        self._free[asked] = from_ns, free_ns
        return free_ns

    def _search(self, from_ns: int, length_ns: int, principal: PrincipalId | None) -> int:
        at, free_ns = self._first_ending_after(from_ns), from_ns
        while at < len(self._slots) and self._starts[at] < free_ns + length_ns:
            if self._slots[at].principal != principal:
                free_ns = self._slots[at].end_ns
            at += 1
        return free_ns

    def _forget(self) -> None:
        self._since_ns = self.until_ns = 0
        self._free.clear()

    def _first_ending_after(self, at_ns: int) -> int:
        at = bisect_right(self._starts, at_ns)
        return at - 1 if at and self._slots[at - 1].end_ns > at_ns else at
