"""What deciding costs in a small place and in a large one."""

from __future__ import annotations

import gc
from functools import partial
from random import Random
from statistics import median
from time import perf_counter_ns
from typing import TYPE_CHECKING, TypeAlias

from rosic.app import runtime
from rosic.bench.report import BenchCase, quantile
from rosic.bench.sites import KINDS, LARGE, SMALL, SiteSize, fill, gateway_over
from rosic.core.policy.evaluate import decide
from rosic.core.policy.query import NOTHING, Deny, Query
from rosic.stores.memory import MemoryStore

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.app.gateway import Gateway
    from rosic.core.identity import Caller
    from rosic.core.robot.profile import RobotId

ASKED = 60  # as many in either place: what differs is what lies around them
SPREAD = 3_000
RUNS, CALLS, QUICK_CALLS = 5, 20_000, 2_000
TURN_CALLS = 500  # so that a slow moment of the machine hits all alike
ARGUMENTS = {"speed": 0.1, "distance": 0.5}
Call: TypeAlias = "Callable[[], object]"
METHOD = (
    "Deciding: calls of the rules alone, over a state made for the very question, as each order "
    "has one, and of the organiser, who first looks up the key, the slot, the lease and the stop; "
    "p50 and p99 of a run, the clock's own time taken off; the places take turns of {turn} calls; "
    "{runs} runs, median; {asked} people and robots in turn, "
    "and {spread}, who no longer fit the processor's caches."
)


class AdmissionSite:
    """An open gateway of a size, and who is asked about in it."""

    def __init__(self, gateway: Gateway, size: SiteSize, asked: int = ASKED) -> None:
        lot = Random(11)  # noqa: S311 - the same people every time
        # As many of each kind in either place.
        span = 2 * len(KINDS)
        people = [n % span + span * lot.randrange(size.people // span) for n in range(asked)]
        robots = list(gateway.rooms.profiles)
        self.asked = [(f"p{n}", lot.choice(robots)) for n in people]
        self._authoriser = gateway.rooms.authoriser
        self._organiser = gateway.rooms.organiser

    def _next(self, number: int) -> tuple[Caller, RobotId]:
        """Return who asks, as somebody who has just been recognised, and about which robot."""
        principal, robot = self.asked[number % len(self.asked)]
        return self._authoriser.stand_for(principal), robot

    def rules(self, number: int) -> Call:
        """Return what asks the rules alone; the state is of this moment, the looking up is over."""
        caller, robot = self._next(number)
        state = self._organiser._state(caller, robot, NOTHING)  # noqa: SLF001 - what it would ask
        ask = Query(
            principal=caller.principal,
            key=caller.key,
            robot=robot,
            skill="move",
            arguments=ARGUMENTS,
        )
        return partial(decide, state, ask)

    def whole(self, number: int) -> Call:
        """Return what asks the organiser, who looks everything up."""
        return partial(self._organiser.decision, *self._next(number), "move", ARGUMENTS)

    def check(self) -> None:
        """See that all of them may: a refusal ends sooner, or later."""
        for number, (who, robot) in enumerate(self.asked):
            decision = self._organiser.decision(*self._next(number), "move", ARGUMENTS)
            if isinstance(decision, Deny):
                what = f"{who} may not move {robot}: {decision.code.value}"
                raise AssertionError(what)  # noqa: TRY004 - no matter of types


def _nothing(_number: int) -> Call:
    return partial(bool)


ASKING = {"decide": AdmissionSite.rules, "decide, all looked up": AdmissionSite.whole}


async def _open(size: SiteSize) -> Gateway:
    store = MemoryStore()
    await fill(store, size)
    gateway = gateway_over(size, store)
    await gateway.open()
    return gateway


def _times_ns(prepare: Callable[[int], Call], first: int, count: int) -> list[int]:
    taken: list[int] = []
    for number in range(first, first + count):
        call = prepare(number)
        began_ns = perf_counter_ns()
        call()
        taken.append(perf_counter_ns() - began_ns)
    return taken


def measure(*, quick: bool = False) -> tuple[str, tuple[BenchCase, ...]]:
    """Measure the rules alone and with everything looked up, in both places, in turns.

    Returns:
        How, and what was seen.
    """
    runs, calls = (1, QUICK_CALLS) if quick else (RUNS, CALLS)
    small, large = (runtime.run(_open(size)) for size in (SMALL, LARGE))
    sites = {
        str(SMALL): AdmissionSite(small, SMALL),
        str(LARGE): AdmissionSite(large, LARGE),
        f"{LARGE}, {SPREAD} of them in turn": AdmissionSite(large, LARGE, SPREAD),
    }
    for place in sites.values():
        place.check()
    asking = {
        f"{what}: {where}": partial(ask, place)
        for what, ask in ASKING.items()
        for where, place in sites.items()
    }
    gc.collect()
    gc.freeze()
    found: dict[str, list[list[int]]] = {name: [] for name in asking}
    clock: list[float] = []
    try:
        for _ in range(runs):
            clock.append(median(_times_ns(_nothing, 0, calls)))
            for times in found.values():
                times.append([])
            for first in range(0, calls, TURN_CALLS):
                for name, prepare in asking.items():
                    found[name][-1] += _times_ns(prepare, first, TURN_CALLS)
    finally:
        gc.unfreeze()
    cases = tuple(_case(name, times, median(clock)) for name, times in found.items())
    return METHOD.format(runs=runs, turn=TURN_CALLS, asked=ASKED, spread=SPREAD), cases


def _case(name: str, runs: list[list[int]], clock_ns: float) -> BenchCase:
    p50_ns = median(quantile(times, 0.50) for times in runs)
    p99_ns = median(quantile(times, 0.99) for times in runs)
    rate = median(
        len(times) / (max(1.0, sum(times) - clock_ns * len(times)) / 1e9) for times in runs
    )
    return BenchCase(
        name=name,
        rate_per_s=round(rate, 1),
        p50_us=round(max(1.0, p50_ns - clock_ns) / 1e3, 3),
        p99_us=round(max(1.0, p99_ns - clock_ns) / 1e3, 3),
    )
