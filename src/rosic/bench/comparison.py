"""Reports of different hours beside each other, and ratios beside what was promised of them.

What is compared is a time, and the time as a multiple of its pace: a processor at work follows the
pace, while a network, a disk and a sleep do not. Of both the one counts that says less, and where
they contradict each other neither does. It is noise up to what runs leave in doubt, in both reports
together, and `LEAST_NOISE`.
"""

from __future__ import annotations

import re
import tomllib
from importlib.resources import files
from math import exp, log
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.bench.report import BenchReport, BenchTable
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rosic.bench.report import BenchCase

LEAST_NOISE: Final = 0.05
ONE_RUN: Final = 0.30
"""So far a case may lie off of which one run was measured: nobody knows how far it does."""
FASTER: Final = "faster"
SLOWER: Final = "slower"
NOISE: Final = "noise"
GONE: Final = "only in one"
BUDGETS: Final = "budgets.toml"
FILE_NAME: Final = re.compile(r"[a-z0-9][a-z0-9_-]{0,79}")
NO_REPORT: Final = "{path} is no report of rosic bench: {why}"


class CaseChange(NamedTuple):
    """How a case of one report differs from that of another.

    Attributes:
        times: How many times as long it takes as in the old one, as far as that is certain: by the
            clock or beside the pace.
        noise: A difference up to this factor says nothing.
        verdict: ``faster``, ``slower`` or ``noise``; else that it is in one of them alone.
    """

    bench: str
    case: str
    times: float | None
    noise: float | None
    verdict: str


