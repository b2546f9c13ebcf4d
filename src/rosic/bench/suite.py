"""``rosic bench report``: every bench, each in a process of its own, and one page of them."""

from __future__ import annotations

import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.bench.charts import require_charts
from rosic.bench.output import make_folder, require_workbooks, write, write_charts, write_xlsx
from rosic.bench.page import as_html, as_markdown
from rosic.bench.report import BenchReport, machine

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

ENDS_WITHIN_S: Final = 30.0
NOTHING: Final = "It did not measure anything: {why}"
INTERRUPTED: Final = "Interrupted: the benches after it were not run."
PAGE: Final = "report.html"
MARKDOWN: Final = "report.md"
NUMBERS: Final = "report.json"


def default_folder() -> Path:
    """Return where a report goes if nobody says: named by the hour, in this folder."""
    return Path(f"rosic-bench-{datetime.now(UTC):%Y-%m-%d_%H-%M-%S}")


def measured(
    benches: Sequence[Sequence[str]], folder: Path, *, quick: bool
) -> Iterator[BenchReport]:
    """Run benches one after another, and yield what each saw.

    One that cannot run says why in its report. After an interrupt comes the report of the one that
    was interrupted, and no other.

    Args:
        benches: Name and options of each.
        folder: In which they run: what they write besides goes there.
        quick: Short runs.
    """
    make_folder(folder)
    for name, *options in benches:
        told = ["bench", name, *options, *(["--quick"] if quick else [])]
        process = subprocess.Popen(  # noqa: S603 - our own command
            [sys.executable, "-m", "rosic", *told, "--json"],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE if not sys.stderr.isatty() else None,
        )
        try:
            out, err = process.communicate()
        except KeyboardInterrupt:
            out, err = _interrupted(process)
            yield _report(told, out, INTERRUPTED)
            return
        yield _report(told, out, _last_line(err))


def _interrupted(process: subprocess.Popen[bytes]) -> tuple[bytes, bytes]:
    """Let a bench that hears the same interrupt say what it saw."""
    try:
        return process.communicate(timeout=ENDS_WITHIN_S)
    except (KeyboardInterrupt, subprocess.TimeoutExpired):
        process.kill()
        return process.communicate()


def _report(told: Sequence[str], out: bytes, why: str) -> BenchReport:
    # Where something lies on this machine is no part of a report that others read.
    for place in filter(_is_place, told):
        out, why = out.replace(place.encode(), b"PATH"), why.replace(place, "PATH")
    try:
        found = msgspec.json.decode(out, type=BenchReport)
    except msgspec.MsgspecError:
        found = BenchReport(
            machine=machine(),
            method="",
            cases=(),
            failures=(NOTHING.format(why=why or "it said nothing."),),
            bench=told[1],
        )
    return msgspec.structs.replace(found, command=command_of(told))


def command_of(told: Sequence[str]) -> str:
    """Return what was asked of ``rosic``, without saying where something lies on this machine."""
    return " ".join(("rosic", *("PATH" if _is_place(word) else word for word in told)))


def _is_place(word: str) -> bool:
    return Path(word).is_absolute()


def _last_line(err: bytes | None) -> str:
    lines = (err or b"").decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else ""


def write_suite(reports: Sequence[BenchReport], folder: Path) -> None:
    """Write what was measured: numbers, page and Markdown; workbook and charts of the last one.

    Raises:
        ConfigurationError: A file cannot be written, or something to draw with is not installed.
            What was written before it is there.
    """
    make_folder(folder)
    write(folder / NUMBERS, msgspec.json.format(msgspec.json.encode(reports), indent=1))
    write(folder / PAGE, as_html(reports).encode())
    write(folder / MARKDOWN, as_markdown(reports).encode())
    last = reports[-1]
    write_charts(last, folder)
    if last.cases or last.tables:
        write_xlsx(last, folder / f"{last.bench}.xlsx")


def require_all() -> None:
    """Make sure, before an hour is spent, that everything of a report can be written.

    Raises:
        ConfigurationError: Something is not installed; says how to.
    """
    require_charts()
    require_workbooks()
