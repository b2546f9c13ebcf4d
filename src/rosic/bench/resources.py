"""What a whole gateway uses over time, under half of the load that its platform permits.

With ``--hours`` it is a soak: every 30 s something goes wrong, and in the end it is judged whether
memory, descriptors or tasks grow, and whether any order was lost.
"""

from __future__ import annotations

import asyncio
import http.client
import re
import tempfile
import time
from itertools import pairwise
from pathlib import Path
from statistics import fmean
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.app import runtime
from rosic.bench.bot_api_process import stand_in
from rosic.bench.gateway_process import LOCAL, busy_s, free_port, gateway_process
from rosic.bench.report import (
    BenchReport,
    BenchTable,
    Chart,
    ChartSeries,
    case_of,
    machine,
    quantile,
)
from rosic.bench.soak import (
    CELL_EVERY_S,
    CELLS,
    FAULT_EVERY_S,
    FAULTS,
    MOVING,
    MOVING_EVERY_S,
    Soak,
    SoakPlace,
    await_answer,
    open_accounts,
    write_config,
)
from rosic.bench.trend import BINS, GROWS, SURE, trend_of
from rosic.core.time_units import HOUR_S

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic.bench.recorder import BenchRecorder

EVERY_S: Final = 1.0
ANSWERS_WITHIN_S: Final = 5.0
SHORT_S, QUICK_S = 60.0, 10.0
SETTLES_S: Final = 600.0
SETTLES_SHARE: Final = 0.25
JUDGED_FROM_S: Final = 300.0
"""A run that is shorter says nothing of a slope."""
MIB: Final = 1 << 20
POINTS: Final = 400
METHOD: Final = (
    "A whole gateway (rosic run) with its record on disk in a process of its own; {people} people "
    "in a chat each, over a stand-in for the Bot API in another process with Telegram's published "
    "limits. {moving} of them order simulated robots that move, every {moving_s:g} s, {cells} "
    "robots in memory every {cell_s:g} s, whatever became of the order before: half of the "
    "messages and edits that each chat is permitted, and half of those that ROSIC lets itself say "
    "in all. Sampled each second from /proc and /metrics, for {lasts:.0f} s. Rate, p50 to max: "
    "orders, and from saying one until its end is told. Robots are in process: their links count "
    "messages, no bytes, and are lost only by a standstill of it all."
)
FAULTY: Final = " Every {every:g} s, in turns: {faults}."
JUDGED: Final = (
    " After {settles:.0f} s slopes are judged: the median of those between all pairs of {bins} "
    "means (Theil, Sen), with bounds of {sure:.0%} that are wider where neighbours are alike "
    "(Hamed, Rao). A figure grows, too, whose last quarter lies above its first by more than three "
    "times what that differs within itself, and 5 %."
)
GREW: Final = "{what} grows by {trend.per_hour:.3g} an hour ({trend.low:.3g} to {trend.high:.3g})."
ROSE: Final = "{what} rose: its last quarter lies above its first."
UNSEEN: Final = "{what} was not seen, so nobody knows whether it grows."
LOST: Final = "{lost} of {placed} orders were not told how they ended."
IDLE: Final = "Only {done} of {told} orders were done: the load was none."
DONE_SHARE: Final = 0.5
TOLD: Final = (
    "{placed} orders were placed, {told} told in a reply ({done} done), {summed} in a summary, "
    "{lost} lost."
)
TOO_SHORT: Final = "Too short to judge slopes: --hours 2 does."
ENDED: Final = "The gateway ended by itself."
SAMPLE: Final = re.compile(r"^(\w+)(?:\{([^}]*)\})? (\S+)$", re.MULTILINE)
LABEL: Final = re.compile(r'(\w+)="([^"]*)"')


class ResourceSample(NamedTuple):
    """One look at a gateway.

    Attributes:
        at_s: Since the first.
        busy: Share of a processor since the look before.
        resident_mib, proportional_mib: Memory; of shared pages, all or its part. Not known: 0.
        tasks: Of the event loop.
        passed: Bytes and messages so far, by link (``telegram received bytes``).
    """

    at_s: float
    busy: float
    resident_mib: float
    proportional_mib: float
    descriptors: int
    threads: int
    tasks: int
    passed: dict[str, float]