class Budget(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What is promised of a ratio.

    Attributes:
        why: What it is for, and where it was promised.
    """

    bench: str
    ratio: str
    why: str
    at_most: float | None = None
    at_least: float | None = None

    def holds(self, value: float) -> bool:
        """Tell whether a value keeps what was promised."""
        above = self.at_most is None or value <= self.at_most
        return above and (self.at_least is None or value >= self.at_least)

    def bound(self) -> str:
        """Return what was promised, for people."""
        if self.at_most is not None:
            return f"at most {self.at_most:g}"
        return f"at least {self.at_least:g}"


def read_reports(path: Path) -> list[BenchReport]:
    """Return the reports in a file: of one bench, or of ``rosic bench report``.

    Raises:
        ConfigurationError: It is no such file.
    """
    try:
        content = path.read_bytes()
        if content.lstrip()[:1] == b"{":
            content = b"[" + content + b"]"
        found = msgspec.json.decode(content, type=list[BenchReport])
    except OSError as trouble:
        raise ConfigurationError(f"{path} cannot be read: {trouble.strerror}.") from trouble
    except msgspec.MsgspecError as trouble:
        raise ConfigurationError(NO_REPORT.format(path=path, why=trouble)) from trouble
    for name in _file_names(found):
        if not FILE_NAME.fullmatch(name):
            raise ConfigurationError(NO_REPORT.format(path=path, why=f"no name: {name!r}"))
    return found


def _file_names(reports: Sequence[BenchReport]) -> Iterator[str]:
    """Yield what files are called by that are written of reports."""
    for report in reports:
        yield report.bench
        yield from (chart.name for chart in report.charts)


def changes(old: Sequence[BenchReport], new: Sequence[BenchReport]) -> list[CaseChange]:
    """Return how each case of two files differs, in the order of the new one."""
    before, after = dict(_cases(old)), dict(_cases(new))
    found = [_change(key, before.get(key), case) for key, case in after.items()]
    return found + [CaseChange(*key, None, None, GONE) for key in before if key not in after]


def _cases(reports: Sequence[BenchReport]) -> Iterator[tuple[tuple[str, str], BenchCase]]:
    for report in reports:
        for case in report.cases:
            yield (report.bench, case.name), case


def _change(key: tuple[str, str], old: BenchCase | None, new: BenchCase) -> CaseChange:
    if old is None or not (old.p50_us and old.pace_us and new.p50_us and new.pace_us):
        return CaseChange(*key, None, None, GONE)
    doubts = sum(ONE_RUN if one.doubt is None else one.doubt for one in (old, new))
    noise = 1 + doubts + LEAST_NOISE
    times = _certain(new.p50_us / old.p50_us, old.pace_us / new.pace_us)
    if abs(log(times)) <= log(noise):
        return CaseChange(*key, times, noise, NOISE)
    return CaseChange(*key, times, noise, SLOWER if times > 1 else FASTER)


def _certain(longer: float, faster: float) -> float:
    """Return how many times as long something takes whether or not it follows the pace.

    Args:
        longer: By the clock.
        faster: How many times as fast the machine was.
    """
    paced = longer * faster
    if log(longer) * log(paced) <= 0:
        return 1.0
    return min(longer, paced, key=lambda times: abs(log(times)))


def change_table(found: Sequence[CaseChange]) -> BenchTable:
    """Return what changed as a table."""
    rows = tuple(
        (
            one.bench,
            one.case,
            None if one.times is None else round(one.times, 3),
            None if one.noise is None else round(one.noise, 3),
            one.verdict,
        )
        for one in found
    )
    columns = ("bench", "case", "times as long", "noise up to", "verdict")
    return BenchTable(title="New beside old", columns=columns, rows=rows)


def typical(found: Sequence[CaseChange]) -> float | None:
    """Return how many times as long the cases take together: their geometric mean."""
    logs = [log(one.times) for one in found if one.times is not None]
    return exp(sum(logs) / len(logs)) if logs else None


# ---- budgets ----


def budgets() -> tuple[Budget, ...]:
    """Return what is promised, from the file that ships with ROSIC."""
    text = files("rosic.bench").joinpath(BUDGETS).read_text(encoding="utf-8")
    return msgspec.convert(tomllib.loads(text)["budget"], tuple[Budget, ...])


def asked(reports: Sequence[BenchReport]) -> tuple[Budget, ...]:
    """Return what is promised of the benches of a report."""
    benches = {report.bench for report in reports}
    return tuple(one for one in budgets() if one.bench in benches)


def judged(reports: Sequence[BenchReport], promised: Sequence[Budget]) -> BenchTable:
    """Return each budget beside what was measured; what was not is said to be so."""
    seen = _ratios(reports)
    rows = tuple(
        (one.bench, one.ratio, one.bound(), value, _verdict(one, value), one.why)
        for one in promised
        for value in (_worst(one, seen.get((one.bench, one.ratio), ())),)
    )
    columns = ("bench", "ratio", "promised", "measured", "verdict", "why")
    return BenchTable(title="Budgets", columns=columns, rows=rows)


KEPT: Final = "kept"
BROKEN: Final = "broken"
UNSEEN: Final = "not measured"


def is_broken(table: BenchTable) -> bool:
    """Whether something of `judged` was not kept."""
    return any(BROKEN in row for row in table.rows)


def in_sum(table: BenchTable) -> str:
    """Return in a sentence how many of the budgets of `judged` are kept."""
    at = table.columns.index("verdict")
    verdicts = [row[at] for row in table.rows]
    told = ", ".join(f"{verdicts.count(one)} {one}" for one in (KEPT, BROKEN, UNSEEN))
    return f"Of {len(verdicts)} budgets: {told}."


def _verdict(budget: Budget, value: float | None) -> str:
    if value is None:
        return UNSEEN
    return KEPT if budget.holds(value) else BROKEN


def _ratios(reports: Sequence[BenchReport]) -> Mapping[tuple[str, str], list[float]]:
    found: dict[tuple[str, str], list[float]] = {}
    for report in reports:
        for ratio in report.ratios:
            found.setdefault((report.bench, ratio.name), []).append(ratio.value)
    return found


def _worst(budget: Budget, values: Sequence[float]) -> float | None:
    """Return what broke a promise, of what several reports saw; else what one of them saw."""
    return next((each for each in values if not budget.holds(each)), values[-1] if values else None)
