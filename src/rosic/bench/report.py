"""What a bench reports: on which machine, how, and what was seen."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

SHORT_US = 100.0  # below, a table shows nanoseconds


class BenchCase(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One measured case; the median of its runs.

    Attributes:
        rate_per_s, p50_us, p99_us: Of what, the report's method says.
        permitted_share: Of what a platform permits, how much was used; left out elsewhere.
        bytes_each: Memory of each of many, where that is what a case is about; else not shown.
        cost_m: What a choice costs, where that is what a case is about; else not shown.
        lost_share: Of what was sent, how much did not come, where that is asked; else not shown.
        processor_us: What a server needs for each, where that is asked; else not shown.
    """

    name: str
    rate_per_s: float
    p50_us: float
    p99_us: float
    permitted_share: float | msgspec.UnsetType = msgspec.UNSET
    bytes_each: float | None = None
    cost_m: float | None = None
    lost_share: float | None = None
    processor_us: float | None = None

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


class BenchReport(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True):
    """Everything one bench saw.

    Attributes:
        findings: What follows from the cases, beside what was promised; each a sentence.
        failures: What must hold and did not; each a sentence. The cases are shown all the same.
    """

    machine: str
    method: str
    cases: tuple[BenchCase, ...]
    findings: tuple[str, ...] = ()
    failures: tuple[str, ...] = ()


def machine() -> str:
    """Return what this was measured on."""
    return f"{_processor()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def case_of(name: str, runs: Sequence[tuple[float, Sequence[float]]]) -> BenchCase:
    """Return the medians over runs of (orders per second, latencies in nanoseconds)."""
    return BenchCase(
        name=name,
        rate_per_s=round(median(rate for rate, _ in runs), 1),
        p50_us=round(median(quantile(times, 0.50) for _, times in runs) / 1e3, 1),
        p99_us=round(median(quantile(times, 0.99) for _, times in runs) / 1e3, 1),
    )


def quantile(values: Sequence[float], share: float) -> float:
    """Return the value below which a share of the values lies (nearest rank)."""
    ranked = sorted(values)
    return float(ranked[min(len(ranked) - 1, int(share * len(ranked)))])


def as_json(report: BenchReport) -> str:
    """Return one JSON object."""
    return msgspec.json.encode(report).decode()


def as_text(report: BenchReport) -> str:
    """Return a table for people; failures are no part of it."""
    width = max((len(case.name) for case in report.cases), default=0)
    lines = [report.machine, report.method, ""]
    lines += [
        "   ".join(
            (
                f"{case.name:<{width}}  {case.rate_per_s:>10.0f} /s",
                f"p50 {_us(case.p50_us)} us",
                f"p99 {_us(case.p99_us)} us",
                *case.beside(),
            )
        )
        for case in report.cases
    ]
    return "\n".join([*lines, *([""] if report.findings else []), *report.findings])


def _us(value: float) -> str:
    return f"{value:>9.3f}" if value < SHORT_US else f"{value:>9.1f}"
