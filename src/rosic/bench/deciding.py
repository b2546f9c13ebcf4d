"""What deciding costs in a small place and in a large one."""

from __future__ import annotations

import gc
from random import Random
from statistics import median
from time import perf_counter_ns
from typing import TYPE_CHECKING

from rosic.app import loop
from rosic.bench.places import KINDS, LARGE, SMALL, Size, fill, gateway_over
from rosic.bench.report import Case, quantile
from rosic.core.asking import Allowed, Ask
from rosic.core.decision import decide
from rosic.core.identity import Address, Caller
from rosic.organiser.grounds import NOTHING
from rosic.stores.memory import MemoryStore

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.app.gateway import Gateway

ASKED = 60  # as many in either place: what differs is what lies around them
SPREAD = 3_000
RUNS, CALLS, QUICK_CALLS = 5, 20_000, 2_000
TURN_CALLS = 500  # so that a slow moment of the machine hits all alike
ARGUMENTS = {"speed": 0.1, "distance": 0.5}
METHOD = (
    "Deciding: calls of the rules alone, and of the organiser, who first looks up the key, the "
    "slot, the lease and the stop; p50 and p99 of single calls, the clock's own time taken off; "
    "the places take turns; {runs} runs, median; {asked} people and robots in turn, and once "
    "{spread}, who no longer fit the processor's caches."
)


class Place:
    """An open gateway of a size, and who is asked about in it."""

    def __init__(self, gateway: Gateway, size: Size, asked: int = ASKED) -> None:
        lot = Random(11)  # noqa: S311 - the same people every time
        # As many of each kind in either place.
        span = 2 * len(KINDS)
        people = [n % span + span * lot.randrange(size.people // span) for n in range(asked)]
        self.asked = [
            (
                Caller(f"p{n}", f"person {n}", Address("bench", str(n)), f"k{n}", "s"),
                f"robot{lot.randrange(size.robots)}",
            )
            for n in people
        ]
        self._organiser = gateway.rooms.organiser

    def rules(self) -> list[Callable[[], object]]:
        """Return what asks the rules alone."""

        def one(caller: Caller, robot: str) -> Callable[[], object]:
            state = self._organiser._state(caller, robot, NOTHING)  # noqa: SLF001 - what it would ask
            ask = Ask(
                principal=caller.principal, key=caller.key, robot=robot, skill="move",
                arguments=ARGUMENTS,
            )  # fmt: skip
            decision = decide(state, ask)
            if not isinstance(decision, Allowed):
                raise AssertionError(  # noqa: TRY004 - no matter of types
                    f"{caller.name} may not move {robot}: {decision.code.value}"
                )
            return lambda: decide(state, ask)

        return [one(*pair) for pair in self.asked]

    def whole(self) -> list[Callable[[], object]]:
        """Return what asks the organiser, who looks everything up."""

        def one(caller: Caller, robot: str) -> Callable[[], object]:
            return lambda: self._organiser.decision(caller, robot, "move", ARGUMENTS)

        return [one(*pair) for pair in self.asked]


async def _open(size: Size) -> Gateway:
    store = MemoryStore()
    await fill(store, size)
    gateway = gateway_over(size, store)
    await gateway.open()
    return gateway


def _times_ns(calls: list[Callable[[], object]], first: int, count: int) -> list[int]:
    taken: list[int] = []
    for n in range(first, first + count):
        call = calls[n % len(calls)]
        began_ns = perf_counter_ns()
        call()
        taken.append(perf_counter_ns() - began_ns)
    return taken


def measure(*, quick: bool = False) -> tuple[str, tuple[Case, ...]]:
    """Measure the rules alone and with everything looked up, in both places, in turns.

    Returns:
        How, and what was seen.
    """
    runs, calls = (1, QUICK_CALLS) if quick else (RUNS, CALLS)
    small, large = (loop.run(_open(size)) for size in (SMALL, LARGE))
    places = {str(SMALL): Place(small, SMALL), str(LARGE): Place(large, LARGE)}
    asking = {
        f"{what}: {size}": make(place)
        for what, make in (("decide", Place.rules), ("decide, all looked up", Place.whole))
        for size, place in places.items()
    }
    asking[f"decide, {SPREAD} in turn: {LARGE}"] = Place(large, LARGE, SPREAD).rules()
    empty: list[Callable[[], object]] = [lambda: None]
    gc.collect()
    gc.freeze()
    found: dict[str, list[list[int]]] = {name: [] for name in asking}
    clock: list[float] = []
    try:
        for _ in range(runs):
            clock.append(median(_times_ns(empty, 0, calls)))
            for times in found.values():
                times.append([])
            for first in range(0, calls, TURN_CALLS):
                for name, some in asking.items():
                    found[name][-1] += _times_ns(some, first, TURN_CALLS)
    finally:
        gc.unfreeze()
    cases = tuple(_case(name, times, median(clock)) for name, times in found.items())
    return METHOD.format(runs=runs, asked=ASKED, spread=SPREAD), cases


def _case(name: str, runs: list[list[int]], clock_ns: float) -> Case:
    p50_ns, p99_ns = (
        max(1.0, median(quantile(times, share) for times in runs) - clock_ns)
        for share in (0.50, 0.99)
    )
    rate = median(
        len(times) / (max(1.0, sum(times) - clock_ns * len(times)) / 1e9) for times in runs
    )
    return Case(
        name=name,
        rate_per_s=round(rate, 1),
        p50_us=round(p50_ns / 1e3, 3),
        p99_us=round(p99_ns / 1e3, 3),
    )
