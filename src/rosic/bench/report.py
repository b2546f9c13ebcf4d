"""What a bench reports: on which machine, how, at which pace, and what was seen."""

from __future__ import annotations

import csv
import io
import os
import platform
import sqlite3
from math import ceil, expm1, log, sqrt
from pathlib import Path
from statistics import NormalDist, median, stdev
from typing import TYPE_CHECKING, Final

import msgspec

from rosic import __version__

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

SHORT_US = 100.0  # below, a table shows nanoseconds
MOST_SAMPLES: Final = 1_000
"""So many times of a case are kept for a chart, evenly chosen, in the order in which they came."""
TWO_RUNS: Final = 2
FEW_T: Final = (63.657, 9.925, 5.841, 4.604, 4.032)
"""Student's t at 99.5 % for one to five degrees of freedom."""
MOST_DOUBT: Final = log(100.0)
ROUNDING: Final = 1e-9
"""So much of a rank is the rounding of a share."""


class BenchCase(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One measured case; the median of its runs.

    Attributes:
        rate_per_s, p50_us, p90_us, p99_us, max_us: Of what, the report's method says.
        pace_us: What the calibration loop took beside it: see `rosic.bench.recorder`.
        spread: How far its runs lay apart, each beside its own pace: half of what is between the
            least and the greatest p50, as a share of the middle one. Left out for a single run.
        doubt: By which share the mean of its runs may be off, at 99 %: see `doubt_of`.
        permitted_share: Of what a platform permits, how much was used; left out elsewhere.
        bytes_each: Memory of each of many, where that is what a case is about; else not shown.
        cost_m: What a choice costs, where that is what a case is about; else not shown.
        lost_share: Of what was sent, how much did not come, where that is asked; else not shown.
        processor_us: What a server needs for each, where that is asked; else not shown.
        samples_us: Single times, for a chart; `MOST_SAMPLES` at most.
    """

    name: str
    rate_per_s: float
    p50_us: float
    p99_us: float
    p90_us: float | None = None
    max_us: float | None = None
    pace_us: float | None = None
    spread: float | None = None
    doubt: float | None = None
    permitted_share: float | msgspec.UnsetType = msgspec.UNSET
    bytes_each: float | None = None
    cost_m: float | None = None
    lost_share: float | None = None
    processor_us: float | None = None
    samples_us: tuple[float, ...] = ()

    def beside(self) -> Iterator[str]:
        """Yield what a table says besides rate and times."""
        if self.permitted_share is not msgspec.UNSET:
            yield f"{self.permitted_share:>6.1%} of what is permitted"
        if self.bytes_each is not None:
            yield f"{self.bytes_each:.0f} bytes each"
        if self.cost_m is not None:
            yield f"costs {self.cost_m:.2f} m a pair"
        if self.lost_share is not None:
            yield f"{self.lost_share:>6.1%} lost"
        if self.processor_us is not None:
            yield f"processor {self.processor_us:.0f} us each"


class BenchTable(msgspec.Struct, frozen=True, kw_only=True):
    """What is no rate and no times: a table with a title.

    Attributes:
        columns: With their units.
        rows: As many cells each as there are columns.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str | float | None, ...], ...]


