"""Algorithm 9 of the paper as printed, and then where the time of an order goes, hop by hop."""

from __future__ import annotations

import time
from contextlib import AsyncExitStack, asynccontextmanager
from datetime import datetime
from pathlib import Path
from statistics import mean, median, stdev
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from rosic.app import runtime
from rosic.bench.accounts import METHODS, STAND_IN, sender
from rosic.bench.bot_api_process import stand_in
from rosic.bench.hops import (
    HOPS,
    hop_site,
    hop_times,
    network_ns,
    own_ns,
    ros_omni,
    simulated_omni,
)
from rosic.bench.output import as_xlsx, require_workbooks, write
from rosic.bench.report import (
    BenchRatio,
    BenchReport,
    BenchTable,
    Chart,
    ChartSeries,
    machine,
    samples_us,
    spread_of,
)
from rosic.robots.ros2.client.runtime import RosRuntime
from rosic.robots.ros2.client.topics import TopicQos
from rosic.robots.ros2.messages.types import TypeRegistry
from rosic.testing.ros2.graph import RosGraph, why_missing

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Callable, Sequence

    from rosic.bench.accounts import MessageSender
    from rosic.bench.hops import HopSite
    from rosic.bench.recorder import BenchRecorder
    from rosic.testing.telegram import Control

MESSAGES: Final = 100
RUNS: Final = 10
ORDERS: Final = 30
QUICK_MESSAGES: Final = 20
QUICK_RUNS: Final = 2
QUICK_ORDERS: Final = 10
TEXT: Final = "Testing latency"
STAMP: Final = "%Y-%m-%d %H:%M:%S"
FILE_STAMP: Final = "%Y-%m-%d_%H-%M-%S"
COLUMNS: Final = ("Timestamp", "Latency (ms)")
SELF: Final = "to oneself"
SIMULATED: Final = "simulated robot"
ROS: Final = "ROS 2 robot"
STATUS: Final = "action_msgs/msg/GoalStatusArray"
GOALS: Final = "/omni/move/_action/status"
SIMULATION: Final = "rosic_sim.ros2.simulation"
PEAK_MS: Final = 250.0
METHOD: Final = (
    "Algorithm 9 as printed: {messages} messages to oneself, the client started and disconnected "
    "for each, the time of the sending alone; {runs} runs. {where} Then {orders} orders, one at a "
    "time, through a whole gateway over the same network: said at the server, given to the "
    "gateway, decided, on disk, received by the robot, acknowledged by it, and the answer at the "
    "server. Not measured: the server's own load, and the person's way to it and from it."
)
SAVED: Final = "Latency results saved to {path}"
NO_ROS: Final = "Over ROS 2 it was not measured: {why}"
PEAK: Final = "The peak of Algorithm 9 was {ms:.0f} ms; the paper's was near {paper:.0f} ms."
SHARE: Final = "{robot}: of {ms:.1f} ms at the median the gateway itself took {share:.1%}."


class LatencyRow(NamedTuple):
    """One message of Algorithm 9.

    Attributes:
        timestamp: When it was sent, local time, as the paper writes it.
    """

    timestamp: str
    latency_ms: float


def measure(
    recorder: BenchRecorder,
    *,
    over: str = STAND_IN,
    messages: int = 0,
    runs: int = 0,
    out: Path = Path(),
) -> BenchReport:
    """Measure it.

    Args:
        recorder: Hears how far it is.
        over: By what the messages of Algorithm 9 go.
        messages: How many in a run; 0: as the paper, or few of them.
        runs: How many; 0 likewise.
        out: Where a workbook of each run goes.

    Raises:
        ConfigurationError: Something is not set, not installed or not there.
        ConnectionError: A message did not go through; what was measured is recorded.
    """
    require_workbooks()
    messages = messages or (QUICK_MESSAGES if recorder.quick else MESSAGES)
    runs = runs or (QUICK_RUNS if recorder.quick else RUNS)
    orders = QUICK_ORDERS if recorder.quick else ORDERS
    seen, saved = runtime.run(_to_self(recorder, over, messages, runs, out))
    ways = {SIMULATED: runtime.run(_passed(recorder, SIMULATED, orders, runs))}
    notes: list[str] = [*saved, _peak(seen)]
    if why := why_missing():
        notes.append(NO_ROS.format(why=why))
    else:
        ways[ROS] = runtime.run(_passed(recorder, ROS, orders, runs))
    shares = {robot: _shares(passed) for robot, passed in ways.items()}
    notes += [_share_told(robot, passed) for robot, passed in ways.items()]
    return BenchReport(
        machine=machine(),
        method=METHOD.format(messages=messages, runs=runs, orders=orders, where=METHODS[over]),
        cases=recorder.cases(tails=True),
        findings=tuple(notes),
        charts=(*paper_charts(seen), _hop_chart(ways)),
        tables=(_paper_table(seen),),
        ratios=tuple(
            BenchRatio(
                name=f"the gateway's own share, {robot}",
                value=round(median(share for run in found for share in run), 4),
                spread=spread_of([median(run) for run in found]),
                of="the time in the gateway, by that on the network, of one order",
            )
            for robot, found in shares.items()
        ),
    )


