"""What the calendar costs: ``python -m tests.organiser.cost`` prints it."""

from __future__ import annotations

import gc
import tracemalloc
from statistics import median
from time import perf_counter_ns
from typing import TYPE_CHECKING

import msgspec

from rosic.core.slot import BookedSlot
from rosic.organiser.calendar import Calendar
from rosic.testing.clock import ManualClock
from tests.organiser.booking import MIN, NOW, UNNAMED, S

if TYPE_CHECKING:
    from rosic.core.records import Fact

ROBOTS = 3
PEOPLE = 500
CALLS = 1000


def facts(many: int) -> list[Fact]:
    """Return slots of 20 min, half an hour apart, one third of them over."""
    found = []
    for number in range(many):
        start_ns = NOW + (number // ROBOTS - many // (3 * ROBOTS)) * 30 * MIN
        slot = BookedSlot(
            id=f"{number * 0x9E3779B97F4A7C15 % 2**64:016x}",
            principal=f"p-{number % PEOPLE:08}",
            robot=f"robot{number % ROBOTS}",
            start_ns=start_ns,
            end_ns=start_ns + 20 * MIN,
            made_ns=NOW - number * S,
            by=f"p-{number % PEOPLE:08}",
        )
        found.append(slot.fact())
    return sorted(found, key=lambda fact: fact.key)  # not in the order of time


def restored(written: list[Fact]) -> Calendar:
    """Return a calendar that starts from facts of its own."""
    calendar = Calendar(ManualClock(NOW), UNNAMED)
    calendar.restore(msgspec.structs.replace(fact) for fact in written)
    return calendar


def present_ns(calendar: Calendar) -> float:
    """Return the median time of one `present`, over five runs, while the clock goes on."""
    runs = []
    for _ in range(5):
        taken = []
        for call in range(CALLS):
            robot, now_ns = f"robot{call % ROBOTS}", NOW + call * 10 * S
            began = perf_counter_ns()
            calendar.present(robot, now_ns)
            taken.append(perf_counter_ns() - began)
        runs.append(median(taken))
    return median(runs)


def hindrance_ns(calendar: Calendar) -> float:
    """Return the median time of one `why_not` for somebody who is kept out."""
    taken = []
    for call in range(CALLS):
        now_ns = NOW + call * 10 * S
        began = perf_counter_ns()
        calendar.why_not("p-00000499", f"robot{call % ROBOTS}", now_ns, required=True)
        taken.append(perf_counter_ns() - began)
    return median(taken)


def main() -> None:
    """Print every figure."""
    for many in (100, 50_000):
        calendar = restored(facts(many))
        print(f"{many} slots: present p50 {present_ns(calendar):.0f} ns")  # noqa: T201
        print(f"{many} slots: why_not, kept out, p50 {hindrance_ns(calendar):.0f} ns")  # noqa: T201
    written = facts(50_000)
    times = []
    calendar = restored(written)
    for _ in range(5):
        gc.collect()
        began = perf_counter_ns()
        calendar = restored(written)
        times.append(perf_counter_ns() - began)
    print(f"{len(calendar)} slots: restored in {median(times) / 1e9:.2f} s")  # noqa: T201
    began = perf_counter_ns()
    for _ in range(CALLS):
        (fact,) = calendar.book("p-new", "robot0", NOW + 21 * MIN, 60, "p-new")
        calendar.apply(fact)
        calendar.apply(calendar.of("p-new")[0].no_more())
    print(f"book, apply, take away: {(perf_counter_ns() - began) / CALLS / 1000:.0f} us")  # noqa: T201
    tracemalloc.start()
    kept = restored(written)
    gc.collect()
    print(f"memory: {tracemalloc.get_traced_memory()[0] / len(kept):.0f} bytes a slot")  # noqa: T201


if __name__ == "__main__":
    main()