WATCHED: Final[tuple[tuple[str, Callable[[ResourceSample], float], bool], ...]] = (
    ("processor, share", lambda one: one.busy, False),
    ("resident memory, MiB", lambda one: one.resident_mib, True),
    ("proportional memory, MiB", lambda one: one.proportional_mib, True),
    ("file descriptors", lambda one: one.descriptors, True),
    ("threads", lambda one: one.threads, False),
    ("tasks", lambda one: one.tasks, True),
)
"""What is watched, how it is read, and whether its slope is judged."""


class ResourceProbe:
    """Looks at a gateway in another process.

    Args:
        pid: Its own.
        port: On which it says its figures; 0 asks for none.

    Attributes:
        samples: Of every look that was answered.
    """

    def __init__(self, pid: int, port: int = 0) -> None:
        self._pid, self._port = pid, port
        self._begun_s = self._before_s = time.monotonic()
        self._busy_s = busy_s(pid)
        self.samples: list[ResourceSample] = []

    def look(self) -> None:
        """Look once; a gateway that does not answer in time is left out.

        Raises:
            ProcessLookupError: It has ended.
        """
        folder = Path(f"/proc/{self._pid}")
        try:
            descriptors = sum(1 for _ in (folder / "fd").iterdir())
            figures = figures_of(self._port) if self._port else {}
        except OSError:
            busy_s(self._pid)
            return
        now_s, busy = time.monotonic(), busy_s(self._pid)
        share = (busy - self._busy_s) / (now_s - self._before_s)
        self._busy_s, self._before_s = busy, now_s
        memory = memory_mib(folder / "smaps_rollup")
        threads = sum(1 for _ in (folder / "task").iterdir())
        self.samples.append(
            ResourceSample(
                now_s - self._begun_s,
                share,
                memory.get("Rss", 0.0),
                memory.get("Pss", 0.0),
                descriptors,
                threads,
                int(figures.get("rosic_loop_tasks", 0)),
                {name: value for name, value in figures.items() if " " in name},
            )
        )

    async def run(self) -> None:
        """Look each second until cancelled."""
        due_s = time.monotonic()
        while True:
            await asyncio.to_thread(self.look)
            due_s = max(due_s + EVERY_S, time.monotonic())
            await asyncio.sleep(due_s - time.monotonic())


def memory_mib(rollup: Path) -> dict[str, float]:
    """Return memory as Linux sums it up; nothing where it does not."""
    try:
        lines = rollup.read_text(encoding="ascii").splitlines()[1:]
    except OSError:
        return {}
    words = (line.split() for line in lines)
    return {first.rstrip(":"): int(kib) / 1024 for first, kib, *_ in words}


def figures_of(port: int) -> dict[str, float]:
    """Return what a gateway says of itself: what passed by link, way and unit, tasks by name.

    Raises:
        OSError: It does not answer in time.
    """
    line = http.client.HTTPConnection(LOCAL, port, timeout=ANSWERS_WITHIN_S)
    try:
        line.request("GET", "/metrics")
        text = line.getresponse().read().decode()
    except http.client.HTTPException as trouble:
        raise OSError("it broke off") from trouble
    finally:
        line.close()
    found: dict[str, float] = {}
    for name, labels, value in SAMPLE.findall(text):
        told = dict(LABEL.findall(labels))
        if "direction" in told:
            link = told.get("messenger") or told.get("robot", "")
            unit = "bytes" if "_bytes_" in name else "messages"
            found[f"{link} {told['direction']} {unit}"] = float(value)
        elif name == "rosic_loop_tasks":
            found[name] = float(value)
    return found


# ---- the bench ----


def measure(recorder: BenchRecorder, hours: float | None = None) -> BenchReport:
    """Watch a gateway at work.

    Args:
        recorder: Is told how far it is; keeps what was seen if it is interrupted.
        hours: How long, with faults; None: shortly, without.

    Raises:
        ConfigurationError: The gateway does not start.
    """
    short_s = QUICK_S if recorder.quick else SHORT_S
    seen = ResourceRun(short_s if hours is None else hours * HOUR_S, faulty=hours is not None)
    recorder.report_by(seen.report)
    with recorder.turn("orders"):
        runtime.run(seen.run())
    return seen.report()


