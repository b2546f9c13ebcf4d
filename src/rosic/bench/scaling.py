"""Whether a gateway minds how many robots and people there are: the same commands over ever more.

Each size runs in a process of its own, robots and people in others: see
`rosic.bench.scaling_process`.
"""

from __future__ import annotations

import asyncio
import sys
from contextlib import AsyncExitStack
from itertools import chain
from statistics import median
from typing import TYPE_CHECKING

import msgspec

from rosic.bench.paired_runs import (
    COMMANDS,
    MESSAGES,
    REPORTS,
    STOPS,
    TURNS,
    PairedProcess,
    in_turns,
    times_as_much,
    waiting,
)
from rosic.bench.report import BenchCase, case_of, quantile
from rosic.bench.scaling_process import STRETCHES, CommandFigures, ProcessFigures, ScalingPlan

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rosic.bench.recorder import BenchRecorder


SIZES, QUICK_SIZES = (10, 100, 1_000, 5_000), (10, 200)
PEOPLE = (500, 1)
PER_S = 200
RUNS = 2
STOPPED = 5
METHOD = (
    "Robots in memory report once a second and say five times a second that they live, over a "
    "socket, from a process of their own. People send {per_s} commands a second in all, whatever "
    "their number, from another; hardly any is said twice. Each size in a fresh process, {runs} "
    "runs, median. A command: from its sending until its author is told that it is done; median of "
    "the seconds. Flat "
    "out: 50 at a time, nobody reporting; its cost is processor time, less that of the quiet "
    "gateway. A report: what one message of a robot costs while {messages} wait. Both in turns, at "
    "the end: gateways are compared turn for turn. Stop: from its "
    "receipt until the last adapter has it. A robot's memory is that of the whole process beyond "
    "the smallest. The robots' process takes {robots_share:.1%} of a processor for {most} robots, "
    "the people's {people_share:.1%}; neither is counted. Seen: {seen}"
)
SAME = " ({command:.2f} and {report:.2f} times in one gateway of {small} as in another)"
SEEN = (
    "p99 at {large} robots is {p99:.2f} times that at {small}, and {own:.2f} times of what the "
    "gateway was at work; a command costs {command:.2f} times "
    "and a report {report:.2f} times as much at {most} as at {small}{same}."
)


class ScalingCase(BenchCase, frozen=True, kw_only=True):
    """One thing seen at one size.

    Attributes:
        own_p50_us, own_p99_us: Of the time until somebody is told, what the gateway itself was at
            work, on this and on all else: what others do on the machine is no part of it.
        cpu_us: Processor time of one command, or of one robot a second with all it says and all
            that looks after it.
        start_s: How long a gateway takes to open.
        refused: Commands that came to nothing: somebody else's had just begun.
    """

    own_p50_us: float | None = None
    own_p99_us: float | None = None
    cpu_us: float | None = None
    start_s: float | None = None
    refused: int | None = None

    def beside(self) -> Iterator[str]:
        """Yield what a table says besides."""
        yield from super().beside()
        if self.own_p99_us is not None:
            yield f"at work {self.own_p50_us:.1f} and {self.own_p99_us:.1f} us of it"
        if self.cpu_us is not None:
            yield f"{self.cpu_us:.1f} us of processor each"
        if self.start_s is not None:
            yield f"open in {self.start_s:.2f} s"
        if self.refused:
            yield f"{self.refused} refused"


async def look(sizes: tuple[ScalingPlan, ...], runs: int) -> list[list[ProcessFigures]]:
    """Return what was seen of each size, run after run: slow moments hit all sizes alike."""
    processes: list[PairedProcess] = []
    found: list[ProcessFigures] = []
    async with AsyncExitStack() as stack:
        for plan in sizes * runs:
            words = msgspec.json.encode(plan).decode()
            process = waiting(sys.executable, "-m", "rosic.bench.scaling_process", words)
            processes.append(await stack.enter_async_context(process))
            found.append(msgspec.json.decode(await processes[-1].line(), type=ProcessFigures))
        flat_out = await in_turns(processes, COMMANDS, STRETCHES, CommandFigures)
        each_ns = await in_turns(processes, REPORTS, TURNS, float)
        stops_ns = await in_turns(processes, STOPS, STOPPED, int)  # the last: they stay stopped
    whole = [
        msgspec.structs.replace(seen, flat_out=commanded, each_ns=each, stops_ns=stops)
        for seen, commanded, each, stops in zip(found, flat_out, each_ns, stops_ns, strict=True)
    ]
    return [whole[at :: len(sizes)] for at in range(len(sizes))]


def plans(*, quick: bool) -> tuple[ScalingPlan, ...]:
    """Return what is looked at."""
    if quick:
        return tuple(ScalingPlan(n, PEOPLE[:1], PER_S, 0.2, 0.3, 1, 500) for n in QUICK_SIZES)
    return tuple(ScalingPlan(n, PEOPLE, PER_S, 1.0, 2.0, 4, 4_000) for n in SIZES)


