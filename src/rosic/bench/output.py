"""A report as files: CSV, a workbook, charts."""

from __future__ import annotations

import io
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Final

from rosic.bench.charts import drawn
from rosic.bench.report import as_csv, tables_of
from rosic.errors import ConfigurationError, how_to_install

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rosic.bench.report import BenchReport, BenchTable

NO_WORKBOOK: Final = "A workbook needs openpyxl, which is not installed."
LONGEST_TITLE: Final = 31
"""Of a sheet: https://support.microsoft.com/office (specifications and limits of Excel)."""
CHART_KINDS: Final = ("png", "svg")
WIDEST: Final = 60


def require_workbooks() -> None:
    """Make sure that a workbook can be written.

    Raises:
        ConfigurationError: The extra is not installed; says how to.
    """
    try:
        import openpyxl  # noqa: F401, PLC0415 - an extra
    except ImportError:
        raise ConfigurationError(NO_WORKBOOK, hint=f"Run: {how_to_install('bench')}") from None


def as_xlsx(tables: Sequence[BenchTable]) -> bytes:
    """Return a workbook with a sheet for each table; texts stay texts, none is a formula.

    Raises:
        ConfigurationError: openpyxl is not installed.
    """
    require_workbooks()
    from openpyxl import Workbook  # noqa: PLC0415 - an extra, and slow to load
    from openpyxl.utils import get_column_letter  # noqa: PLC0415 - the same

    book = Workbook()
    book.remove(book.worksheets[0])
    for number, table in enumerate(tables):
        title = f"{number + 1} {table.title}" if number else table.title
        sheet = book.create_sheet(title[:LONGEST_TITLE])
        sheet.append(table.columns)
        sheet.freeze_panes = "A2"
        for at, row in enumerate(table.rows, start=2):
            for place, value in enumerate(row, start=1):
                cell = sheet.cell(at, place, value)
                if isinstance(value, str):
                    cell.data_type = "s"
        for place, column in enumerate(table.columns, start=1):
            longest = max(len(str(row[place - 1])) for row in ((column,) * place, *table.rows))
            sheet.column_dimensions[get_column_letter(place)].width = min(longest + 2, WIDEST)
    file = io.BytesIO()
    book.save(file)
    return file.getvalue()


def write(path: Path, content: bytes) -> None:
    """Write a file whole or not at all.

    Raises:
        ConfigurationError: It cannot be written: no such folder, a full disk. Whatever was there
            before is still there.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        beside.write_bytes(content)
        beside.replace(path)
    except OSError as trouble:
        with suppress(OSError):
            beside.unlink()
        told = f"{path} cannot be written: {trouble.strerror}."
        raise ConfigurationError(told) from trouble


def write_csv(report: BenchReport, path: Path) -> None:
    """Write every table of a report as CSV."""
    write(path, as_csv(report).encode())


def write_xlsx(report: BenchReport, path: Path) -> None:
    """Write every table of a report as sheets."""
    write(path, as_xlsx(tables_of(report)))


def write_charts(report: BenchReport, folder: Path) -> list[Path]:
    """Write every chart of a report as PNG and as SVG; return where.

    Raises:
        ConfigurationError: matplotlib is not installed, or a file cannot be written.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as trouble:
        told = f"{folder} cannot be made: {trouble.strerror}."
        raise ConfigurationError(told) from trouble
    written: list[Path] = []
    for chart in report.charts:
        for kind in CHART_KINDS:
            path = folder / f"{chart.name}.{kind}"
            write(path, drawn(chart, kind))
            written.append(path)
    return written