class ResourceRun:
    """One run, and what it has seen so far.

    Args:
        lasts_s: How long orders are given.
        faulty: Whether something goes wrong every 30 s.
    """

    def __init__(self, lasts_s: float, *, faulty: bool) -> None:
        self._lasts_s, self._faulty = lasts_s, faulty
        self._soak: Soak | None = None
        self._probe: ResourceProbe | None = None
        self._over = self._ended = False

    async def run(self) -> None:
        """Start everything, and watch."""
        with tempfile.TemporaryDirectory(prefix="rosic-bench-") as name:
            folder = Path(name)
            async with stand_in() as control:
                admin, stranger = [await control.create_user(who) for who in ("Ada", "Mallory")]
                people = await open_accounts(control)
                port = free_port()
                config = write_config(folder, control, admin, people, port)
                with gateway_process(folder, config, port) as process:
                    await await_answer(control, admin)
                    place = SoakPlace(control, admin, stranger, process.pid, port)
                    self._soak = Soak(place, people, faulty=self._faulty)
                    self._probe = ResourceProbe(process.pid, port)
                    await self._watch(self._soak, self._probe)
                    self._ended = process.poll() is not None

    async def _watch(self, soak: Soak, probe: ResourceProbe) -> None:
        watching = asyncio.create_task(probe.run())
        try:
            await soak.run(self._lasts_s)
            self._over = True
        finally:
            watching.cancel()
            await asyncio.gather(watching, return_exceptions=True)

    def report(self) -> BenchReport:
        """Return what was seen until now."""
        if self._soak is None or self._probe is None:
            return BenchReport(machine=machine(), method="It had not begun.", cases=())
        return report_of(
            self._probe.samples, self._soak, self._lasts_s, over=self._over, ended=self._ended
        )


# ---- what follows ----


def report_of(
    samples: Sequence[ResourceSample],
    soak: Soak,
    lasts_s: float,
    *,
    over: bool = True,
    ended: bool = False,
) -> BenchReport:
    """Return what follows from the samples and from what people were told.

    Args:
        samples: In the order of their times.
        soak: What was asked of the gateway.
        lasts_s: How long it was to take.
        over: It came to its end; else nobody can say what is lost.
        ended: The gateway had ended before.
    """
    orders = soak.orders
    settles_s = min(SETTLES_S, lasts_s * SETTLES_SHARE)
    later = [one for one in samples if one.at_s >= settles_s]
    judged = bool(soak.faults) and lasts_s >= JUDGED_FROM_S and len(later) >= BINS
    table, grown = resource_table(samples, later if judged else ())
    lost = orders.lost if over else 0
    told = len(orders.told_ns)
    failures = [*grown, *([ENDED] if ended else [])]
    if lost:
        failures.append(LOST.format(lost=lost, placed=orders.placed))
    if orders.done < DONE_SHARE * told:
        failures.append(IDLE.format(done=orders.done, told=told))
    findings = [
        TOLD.format(
            placed=orders.placed, told=told, done=orders.done, summed=orders.summed, lost=lost
        )
    ]
    findings += [] if judged else [TOO_SHORT]
    took_s = samples[-1].at_s if samples else lasts_s
    cases = (
        [case_of("orders", [(told / min(took_s, lasts_s), orders.told_ns)], tails=True)]
        if told
        else []
    )
    return BenchReport(
        machine=machine(),
        method=_method(soak, lasts_s, settles_s if judged else None),
        cases=tuple(cases),
        findings=tuple(findings),
        failures=tuple(failures),
        tables=(table, traffic_table(samples), *_fault_table(soak)),
        charts=charts_of(samples),
    )


def _method(soak: Soak, lasts_s: float, settles_s: float | None) -> str:
    text = METHOD.format(
        people=len(MOVING) + CELLS,
        moving=len(MOVING),
        moving_s=MOVING_EVERY_S,
        cells=CELLS,
        cell_s=CELL_EVERY_S,
        lasts=lasts_s,
    )
    if soak.faults:
        text += FAULTY.format(every=FAULT_EVERY_S, faults="; ".join(name for name, _ in FAULTS))
    if settles_s is not None:
        text += JUDGED.format(settles=settles_s, bins=BINS, sure=SURE)
    return text


def _fault_table(soak: Soak) -> tuple[BenchTable, ...]:
    rows = tuple((name, times) for name, times in soak.faults.items())
    return (BenchTable(title="Faults", columns=("what", "times"), rows=rows),) if rows else ()