# ---- Algorithm 9 ----


async def _to_self(
    recorder: BenchRecorder, over: str, messages: int, runs: int, out: Path
) -> tuple[list[list[LatencyRow]], list[str]]:
    seen: list[list[LatencyRow]] = []
    saved: list[str] = []
    async with sender(over) as account:
        for _ in range(runs):
            rows: list[LatencyRow] = []
            with recorder.turn(SELF, of=runs) as turn:
                try:
                    async for row in to_self(account, messages):
                        rows.append(row)  # noqa: PERF401 - what came before trouble counts
                finally:
                    if rows:
                        times_ns = [row.latency_ms * 1e6 for row in rows]
                        turn.saw(1e9 / mean(times_ns), times_ns)
                        saved.append(SAVED.format(path=save(rows, out)))
            seen.append(rows)
    return seen, saved


async def to_self(account: MessageSender, messages: int) -> AsyncIterator[LatencyRow]:
    """Yield what each message took: lines 12 to 16 of Algorithm 9.

    Raises:
        ConfigurationError: It cannot connect.
        ConnectionError: A message did not go through.
    """
    for _ in range(messages):
        timestamp = datetime.now().strftime(STAMP)  # noqa: DTZ005 - local time, as the paper's
        await account.connect()
        try:
            begun_ns = time.perf_counter_ns()
            await account.send(TEXT)
            took_ns = time.perf_counter_ns() - begun_ns
        finally:
            await account.disconnect()
        yield LatencyRow(timestamp, took_ns / 1e6)


def save(rows: Sequence[LatencyRow], folder: Path) -> Path:
    """Write the workbook of Algorithm 9; return where.

    Raises:
        ConfigurationError: It cannot be written.
    """
    stamp = datetime.now().strftime(FILE_STAMP)  # noqa: DTZ005 - as above
    path, number = folder / f"latency_results_{stamp}.xlsx", 1
    while path.exists():  # runs of less than a second
        number += 1
        path = folder / f"latency_results_{stamp}_{number}.xlsx"
    cells = tuple((row.timestamp, round(row.latency_ms, 3)) for row in rows)
    write(path, as_xlsx((BenchTable(title="Latency", columns=COLUMNS, rows=cells),)))
    return path


# ---- hop by hop ----


async def _passed(
    recorder: BenchRecorder, robot: str, orders: int, runs: int
) -> list[list[dict[str, int]]]:
    """Return when each order of each run passed where."""
    seen: list[list[dict[str, int]]] = []
    async with AsyncExitStack() as stack:
        control = await stack.enter_async_context(stand_in())
        opening = _ros_site(control) if robot == ROS else hop_site(control, simulated_omni())
        site = await stack.enter_async_context(opening)
        await site.order()  # what is loaded for the first is loaded now
        for _ in range(runs):
            with recorder.turn(robot, of=runs) as turn:
                found = [await site.order() for _ in range(orders)]
                times = [passed["person sees"] - passed["begun"] for passed in found]
                turn.saw(1e9 / mean(times), times)
            seen.append(found)
    for hop in HOPS:
        for found in seen:
            times = [hop_times(passed)[hop] for passed in found if hop in hop_times(passed)]
            if times:
                recorder.keep(f"{robot}: {hop}", like=robot, times_ns=times)
    return seen


@asynccontextmanager
async def _ros_site(control: Control) -> AsyncIterator[HopSite]:
    """Run a gateway with a ROS 2 node as robot, in a process of its own."""
    with TemporaryDirectory(prefix="rosic-bench-") as folder, RosGraph(Path(folder)) as graph:
        graph.start(
            *("-m", SIMULATION, "--actuations", Path(folder) / "a", "omni"),
            timeout_s=120.0,
            ends_with_input=False,
        )
        async with hop_site(control, ros_omni()) as site:
            opening = RosRuntime.open(
                TypeRegistry([STATUS]), node_name="bench", domain_id=graph.domain_id
            )
            async with await opening as node:
                qos = TopicQos(latched=True, depth=1_000)
                await node.stream(GOALS, STATUS, _goals(site), qos)
                yield site