def measure(recorder: BenchRecorder) -> tuple[str, list[BenchCase]]:
    """Return how it is measured, and what was seen."""
    runs = 1 if recorder.quick else RUNS
    sizes = plans(quick=recorder.quick)
    found = asyncio.run(look(sizes, runs))
    smallest = found[0]
    cases = [list(cases_of(seen, smallest)) for seen in found]
    most = found[-1]
    method = METHOD.format(
        per_s=PER_S,
        runs=runs,
        messages=MESSAGES,
        most=sizes[-1].robots,
        seen=compared(found),
        robots_share=median(s.robots_sent.cpu_s / s.robots_sent.seconds for s in most),
        people_share=median(s.people_sent[0].cpu_s / s.people_sent[0].seconds for s in most),
    )
    return method, list(chain.from_iterable(cases))


def compared(found: Sequence[Sequence[ProcessFigures]]) -> str:
    """Return in a sentence how the sizes compare."""
    small, most = found[0], found[-1]
    large = min(found, key=lambda seen: abs(seen[0].robots - 1_000))
    return SEEN.format(
        small=small[0].robots,
        large=large[0].robots,
        most=most[0].robots,
        p99=p99_ns(large) / p99_ns(small),
        own=own_p99_ns(large) / own_p99_ns(small),
        command=median(map(times_as_much, map(flat_out_us, most), map(flat_out_us, small))),
        report=median(map(times_as_much, map(each_ns, most), map(each_ns, small))),
        same=_same(small),
    )


def _same(runs: Sequence[ProcessFigures]) -> str:
    """Return how far two gateways of one size differ: what of a difference is nobody's doing."""
    if len(runs) == 1:
        return ""
    command, report = (times_as_much(of(runs[-1]), of(runs[0])) for of in (flat_out_us, each_ns))
    return SAME.format(command=command, report=report, small=runs[0].robots)


def each_ns(seen: ProcessFigures) -> list[float]:
    """Return what a message of a robot costs, in each turn."""
    return seen.each_ns


def p99_ns(runs: Sequence[ProcessFigures]) -> float:
    """Return the latency of commands, of all who command."""
    return _p99_ns(s for seen in runs for c in seen.commanded for s in c.latencies_ns)


def own_p99_ns(runs: Sequence[ProcessFigures]) -> float:
    """Return how long the gateway was at work until somebody was told."""
    return _p99_ns(s for seen in runs for c in seen.commanded for s in c.own_ns)


def _p99_ns(seconds: Iterable[list[int]]) -> float:
    return quantile(list(chain.from_iterable(seconds)), 0.99)


def flat_out_us(seen: ProcessFigures) -> list[float]:
    """Return what a command costs in each turn, less what the gateway costs anyway."""
    return [
        (flat.cpu_s - seen.quiet * flat.seconds) * 1e6 / len(flat.latencies_ns[0])
        for flat in seen.flat_out
    ]


def robot_us(seen: ProcessFigures) -> float:
    """Return what one robot costs a second: its messages, and being looked after."""
    return seen.fed_cpu_s / seen.fed_s / seen.robots * 1e6


def cases_of(
    runs: Sequence[ProcessFigures], smallest: Sequence[ProcessFigures]
) -> Iterator[BenchCase]:
    """Yield what was seen of one size."""
    name = f"{runs[0].robots} robots"
    for several in zip(*(seen.commanded for seen in runs), strict=True):
        case = case_of(
            f"{name}, {several[0].people} commanding: a command",
            [(len(second), second) for c in several for second in c.latencies_ns],
        )
        own = case_of("", [(1.0, second) for c in several for second in c.own_ns])
        refused = sum(c.refused for c in several)
        yield _crowded(case, refused=refused, own_p50_us=own.p50_us, own_p99_us=own.p99_us)
    flat = [stretch for seen in runs for stretch in seen.flat_out]
    case = case_of(
        f"{name}: a command, flat out",
        [(len(f.latencies_ns[0]) / f.seconds, f.latencies_ns[0]) for f in flat],
    )
    yield _crowded(case, cpu_us=round(median(chain.from_iterable(map(flat_out_us, runs))), 1))
    each = [(1e9 / median(seen.each_ns), seen.each_ns) for seen in runs]
    case = case_of(f"{name}: a report", each)
    more = runs[0].robots - smallest[0].robots
    rss = median(s.rss_bytes for s in runs) - median(s.rss_bytes for s in smallest)
    yield _crowded(
        case,
        cpu_us=round(median(map(robot_us, runs)), 1),
        start_s=round(median(seen.start_s for seen in runs), 2),
        bytes_each=round(rss / more) if more else None,
    )
    stops = [(1e9 / median(seen.stops_ns), seen.stops_ns) for seen in runs]
    yield case_of(f"{name}: stop", stops)


def _crowded(case: BenchCase, **more: float | None) -> ScalingCase:
    return ScalingCase(**(msgspec.structs.asdict(case) | more))
