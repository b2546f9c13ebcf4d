"""A report as files: CSV, a workbook, charts."""

from __future__ import annotations

import os
from contextlib import suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from rosic.bench.charts import drawn
from rosic.bench.report import as_csv, tables_of
from rosic.container.export import WorkbookSheet, as_workbook
from rosic.errors import ConfigurationError, how_to_install

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from rosic.bench.report import BenchReport, BenchTable

NO_WORKBOOK: Final = "A workbook needs openpyxl, which is not installed."
CHART_KINDS: Final = ("png", "svg")
WIDEST: Final = 60


def require_workbooks() -> None:
    """Make sure that a workbook can be written.

    Raises:
        ConfigurationError: The extra is not installed; says how to.
    """
    if find_spec("openpyxl") is None:
        raise ConfigurationError(NO_WORKBOOK, hint=f"Run: {how_to_install('bench')}")


def as_xlsx(tables: Sequence[BenchTable]) -> bytes:
    """Return a workbook with a sheet for each table; texts stay texts, none is a formula.

    Raises:
        ConfigurationError: openpyxl is not installed.
    """
    return as_workbook(
        WorkbookSheet(
            f"{number} {table.title}" if number > 1 else table.title,
            {name: _width(table, at) for at, name in enumerate(table.columns)},
            table.rows,
        )
        for number, table in enumerate(tables, start=1)
    )


def _width(table: BenchTable, column: int) -> int:
    """Return how wide a column is, in characters."""
    cells = (table.columns[column], *(str(row[column]) for row in table.rows))
    return min(max(map(len, cells)) + 2, WIDEST)


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


def make_folder(folder: Path) -> None:
    """Make a folder, and those above it, unless it is there.

    Raises:
        ConfigurationError: It cannot be made: there is a file of that name.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as trouble:
        told = f"{folder} cannot be made: {trouble.strerror}."
        raise ConfigurationError(told) from trouble


def require_file(path: Path) -> None:
    """Make sure that a file can be where it shall be.

    Raises:
        ConfigurationError: Its folder is not there, or it is a folder itself.
    """
    if path.is_dir():
        raise ConfigurationError(f"{path} cannot be written: it is a folder.")
    if not path.parent.is_dir():
        raise ConfigurationError(f"{path} cannot be written: there is no folder {path.parent}.")


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
    make_folder(folder)
    written: list[Path] = []
    for chart in report.charts:
        for kind in CHART_KINDS:
            path = folder / f"{chart.name}.{kind}"
            write(path, drawn(chart, kind))
            written.append(path)
    return written
