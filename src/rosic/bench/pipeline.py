"""How many orders a second pass the whole way, and how long one takes; see `rosic.bench.orders`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.app import runtime
from rosic.bench import admission, memory
from rosic.bench.orders import ROBOTS, OrderLoad, OrderRun, run
from rosic.bench.paired_runs import times_as_much
from rosic.bench.report import BenchRatio, BenchReport, case_of, machine, spread_of
from rosic.bench.senders import TURN_MESSAGES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.bench.recorder import BenchRecorder


METHOD = (
    "Orders that ended done at a robot with a distinct number, each counted once its author was "
    "told. People take turns: one sends {turn} messages on each of the slots in flight at a robot, "
    "then the lease passes to the next. {robots} robots in memory, {runs} runs, median. A skill is "
    "asked for in the same words each time, once before the clock starts, and what was read before "
    "is remembered, but for the case that says otherwise. "
    "The sending side runs in the same process and thread and is part of the time. Event loop: "
    "{loop}."
)

CASES = (
    OrderLoad(name="memory, 256 in flight", orders=40_000),
    OrderLoad(name="memory, 1 in flight", orders=5_000, in_flight=1),
    OrderLoad(name="memory, 5 skills", orders=40_000, skills=5),
    OrderLoad(name="memory, 5000 skills", orders=40_000, skills=5_000),
    OrderLoad(name="memory, 10 people", orders=40_000, people=10),
    OrderLoad(name="memory, 10000 people", orders=40_000, people=10_000),
    OrderLoad(
        name="memory, 10000 people, 100 roles, 50000 slots",
        orders=40_000,
        people=10_000,
        roles=100,
        slots=50_000,
    ),
    OrderLoad(name="memory, every text new", orders=40_000, new_texts=True),
    OrderLoad(name="durable, 256 in flight", orders=20_000, durable=True),
    OrderLoad(name="durable, 1 in flight", orders=1_000, in_flight=1, durable=True),
)
BESIDE = ", beside others"
# What may not grow with how much there is: these take turns with the first case, slice by slice.
COMPARED = (
    "memory, 5 skills",
    "memory, 5000 skills",
    "memory, 10 people",
    "memory, 10000 people",
)


def measure(recorder: BenchRecorder) -> BenchReport:
    """Run every case in turns, so that a slow moment of the machine hits all alike."""
    quick = recorder.quick
    runs = 1 if quick else 5
    loads = tuple(map(_briefly, CASES)) if quick else CASES
    abreast = (loads[0], *(load for load in loads if load.name in COMPARED))
    seen: dict[str, list[OrderRun]] = {load.name: [] for load in loads}
    reference: list[OrderRun] = []
    for _ in range(runs):
        for load in loads:
            if load.name not in COMPARED:
                with recorder.turn(load.name, of=runs) as turn:
                    ran = runtime.run(run(load))
                    turn.saw(ran[0].rate_per_s, ran[0].times_ns)
                seen[load.name] += ran
        with recorder.turn(loads[0].name + BESIDE, of=runs) as turn:
            first, *others = runtime.run(run(*abreast))
            turn.saw(first.rate_per_s, first.times_ns)
        reference.append(first)
        for name, other in zip(COMPARED, others, strict=True):
            seen[name].append(other)
            recorder.keep(
                name,
                like=loads[0].name + BESIDE,
                times_ns=other.times_ns,
                rate_per_s=other.rate_per_s,
            )
    orders = [
        case_of(n, [(r.rate_per_s, r.times_ns) for r in ran], recorder.paces_us(n))
        for n, ran in seen.items()
    ]
    ratios = tuple(_ratio(name, seen[name], reference) for name in COMPARED)
    method = METHOD.format(turn=TURN_MESSAGES, robots=ROBOTS, runs=runs, loop=runtime.name())
    with recorder.turn("decide"):
        how, asked = admission.measure(quick=quick)
        recorder.see(asked)
    how_weighed, weighed = memory.measure(quick=quick)
    return BenchReport(
        machine=machine(),
        method=f"{method} {how} {how_weighed}",
        cases=(*orders, *asked, weighed),
        findings=tuple(map(_said, ratios)),
        ratios=ratios,
    )


def _briefly(load: OrderLoad) -> OrderLoad:
    return msgspec.structs.replace(load, orders=max(500, load.orders // 20))


def _ratio(name: str, runs: Sequence[OrderRun], reference: Sequence[OrderRun]) -> BenchRatio:
    """Return how many times as much an order costs as in the first case, turn for turn."""
    some, others = ([each for ran in those for each in ran.each_s] for those in (runs, reference))
    each = [
        times_as_much(one.each_s, other.each_s) for one, other in zip(runs, reference, strict=True)
    ]
    usual = CASES[0]
    return BenchRatio(
        name=f"{name} beside the first",
        value=round(times_as_much(some, others), 3),
        spread=spread_of(each),
        of=f"what an order costs, by what it costs with {usual.skills} skills and {usual.people} "
        "people, turn for turn",
    )


def _said(ratio: BenchRatio) -> str:
    return f"{ratio.name}: {ratio.value:.2f} times {ratio.of}."
