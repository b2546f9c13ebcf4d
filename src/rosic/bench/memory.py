"""What one person more keeps in memory, and what a change of somebody's rights costs."""

from __future__ import annotations

import gc
import tempfile
import tracemalloc
from pathlib import Path
from time import perf_counter_ns
from typing import TYPE_CHECKING, NamedTuple

from rosic.app import runtime
from rosic.bench.report import BenchCase, quantile
from rosic.bench.sites import CLOCK, LARGE, SiteSize, fill, gateway_over
from rosic.core.policy.roles import Grant
from rosic.core.time_units import HOUR_NS
from rosic.organiser.grants import fact_of
from rosic.stores.database import DatabaseStore

if TYPE_CHECKING:
    from rosic.app.gateway import Gateway

CHANGES = 200
QUICK_PEOPLE = 1_000
METHOD = (
    "A person's memory: what a gateway keeps that read {people} people, their keys and rights from "
    "the disk, less one that read none, shared out; slots apart. Its rate is people read, its "
    "times those of a change of one person's rights, which is live when it returns."
)


class MemoryFigures(NamedTuple):
    """What was seen of a gateway over a record on disk.

    Attributes:
        traced: Bytes that it keeps.
        opened_s: How long it took to open, untraced.
        changes_ns: How long changes of one person's rights took.
    """

    traced: int
    opened_s: float
    changes_ns: list[int]


async def _kept(size: SiteSize) -> MemoryFigures:
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as folder:
        path = Path(folder)
        await fill(DatabaseStore(path, clock=CLOCK), size)
        gateway = gateway_over(size, DatabaseStore(path, clock=CLOCK))
        began_ns = perf_counter_ns()
        await gateway.open()
        opened_s = (perf_counter_ns() - began_ns) / 1e9
        changes = [_change_ns(gateway, f"p{n}") for n in range(min(CHANGES, size.people))]
        await gateway.close()
        gateway = gateway_over(size, DatabaseStore(path, clock=CLOCK))
        gc.collect()
        tracemalloc.start()
        try:
            await gateway.open()
            gc.collect()
            traced, _ = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
        await gateway.close()
    return MemoryFigures(traced, opened_s, changes)


def _change_ns(gateway: Gateway, who: str) -> int:
    authority = gateway.authority
    fact = fact_of(who, Grant(id=f"x{who}", role="viewer", expires_ns=CLOCK.wall_ns() + HOUR_NS))
    began_ns = perf_counter_ns()
    authority.granted(fact)
    return perf_counter_ns() - began_ns


def measure(*, quick: bool = False) -> tuple[str, BenchCase]:
    """Return how it is measured, and what was seen."""
    people = QUICK_PEOPLE if quick else LARGE.people
    many, none = (
        runtime.run(_kept(LARGE._replace(people=count, slots=0))) for count in (people, 0)
    )
    case = BenchCase(
        name=f"a person's memory: {people} people, {LARGE.roles} roles",
        rate_per_s=round(people / many.opened_s, 1),
        p50_us=round(quantile(many.changes_ns, 0.50) / 1e3, 3),
        p99_us=round(quantile(many.changes_ns, 0.99) / 1e3, 3),
        bytes_each=round((many.traced - none.traced) / people, 1),
    )
    return METHOD.format(people=people), case