def _goals(site: HopSite) -> Callable[[Any], None]:
    """Return what notes when the robot took a goal, as the robot's own clock says."""

    def heard(message: Any) -> None:  # noqa: ANN401 - of ROS
        for status in message.status_list:
            stamp = status.goal_info.stamp
            site.robot_took(stamp.sec * 10**9 + stamp.nanosec)

    return heard


def _shares(passed: Sequence[Sequence[dict[str, int]]]) -> list[list[float]]:
    return [[own_ns(one) / network_ns(one) for one in run] for run in passed]


# ---- what is told ----


def _peak(seen: Sequence[Sequence[LatencyRow]]) -> str:
    peak_ms = max(row.latency_ms for rows in seen for row in rows)
    return PEAK.format(ms=peak_ms, paper=PEAK_MS)


def _share_told(robot: str, passed: Sequence[Sequence[dict[str, int]]]) -> str:
    whole = [one["person sees"] - one["begun"] for run in passed for one in run]
    own = [own_ns(one) / (one["person sees"] - one["begun"]) for run in passed for one in run]
    return SHARE.format(robot=robot, ms=median(whole) / 1e6, share=median(own))


def _paper_table(seen: Sequence[Sequence[LatencyRow]]) -> BenchTable:
    """Return Figures 3 and 4 as numbers."""
    rows = tuple(
        (str(number), len(run), round(mean(ms), 2), round(_deviation(ms), 2), round(max(ms), 2))
        for number, run in enumerate(seen, start=1)
        for ms in ([row.latency_ms for row in run],)
    )
    paper = ("the paper (Figures 3 and 4)", 100, None, None, PEAK_MS)
    columns = ("run", "messages", "mean, ms", "standard deviation, ms", "peak, ms")
    return BenchTable(title="Algorithm 9", columns=columns, rows=(*rows, paper))


def _deviation(values: Sequence[float]) -> float:
    return stdev(values) if len(values) > 1 else 0.0


def paper_charts(seen: Sequence[Sequence[LatencyRow]]) -> tuple[Chart, ...]:
    """Return Figures 3 and 4 of the paper."""
    every = tuple(round(row.latency_ms, 3) for rows in seen for row in rows)
    names = tuple(str(number) for number in range(1, len(seen) + 1))
    means = tuple(mean(row.latency_ms for row in rows) for rows in seen)
    errors = tuple(_deviation([row.latency_ms for row in rows]) for rows in seen)
    return (
        Chart(
            name="figure-3-latency",
            title="Figure 3: latency of messages to oneself (Algorithm 9)",
            kind="histogram",
            x="latency, ms",
            y="messages",
            series=(ChartSeries(name="messages", y=samples_of(every)),),
        ),
        Chart(
            name="figure-4-latency-by-run",
            title="Figure 4: its mean in each run, and the standard deviation",
            kind="bars",
            x="run",
            y="latency, ms",
            series=(ChartSeries(name="mean", x=names, y=means, error=errors),),
        ),
    )


def samples_of(values_ms: Sequence[float]) -> tuple[float, ...]:
    """Return a thousand of them at most, in order."""
    return tuple(each / 1e3 for each in samples_us([value * 1e6 for value in values_ms]))


def _hop_chart(ways: dict[str, list[list[dict[str, int]]]]) -> Chart:
    """Return how long each hop takes at the median, and how far runs lie apart."""
    series: list[ChartSeries] = []
    for robot, passed in reversed(ways.items()):  # of a ROS 2 robot every hop is seen
        runs = [[hop_times(one) for one in run] for run in passed]
        hops = [hop for hop in HOPS if all(hop in one for run in runs for one in run)]
        middles = {hop: [median(one[hop] for one in run) / 1e6 for run in runs] for hop in hops}
        series.append(
            ChartSeries(
                name=robot,
                x=tuple(hop.replace(" ", "\n") for hop in hops),
                y=tuple(median(values) for values in middles.values()),
                error=tuple((max(v) - min(v)) / 2 for v in middles.values()),
            )
        )
    return Chart(
        name="hops",
        title="An order, hop by hop (median; the bar is half the range over the runs)",
        kind="bars",
        x="",
        y="time, ms",
        series=tuple(series),
    )
