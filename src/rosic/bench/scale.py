"""Algorithm 11 of the paper as printed and through a gateway; then people, robots and rates.

The paper sends one message after another. What people do does not wait for the answer before, so
the last part is an open loop: a command counts from the moment at which it was due.
"""

from __future__ import annotations

import sys
import time
from itertools import chain
from statistics import mean, median
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.app import runtime
from rosic.bench.accounts import METHODS, STAND_IN, sender
from rosic.bench.bot_api_process import stand_in
from rosic.bench.hops import hop_site, network_ns, own_ns
from rosic.bench.paired_runs import waiting
from rosic.bench.report import (
    BenchRatio,
    BenchReport,
    BenchTable,
    Chart,
    ChartSeries,
    machine,
    quantile,
)
from rosic.bench.scaling_process import CommandFigures, ProcessFigures, ScalingPlan
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Skill

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.bench.accounts import MessageSender
    from rosic.bench.recorder import BenchRecorder

BATCHES: Final = (10, 50, 100, 500)
QUICK_BATCHES: Final = (10, 50)
CONTENT: Final = "Testing scalability of ROSIC"
ROBOTS: Final = (10, 100, 1_000)
PEOPLE: Final = (1, 100)
RATES_PER_S: Final = (50, 200, 800)
QUICK_ROBOTS: Final = (100,)
QUICK_PEOPLE: Final = (10,)
QUICK_RATES_PER_S: Final = (200,)
COMMANDING_S: Final = 3
PAPER: Final = {10: (15.82, 63.2), 50: (5.04, 198.5), 100: (3.04, 329.0), 500: (3.18, 314.3)}
"""Of each batch: messages a second, and mean latency in ms (section 4)."""
FEED: Final = 1_000
METHOD: Final = (
    "Algorithm 11 as printed: batches of {batches} messages, one after another. {where} The same "
    "through a whole gateway over the same network, without limits of the platform: each message "
    "is an order to a robot that acts at once, counted until its answer is at the server; its "
    "record on disk. Then an open loop, in memory: so many people command so many robots, that "
    "report once a second and live five times, at a rate that does not wait for anybody, for "
    "{seconds} s; a command counts from when it was due until its author is told that it is done."
)
PRINTED: Final = "Algorithm 11, batch of {batch}"
THROUGH: Final = "through the gateway, batch of {batch}"
OPEN: Final = "{robots} robots, {people} people, {rate}/s"
LOST: Final = "batch of {batch}: {told} of {batch} orders were answered."
BATCH_COLUMNS: Final = (
    "batch",
    "paper, messages/s",
    "paper, ms",
    "as printed, messages/s",
    "as printed, ms",
    "through the gateway, messages/s",
    "through the gateway, ms",
    "the gateway's own share of the network's time",
)
OPEN_COLUMNS: Final = (
    "robots",
    "people",
    "commands/s",
    "told of what was due",
    "refused",
    "p50, ms",
    "p99, ms",
)


class BatchRun(NamedTuple):
    """What a batch came to.

    Attributes:
        latencies_ns: Of each message.
        lasted_s: Of all of them together.
        own: Time in the gateway by time on the network, of each order; none where no gateway is.
    """

    latencies_ns: list[int]
    lasted_s: float
    own: Sequence[float] = ()

    @property
    def per_s(self) -> float:
        """Line 16 of the algorithm."""
        return len(self.latencies_ns) / self.lasted_s

    @property
    def mean_ms(self) -> float:
        """Line 17 of the algorithm."""
        return mean(self.latencies_ns) / 1e6


def measure(recorder: BenchRecorder, *, over: str = STAND_IN) -> BenchReport:
    """Measure it.

    Args:
        recorder: Hears how far it is.
        over: By what the messages of Algorithm 11 go.

    Raises:
        ConfigurationError: Something is not set or not installed, or nobody answers.
        ConnectionError: A message did not go through; what was measured is recorded.
    """
    batches = QUICK_BATCHES if recorder.quick else BATCHES
    printed = runtime.run(_printed(recorder, over, batches))
    through = runtime.run(_through(recorder, batches))
    crowds = runtime.run(_crowds(recorder))
    method = METHOD.format(
        batches=", ".join(map(str, batches)), where=METHODS[over], seconds=COMMANDING_S
    )
    failures = [
        LOST.format(batch=batch, told=len(run.latencies_ns))
        for batch, run in through.items()
        if len(run.latencies_ns) != batch
    ]
    return BenchReport(
        machine=machine(),
        method=method,
        cases=recorder.cases(tails=True),
        failures=tuple(failures),
        tables=(_batch_table(printed, through), _open_table(crowds)),
        charts=(_chart(printed, through),),
        ratios=tuple(_ratios(through)),
    )


# ---- one after another ----


async def _printed(
    recorder: BenchRecorder, over: str, batches: Sequence[int]
) -> dict[int, BatchRun]:
    found: dict[int, BatchRun] = {}
    async with sender(over) as account:
        await account.connect()
        try:
            for batch in batches:
                with recorder.turn(PRINTED.format(batch=batch)) as turn:
                    found[batch] = await batch_of(account, batch)
                    turn.saw(found[batch].per_s, found[batch].latencies_ns)
        finally:
            await account.disconnect()
    return found


