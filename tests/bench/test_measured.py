"""The report in the docs is what its numbers say, and no more is claimed of it."""

from __future__ import annotations

from pathlib import Path

from rosic.bench.command import BENCHES
from rosic.bench.comparison import read_reports
from rosic.bench.page import as_markdown

MEASURED = Path(__file__).parents[2] / "docs" / "measured"
AGAIN = "run: rosic bench report --from docs/measured/report.json --out docs/measured"


def test_the_page_in_the_docs_is_written_of_its_numbers() -> None:
    reports = read_reports(MEASURED / "report.json")
    assert (MEASURED / "report.md").read_text(encoding="utf-8") == as_markdown(reports), AGAIN


def test_each_chart_of_the_page_lies_beside_it() -> None:
    charts = {
        chart.name for each in read_reports(MEASURED / "report.json") for chart in each.charts
    }
    assert charts == {path.stem for path in MEASURED.glob("*.svg")}


def test_every_bench_is_on_the_page_and_a_whole_run() -> None:
    reports = {each.bench: each for each in read_reports(MEASURED / "report.json")}
    assert set(reports) == {name for name, entry in BENCHES.items() if entry.in_report}
    assert not [name for name, each in reports.items() if "--quick" in each.command]