def resource_table(
    samples: Sequence[ResourceSample], judged: Sequence[ResourceSample]
) -> tuple[BenchTable, list[str]]:
    """Return what was used, and a sentence for each figure that grows.

    Args:
        samples: All of them.
        judged: Those from which slopes are found; none: no slope is.
    """
    rows: list[tuple[str | float | None, ...]] = []
    failures: list[str] = []
    times_s = [one.at_s for one in judged]
    for name, value_of, has_slope in WATCHED:
        values = [value_of(one) for one in samples]
        if not any(values):
            if judged and has_slope:
                failures.append(UNSEEN.format(what=name))
            continue
        row: list[str | float | None] = [name, *(_rounded(one) for one in _summary(values))]
        if judged:
            trend = trend_of(times_s, [value_of(one) for one in judged])
            row += [_rounded(trend.per_hour), _rounded(trend.low), _rounded(trend.high)]
            row.append(trend.verdict if has_slope else "")
            if has_slope and trend.verdict == GROWS:
                told = GREW if trend.low > 0 else ROSE  # a slope around 0 would say nothing of it
                failures.append(told.format(what=name, trend=trend))
        rows.append(tuple(row))
    columns = ("what", "at first", "mean", "p99", "max", "at last")
    slopes = ("slope an hour", "from", "to", "verdict") if judged else ()
    return BenchTable(title="Used", columns=(*columns, *slopes), rows=tuple(rows)), failures


def _summary(values: Sequence[float]) -> tuple[float, ...]:
    return values[0], fmean(values), quantile(values, 0.99), max(values), values[-1]


def _rounded(value: float) -> float:
    return round(value, 4)


def traffic_table(samples: Sequence[ResourceSample]) -> BenchTable:
    """Return what passed each messenger and robot, of which it was counted."""
    rows: list[tuple[str | float | None, ...]] = []
    if samples:
        first, last = samples[0], samples[-1]
        past_s = max(last.at_s - first.at_s, EVERY_S)
        for link in dict.fromkeys(name.split(" ")[0] for name in last.passed):
            row: list[str | float | None] = [link]
            for name in (f"{link} {way} {unit}" for unit in UNITS for way in WAYS):
                grown = last.passed.get(name, 0) - first.passed.get(name, 0)
                row.append(round(grown / past_s, 3) if name in last.passed else None)
            rows.append(tuple(row))
    columns = ("link", *(f"{unit} {way}, a second" for unit in UNITS for way in WAYS))
    return BenchTable(title="Passed", columns=columns, rows=tuple(rows))


UNITS: Final = ("messages", "bytes")
WAYS: Final = ("received", "sent")


def charts_of(samples: Sequence[ResourceSample]) -> tuple[Chart, ...]:
    """Return the samples as lines over time."""
    if len(samples) < 2:  # noqa: PLR2004 - a line has two ends
        return ()
    step = max(1, -(-len(samples) // POINTS))
    shown = samples[::step]
    watched = {name: value_of for name, value_of, _ in WATCHED}
    times = tuple(round(one.at_s / 60, 3) for one in shown)

    def lines(name: str, title: str, y: str, *which: str) -> Chart:
        series = tuple(
            ChartSeries(name=one.partition(",")[0], x=times, y=tuple(map(watched[one], shown)))
            for one in which
        )
        return Chart(
            name=f"resources-{name}", title=title, kind="lines", x="minutes", y=y, series=series
        )

    memory = ("resident memory, MiB", "proportional memory, MiB")
    counts = ("file descriptors", "threads", "tasks")
    return (
        lines("processor", "Processor", "share of a processor", "processor, share"),
        lines("memory", "Memory", "MiB", *memory),
        lines("counts", "Descriptors, threads, tasks", "how many", *counts),
        _bytes_chart(shown),
    )


def _bytes_chart(shown: Sequence[ResourceSample]) -> Chart:
    """Return what passed the links that count bytes, a second, over time."""
    names = [name for name in shown[-1].passed if name.endswith("bytes")]
    series = []
    for name in names:
        pairs = list(pairwise(shown))
        rates = (
            (new.passed.get(name, 0) - old.passed.get(name, 0)) / (new.at_s - old.at_s)
            for old, new in pairs
        )
        times = tuple(round(new.at_s / 60, 3) for _, new in pairs)
        series.append(ChartSeries(name=name.removesuffix(" bytes"), x=times, y=tuple(rates)))
    return Chart(
        name="resources-bytes",
        title="What passed",
        kind="lines",
        x="minutes",
        y="bytes a second",
        series=tuple(series),
    )