async def batch_of(account: MessageSender, batch: int) -> BatchRun:
    """Send a batch, one message after another: lines 6 to 15 of Algorithm 11.

    Raises:
        ConnectionError: A message did not go through.
    """
    begun_ns = time.perf_counter_ns()
    latencies_ns: list[int] = []
    for _ in range(batch):
        began_ns = time.perf_counter_ns()
        await account.send(CONTENT)
        latencies_ns.append(time.perf_counter_ns() - began_ns)
    return BatchRun(latencies_ns, (time.perf_counter_ns() - begun_ns) / 1e9)


async def _through(recorder: BenchRecorder, batches: Sequence[int]) -> dict[int, BatchRun]:
    profile = Profile(id="omni", link=Link(kind="memory"), skills={"go": Skill(id="go")})
    found: dict[int, BatchRun] = {}
    async with stand_in() as control, hop_site(control, profile, ("omni go",)) as site:
        await site.order()  # what is loaded for the first is loaded now
        for batch in batches:
            with recorder.turn(THROUGH.format(batch=batch)) as turn:
                begun_ns = time.perf_counter_ns()
                passed = [await site.order() for _ in range(batch)]
                lasted_s = (time.perf_counter_ns() - begun_ns) / 1e9
                latencies_ns = [one["person sees"] - one["begun"] for one in passed]
                own = [own_ns(one) / network_ns(one) for one in passed]
                found[batch] = BatchRun(latencies_ns, lasted_s, own)
                turn.saw(found[batch].per_s, latencies_ns)
    return found


# ---- people, robots and rates ----


async def _crowds(recorder: BenchRecorder) -> dict[ScalingPlan, ProcessFigures]:
    robots, people, rates = (
        (QUICK_ROBOTS, QUICK_PEOPLE, QUICK_RATES_PER_S)
        if recorder.quick
        else (ROBOTS, PEOPLE, RATES_PER_S)
    )
    found: dict[ScalingPlan, ProcessFigures] = {}
    for number in robots:
        for rate in rates:
            plan = ScalingPlan(number, people, rate, 0.2, 0.3, COMMANDING_S, FEED)
            words = msgspec.json.encode(plan).decode()
            with recorder.turn(f"{number} robots, {rate}/s"):
                async with waiting(
                    sys.executable, "-m", "rosic.bench.scaling_process", words
                ) as process:
                    found[plan] = msgspec.json.decode(await process.line(), type=ProcessFigures)
            for seen in found[plan].commanded:
                name = OPEN.format(robots=number, people=seen.people, rate=rate)
                times_ns = _latencies(seen)
                told_per_s = len(times_ns) / COMMANDING_S
                recorder.keep(
                    name,
                    like=f"{number} robots, {rate}/s",
                    times_ns=times_ns,
                    rate_per_s=told_per_s,
                )
    return found


def _latencies(seen: CommandFigures) -> list[int]:
    return list(chain.from_iterable(seen.latencies_ns))


# ---- what is told ----


def _ratios(through: dict[int, BatchRun]) -> list[BenchRatio]:
    ratios = [
        BenchRatio(
            name=f"the gateway's own share, batch of {batch}",
            value=round(median(run.own), 4),
            of="the time in the gateway, by that on the network, of one order",
        )
        for batch, run in through.items()
    ]
    first, last = min(through), max(through)
    return [
        *ratios,
        BenchRatio(
            name="the largest batch beside the smallest",
            value=round(through[last].per_s / through[first].per_s, 3),
            of=f"messages a second in a batch of {last}, by those in one of {first}",
        ),
    ]


def _batch_table(printed: dict[int, BatchRun], through: dict[int, BatchRun]) -> BenchTable:
    rows = tuple(
        (
            str(batch),
            *PAPER[batch],
            round(printed[batch].per_s, 2),
            round(printed[batch].mean_ms, 1),
            round(through[batch].per_s, 2),
            round(through[batch].mean_ms, 1),
            round(median(through[batch].own), 4),
        )
        for batch in printed
    )
    return BenchTable(title="Algorithm 11", columns=BATCH_COLUMNS, rows=rows)


def _open_table(crowds: dict[ScalingPlan, ProcessFigures]) -> BenchTable:
    rows = tuple(
        (
            str(plan.robots),
            str(seen.people),
            str(plan.per_s),
            round(len(_latencies(seen)) / (plan.per_s * COMMANDING_S), 3),
            seen.refused,
            round(quantile(_latencies(seen), 0.50) / 1e6, 2),
            round(quantile(_latencies(seen), 0.99) / 1e6, 2),
        )
        for plan, figures in crowds.items()
        for seen in figures.commanded
    )
    return BenchTable(title="People, robots and rates", columns=OPEN_COLUMNS, rows=rows)


def _chart(printed: dict[int, BatchRun], through: dict[int, BatchRun]) -> Chart:
    names = tuple(map(str, printed))
    rows = (
        ("the paper", tuple(PAPER[batch][0] for batch in printed)),
        ("ROSIC, as printed", tuple(run.per_s for run in printed.values())),
        ("ROSIC, through the gateway", tuple(run.per_s for run in through.values())),
    )
    return Chart(
        name="algorithm-11",
        title="Algorithm 11: messages a second, one after another",
        kind="bars",
        x="batch, messages",
        y="messages/s",
        series=tuple(ChartSeries(name=name, x=names, y=values) for name, values in rows),
    )