class ChartSeries(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Values that belong together in a chart.

    Attributes:
        x: Where they stand; numbers, or the names of bars. Left out for a histogram.
        y: The values; those that are counted, for a histogram.
        error: So much the value may be off, up and down; for bars.
    """

    name: str
    y: tuple[float, ...]
    x: tuple[str | float, ...] = ()
    error: tuple[float, ...] = ()


class Chart(msgspec.Struct, frozen=True, kw_only=True):
    """A chart, as numbers: `rosic.bench.charts` draws it.

    Attributes:
        name: What its file is called, without an ending.
        kind: ``bars``, ``histogram`` or ``lines``.
        x, y: What the axes show, with units.
    """

    name: str
    title: str
    kind: str
    x: str
    y: str
    series: tuple[ChartSeries, ...]


class BenchRatio(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Two figures of one run, one as a multiple of the other: what hours and machines leave alone.

    Attributes:
        name: By which a budget knows it.
        value: How many times the first is the second.
        spread: How far it lay apart in single turns, as a share of itself; see `BenchCase.spread`.
        of: What is divided by what, as a sentence.
    """

    name: str
    value: float
    of: str
    spread: float | None = None


class BenchReport(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Everything one bench saw.

    Attributes:
        findings: What follows from the cases, beside what was promised; each a sentence.
        failures: What must hold and did not; each a sentence. The cases are shown all the same.
        bench, version, versions, started, took_s, pace_us: Which bench, of which ROSIC, beside
            which Python, system and SQLite, when (ISO 8601, UTC), how long, and what the
            calibration loop took meanwhile.
        command: By which it was asked for, in a report of many.
    """

    machine: str
    method: str
    cases: tuple[BenchCase, ...]
    findings: tuple[str, ...] = ()
    failures: tuple[str, ...] = ()
    tables: tuple[BenchTable, ...] = ()
    charts: tuple[Chart, ...] = ()
    ratios: tuple[BenchRatio, ...] = ()
    bench: str = ""
    version: str = ""
    versions: str = ""
    started: str = ""
    took_s: float = 0.0
    pace_us: float = 0.0
    command: str = ""


def machine() -> str:
    """Return what this was measured on."""
    return f"{_processor()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def versions() -> str:
    """Return the versions of what a figure depends on."""
    system = f"{platform.system()} {platform.release()}"
    return f"ROSIC {__version__}, {system}, SQLite {sqlite3.sqlite_version}"


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def case_of(
    name: str,
    runs: Sequence[tuple[float, Sequence[float]]],
    paces_us: Sequence[float] = (),
    *,
    tails: bool = False,
) -> BenchCase:
    """Return the medians over runs; tails are of all that was seen in any of them.

    A tail's median over runs would hide what only some of them had.

    Args:
        name: Of the case.
        runs: Of each, how many a second, and the single times in nanoseconds.
        paces_us: What the calibration loop took beside each run.
        tails: With p90, the longest, and single times for a chart.
    """
    middles_us = [quantile(times, 0.50) / 1e3 for _, times in runs]
    all_ns = [each for _, times in runs for each in times]
    case = BenchCase(
        name=name,
        rate_per_s=round(median(rate for rate, _ in runs), 1),
        p50_us=round(median(middles_us), 1),
        p99_us=round(quantile(all_ns, 0.99) / 1e3, 1),
        pace_us=round(median(paces_us), 2) if paces_us else None,
        spread=spread_of(middles_us, paces_us),
        doubt=doubt_of(middles_us, paces_us),
    )
    if not tails:
        return case
    return msgspec.structs.replace(
        case,
        p90_us=round(quantile(all_ns, 0.90) / 1e3, 1),
        max_us=round(max(all_ns) / 1e3, 1),
        samples_us=samples_us(all_ns),
    )


def samples_us(times_ns: Sequence[float]) -> tuple[float, ...]:
    """Return `MOST_SAMPLES` of the times at most, in order, in microseconds."""
    step = max(1, -(-len(times_ns) // MOST_SAMPLES))
    return tuple(round(each / 1e3, 1) for each in times_ns[::step])


def doubt_of(values: Sequence[float], paces_us: Sequence[float] = ()) -> float | None:
    """Return by which share the mean of runs, each beside its own pace, may be off, at 99 %.

    Student's t of the logarithms, so that few runs are little known and many are known well;
    nothing for a single run.
    """
    logs = [log(value) for value in _paced(values, paces_us) if value]
    if len(logs) < TWO_RUNS:
        return None
    half = _student_t(len(logs) - 1) * stdev(logs) / sqrt(len(logs))
    return round(expm1(min(MOST_DOUBT, half)), 4)


def _student_t(freedom: int) -> float:
    """Return the quantile of 99.5 % of Student's t (Cornish and Fisher, from six on)."""
    if freedom <= len(FEW_T):
        return FEW_T[freedom - 1]
    z = NormalDist().inv_cdf(0.995)
    more = (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
    return z + (z**3 + z) / (4 * freedom) + more


def spread_of(values: Sequence[float], paces_us: Sequence[float] = ()) -> float | None:
    """Return how far values lay apart, each beside its own pace; nothing for a single one."""
    paced = _paced(values, paces_us)
    if len(paced) < TWO_RUNS or not (middle := median(paced)):
        return None
    return round((max(paced) - min(paced)) / 2 / middle, 4)


def _paced(values: Sequence[float], paces_us: Sequence[float]) -> Sequence[float]:
    if not paces_us:
        return values
    return [value / pace for value, pace in zip(values, paces_us, strict=True)]


def quantile(values: Sequence[float], share: float) -> float:
    """Return the least value that a share of the values does not exceed (nearest rank)."""
    ranked = sorted(values)
    rank = ceil(share * len(ranked) - ROUNDING)
    return float(ranked[min(len(ranked), max(1, rank)) - 1])


# ---- as text, JSON and CSV ----


def as_json(report: BenchReport) -> str:
    """Return one JSON object."""
    return msgspec.json.encode(report).decode()


def case_table(report: BenchReport) -> BenchTable:
    """Return the cases as a table: what none of them has is no column."""
    told = ("rate_per_s", "p50_us", "p90_us", "p99_us", "max_us", "pace_us", "spread")
    more = ("permitted_share", "bytes_each", "cost_m", "lost_share", "processor_us")
    columns = [
        name
        for name in (*told, *more)
        if any(_value(case, name) is not None for case in report.cases)
    ]
    rows = tuple((case.name, *(_value(case, name) for name in columns)) for case in report.cases)
    return BenchTable(title="Cases", columns=("case", *columns), rows=rows)


def ratio_table(report: BenchReport) -> BenchTable:
    """Return the ratios as a table."""
    rows = tuple((one.name, one.value, one.spread, one.of) for one in report.ratios)
    return BenchTable(title="Ratios", columns=("ratio", "value", "spread", "of"), rows=rows)


def tables_of(report: BenchReport) -> tuple[BenchTable, ...]:
    """Return everything of a report that is a table and has rows."""
    every = (case_table(report), ratio_table(report), *report.tables)
    return tuple(table for table in every if table.rows)


def as_csv(report: BenchReport) -> str:
    """Return every table, each below its title, with an empty line between them."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    for number, table in enumerate(tables_of(report)):
        if number:
            text.write("\n")
        rows.writerow([table.title])
        rows.writerow(table.columns)
        rows.writerows(table.rows)
    return text.getvalue()


def as_text(report: BenchReport) -> str:
    """Return tables for people; failures are no part of it."""
    width = max((len(case.name) for case in report.cases), default=0)
    lines = [report.machine, *([report.versions] if report.versions else []), report.method]
    if report.pace_us:
        lines.append(f"Pace: a calibration loop took {report.pace_us / 1e3:.2f} ms meanwhile.")
    lines += [""] if report.cases else []
    lines += [_case_line(case, width) for case in report.cases]
    for table in tables_of(report)[1 if report.cases else 0 :]:
        lines += ["", f"{table.title}:", *table_lines(table)]
    return "\n".join([*lines, *([""] if report.findings else []), *report.findings])


def _case_line(case: BenchCase, width: int) -> str:
    paced = case.pace_us is not None and case.spread is not None
    return "   ".join(
        (
            f"{case.name:<{width}}  {case.rate_per_s:>10.0f} /s",
            f"p50 {_us(case.p50_us)} us",
            *([f"p90 {_us(case.p90_us)} us"] if case.p90_us is not None else []),
            f"p99 {_us(case.p99_us)} us",
            *([f"max {_us(case.max_us)} us"] if case.max_us is not None else []),
            *([f"spread {case.spread:.0%}"] if paced else []),
            *case.beside(),
        )
    )


def table_lines(table: BenchTable) -> list[str]:
    """Return a table as lines, columns below each other."""
    cells = [table.columns, *(tuple(map(_cell, row)) for row in table.rows)]
    widths = [max(len(row[at]) for row in cells) for at in range(len(table.columns))]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in cells
    ]


def _cell(value: str | float | None) -> str:
    if value is None:
        return ""
    return value if isinstance(value, str) else f"{value:.4g}" if value % 1 else f"{value:.0f}"


def _value(case: BenchCase, name: str) -> float | None:
    found = getattr(case, name)
    return None if found is msgspec.UNSET else found


def _us(value: float) -> str:
    return f"{value:>9.3f}" if value < SHORT_US else f"{value:>9.1f}"
