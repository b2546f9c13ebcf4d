"""The wall clock and the monotonic one are read as if in one moment, whoever comes in between."""

from __future__ import annotations

from itertools import chain, repeat
from typing import TYPE_CHECKING

from rosic.robots.ros2.client.executor_thread import CLOSE_NS, LOOKS, ahead_ns

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

AHEAD_NS = 1_800_000_000_000_000_000
MS = 1_000_000


class Computer:
    """Two clocks of one computer; before a reading, somebody else may have the processor."""

    def __init__(self, elsewhere_ns: Iterable[int]) -> None:
        self._elsewhere_ns: Iterator[int] = chain(elsewhere_ns, repeat(0))
        self._now_ns = 5_000 * MS
        self.readings = 0

    def monotonic_ns(self) -> int:
        """Return the time since it was started."""
        self._now_ns += 100 + next(self._elsewhere_ns)
        self.readings += 1
        return self._now_ns

    def wall_ns(self) -> int:
        """Return the time of day."""
        return self.monotonic_ns() + AHEAD_NS


def off_ns(*elsewhere_ns: int) -> int:
    """Return how wrong the answer is on a computer that is elsewhere before its readings."""
    computer = Computer(elsewhere_ns)
    return abs(ahead_ns(computer.wall_ns, computer.monotonic_ns) - AHEAD_NS)


def test_nobody_in_between_takes_one_look() -> None:
    computer = Computer(())

    assert abs(ahead_ns(computer.wall_ns, computer.monotonic_ns) - AHEAD_NS) <= CLOSE_NS
    assert computer.readings == 3


def test_who_lost_the_processor_between_two_readings_looks_again() -> None:
    assert off_ns(0, 8 * MS) <= CLOSE_NS
    assert off_ns(0, 0, 8 * MS) <= CLOSE_NS
    assert off_ns(0, 8 * MS, 0, 8 * MS, 0, 0, 0, 0, 30 * MS) <= CLOSE_NS


def test_of_bad_looks_the_best_counts() -> None:
    bad = [0, 8 * MS, 0] * (LOOKS // 2)

    assert off_ns(*bad, 0, 2 * MS, 0, *bad) <= 1 * MS + CLOSE_NS


def test_a_clock_that_stands_still_is_read_exactly() -> None:
    assert ahead_ns(lambda: AHEAD_NS + 7, lambda: 7) == AHEAD_NS
