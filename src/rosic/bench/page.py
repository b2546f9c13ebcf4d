"""All that was measured: a page of HTML that needs nothing else, and Markdown for docs."""

from __future__ import annotations

import re
from base64 import b64encode
from functools import lru_cache
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Final

from rosic.bench.charts import drawn
from rosic.bench.comparison import asked, in_sum, judged
from rosic.bench.report import tables_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rosic.bench.report import BenchReport, BenchTable, Chart

STYLE: Final = files("rosic.bench").joinpath("page.css").read_text(encoding="utf-8")
MARKS: Final = re.compile(r"[\\`*_|<>\[\]]")
SHORT: Final = 1e4  # below, a number has four digits that count
TITLE: Final = "ROSIC, measured"
PACED: Final = (
    "Times and rates hold for this machine in that hour. What can be compared with another hour or "
    "machine are ratios, and times as a multiple of the pace: what a calibration loop of fixed "
    "work took beside each case."
)


WORDS: Final = {
    "rate_per_s": "a second",
    "p50_us": "p50, us",
    "p90_us": "p90, us",
    "p99_us": "p99, us",
    "max_us": "longest, us",
    "pace_us": "pace, us",
    "permitted_share": "share of what is permitted",
    "bytes_each": "bytes each",
    "cost_m": "cost, m",
    "lost_share": "share lost",
    "processor_us": "processor, us each",
}
"""Of columns that are named as fields elsewhere."""


def as_html(reports: Sequence[BenchReport]) -> str:
    """Return the page.

    Raises:
        ConfigurationError: There are charts, and matplotlib is not installed.
    """
    return "".join(_page(reports))


def _page(reports: Sequence[BenchReport]) -> Iterator[str]:
    yield f"<!doctype html><html lang=en><meta charset=utf-8><title>{TITLE}</title>"
    yield "<meta name=viewport content='width=device-width,initial-scale=1'>"
    yield f"<style>{STYLE}</style><h1>{TITLE}</h1>"
    if reports:
        first = reports[0]
        yield f"<p>{escape(_where(first))}</p>"
    yield f"<p class=faint>{PACED}</p><nav>"
    for report in reports:
        yield f"<a href='#{escape(report.bench)}'>{escape(report.bench)}</a>"
    yield "</nav>"
    table = judged(reports, asked(reports))
    yield f"<h3>Promised</h3><p>{escape(in_sum(table))}</p>"
    yield from _table(table)
    for report in reports:
        yield from _section(report, _elsewhere(report, reports[0]))


def _where(report: BenchReport) -> str:
    """Say on which machine something was measured, and of which versions."""
    return f"{report.machine}. {report.versions}."


def _elsewhere(report: BenchReport, first: BenchReport) -> str:
    """Say where something was measured, if that is not where the page says; else nothing."""
    where = _where(report)
    return "" if where == _where(first) else where


def _section(report: BenchReport, elsewhere: str) -> Iterator[str]:
    yield f"<h2 id='{escape(report.bench)}'>{escape(report.bench)}</h2>"
    command = report.command or f"rosic bench {report.bench}"
    yield f"<p>{escape(report.method)}</p><p class=faint><code>{escape(command)}</code>, "
    yield f"{report.took_s:.0f} s, {escape(report.started)}; "
    yield f"pace {report.pace_us / 1e3:.2f} ms. {escape(elsewhere)}</p>"
    for failure in report.failures:
        yield f"<p class=failed>{escape(failure)}</p>"
    for finding in report.findings:
        if finding not in report.failures:
            yield f"<p>{escape(finding)}</p>"
    for chart in report.charts:
        yield f"<img alt='{escape(chart.title)}' src='data:image/svg+xml;base64,{_picture(chart)}'>"
    for table in tables_of(report):
        yield f"<h3>{escape(table.title)}</h3>"
        yield from _table(table)


@lru_cache(maxsize=256)
def _picture(chart: Chart) -> str:
    """Return a chart; the page is written after each bench, and each chart is drawn once."""
    return b64encode(drawn(chart, "svg")).decode()


def _table(table: BenchTable) -> Iterator[str]:
    numbers = [
        all(row[at] is None or not isinstance(row[at], str) for row in table.rows)
        for at in range(len(table.columns))
    ]
    marks = [" class=n" if number else "" for number in numbers]
    yield "<div class=wide><table><thead><tr>"
    for column, mark in zip(table.columns, marks, strict=True):
        yield f"<th{mark}>{escape(WORDS.get(column, column))}</th>"
    yield "</tr></thead><tbody>"
    for row in table.rows:
        yield "<tr>"
        for value, mark in zip(row, marks, strict=True):
            yield f"<td{_verdict(value) or mark}>{escape(_cell(value))}</td>"
        yield "</tr>"
    yield "</tbody></table></div>"


def _verdict(value: object) -> str:
    return f" class={value}" if value in {"kept", "broken"} else ""


def _cell(value: str | float | None) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    return f"{value:,.4g}" if abs(value) < SHORT else f"{value:,.0f}"


# ---- the same as Markdown ----


def as_markdown(reports: Sequence[BenchReport]) -> str:
    """Return the page as Markdown; its charts are the files that lie beside it."""
    return "\n".join(_lines(reports)) + "\n"


def _lines(reports: Sequence[BenchReport]) -> Iterator[str]:
    yield f"# {TITLE}"
    where = _where(reports[0]) if reports else ""
    table = judged(reports, asked(reports))
    yield from ("", _marked(where), "", PACED, "", "## Promised", "", in_sum(table), "")
    yield from _rows(table)
    for report in reports:
        yield from ("", f"## {report.bench}", "", _marked(report.method), "")
        yield from _made(report)
        if elsewhere := _elsewhere(report, reports[0]):
            yield from ("", _marked(elsewhere))
        yield from _seen(report)


def _made(report: BenchReport) -> Iterator[str]:
    command = report.command or f"rosic bench {report.bench}"
    pace = f"pace {report.pace_us / 1e3:.2f} ms"
    yield f"`{command}`, {report.took_s:.0f} s, {report.started}; {pace}."


def _seen(report: BenchReport) -> Iterator[str]:
    for failure in report.failures:
        yield from ("", f"**{_marked(failure)}**")
    for finding in report.findings:
        if finding not in report.failures:
            yield from ("", _marked(finding))
    for chart in report.charts:
        yield from ("", f"![{_marked(chart.title)}]({chart.name}.svg)")
    for each in tables_of(report):
        yield from ("", f"### {_marked(each.title)}", "", *_rows(each))


def _rows(table: BenchTable) -> Iterator[str]:
    yield _row(WORDS.get(column, column) for column in table.columns)
    yield _row("---" for _ in table.columns)
    for row in table.rows:
        yield _row(map(_cell, row))


def _row(cells: Iterable[str]) -> str:
    return "| " + " | ".join(map(_marked, cells)) + " |"


def _marked(text: str) -> str:
    """Return a text in which nothing is a mark of Markdown."""
    return MARKS.sub(r"\\\g<0>", text)
