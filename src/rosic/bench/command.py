"""``rosic bench NAME``, ``rosic bench report``, ``compare`` and ``budgets``."""

from __future__ import annotations

import argparse
import logging
import signal
import sys
import traceback
from importlib import import_module
from importlib.util import find_spec
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple

from msgspec import structs

from rosic.bench import comparison, output, suite
from rosic.bench.charts import require_charts
from rosic.bench.recorder import BenchRecorder
from rosic.bench.report import BenchReport, as_json, as_text, table_lines
from rosic.errors import ConfigurationError, RosicError, how_to_install

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

INTERRUPTED: Final = 130
MOST: Final = 100_000
MOST_HOURS: Final = 1_000
CTRL_C: Final = "It was interrupted: what was measured until then is above."
TROUBLE: Final = "It ended early: {why}. What was measured until then is above."


def _no_options(_parser: argparse.ArgumentParser) -> None: ...


def _account_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--over",
        choices=("stand-in", "bot", "account"),
        default="stand-in",
        help="by what messages go; a real bot needs ROSIC_BENCH_TOKEN and ROSIC_BENCH_CHAT in the "
        "environment, a real account ROSIC_BENCH_API_ID and ROSIC_BENCH_API_HASH, and the extra "
        "account",
    )


def _latency_options(parser: argparse.ArgumentParser) -> None:
    _account_options(parser)
    parser.add_argument("--messages", type=_count, default=0, help="of Algorithm 9; else 100")
    parser.add_argument("--runs", type=_count, default=0, help="else 10")
    parser.add_argument(
        "--out", type=Path, default=Path(), metavar="FOLDER", help="where the workbooks go"
    )


def _throughput_options(parser: argparse.ArgumentParser) -> None:
    _account_options(parser)
    parser.add_argument("--duration", type=_seconds, default=0.0, metavar="S", help="else 10")
    parser.add_argument("--interval", type=_seconds, default=0.1, metavar="S", help="else 0.1")


def _message_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--group", required=True, help="its link, name or id")
    parser.add_argument("--file", type=Path, default=Path("messages.txt"), help="messages.txt")
    parser.add_argument("--seconds", type=_seconds, default=0.0, metavar="S", help="else 60")


def _scale_options(parser: argparse.ArgumentParser) -> None:
    _account_options(parser)


def _count(text: str) -> int:
    if not text.isdecimal() or not 0 < int(text) <= MOST:
        raise argparse.ArgumentTypeError(f"a number from 1 to {MOST}")
    return int(text)


def _seconds(text: str) -> float:
    return _above_0(text, "seconds", MOST)


def _hours(text: str) -> float:
    return _above_0(text, "hours", MOST_HOURS)


def _above_0(text: str, unit: str, most: int) -> float:
    try:
        value = float(text)
    except ValueError:
        value = nan
    if not 0 < value <= most:
        raise argparse.ArgumentTypeError(f"{unit}, above 0 and at most {most}")
    return value


def _add_rosbridge(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--rosbridge",
        type=lambda text: Path(text).absolute(),  # nodes run elsewhere
        metavar="PATH",
        help="beside this checkout of rosbridge_suite",
    )


def _resource_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--hours", type=_hours, metavar="HOURS", help="a soak with faults; 2 is a whole one"
    )


def _matrix_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--synapse",
        type=lambda text: Path(text).absolute(),
        metavar="PYTHON",
        help="of an environment with Synapse; left out: one in your cache, made if need be",
    )
    parser.add_argument("--no-install", action="store_true", help="make none")


def _peers_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--environment",
        type=lambda text: Path(text).absolute(),
        metavar="PATH",
        help="keep the environments of other bots there; left out: in your cache",
    )
    parser.add_argument(
        "--no-install", action="store_true", help="leave out those that are not there"
    )


class BenchEntry(NamedTuple):
    """A bench as the command knows it: its module is imported when it runs.

    Attributes:
        summary: One line for the overview.
        options: Adds what it understands beyond what all do; its `measure` takes them by name.
        extras: Parts of ROSIC that have to be installed for it.
        in_report: ``rosic bench report`` runs it.
        report_options: With these.
    """

    summary: str
    options: Callable[[argparse.ArgumentParser], None] = _no_options
    extras: tuple[str, ...] = ()
    in_report: bool = True
    report_options: tuple[str, ...] = ()

    def measure(
        self, name: str, recorder: BenchRecorder, options: Mapping[str, object]
    ) -> BenchReport:
        """Import it, and run it.

        Raises:
            ConfigurationError: A part that it needs is not installed.
        """
        missing = [one for one in self.extras if not find_spec(EXTRAS[one])]
        if missing:
            names = ", ".join(EXTRAS[one] for one in missing)
            raise ConfigurationError(
                NOT_INSTALLED.format(name=name, names=names),
                hint=f"Run: {how_to_install(','.join(self.extras))}",
            )
        found: BenchReport = import_module(f"rosic.bench.{name}").measure(recorder, **options)
        return found


EXTRAS: Final = {
    "telegram": "telegram",
    "testing": "aiohttp",
    "api": "litestar",
    "matrix": "nio",
    "schedule": "scipy",
}
"""A module that each brings."""
STAND_IN: Final = ("telegram", "testing")
NOT_INSTALLED: Final = "rosic bench {name} needs what is not installed: {names}."
BESIDE_ROSBRIDGE: Final = "api"
BENCHES: Final[dict[str, BenchEntry]] = {
    BESIDE_ROSBRIDGE: BenchEntry(
        "WebSocket to ROS 2 topic and back, beside rosbridge_server", _add_rosbridge, ("api",)
    ),
    "fleet": BenchEntry(
        "choosing robots for tasks, and gateways of up to 5,000 robots", extras=("schedule",)
    ),
    "idle": BenchEntry(
        "what a gateway needs of a processor while nobody does anything", extras=("api",)
    ),
    "language": BenchEntry("what reading a line costs"),
    "latency": BenchEntry(
        "Algorithm 9 of the paper, and an order hop by hop", _latency_options, STAND_IN
    ),
    "matrix": BenchEntry(
        "an order and its answer over Matrix, beside a bare echo",
        _matrix_options,
        ("matrix",),
        in_report=False,
        report_options=("--no-install",),
    ),
    "messages": BenchEntry(
        "Algorithm 6 of the paper: a group's messages into a file, by a real account",
        _message_options,
        STAND_IN,
        in_report=False,
    ),
    "peers": BenchEntry(
        "beside opsdroid, errbot, python-telegram-bot and aiogram",
        _peers_options,
        ("telegram",),
        report_options=("--no-install",),
    ),
    "pipeline": BenchEntry("orders a second through a whole gateway, in memory and on disk"),
    "resources": BenchEntry(
        "what a gateway uses over time; a soak of hours", _resource_options, STAND_IN
    ),
    "schedule": BenchEntry("proposed plans beside first come, first served", extras=("schedule",)),
    "security": BenchEntry(
        "time of authentication, and attempts that are refused", extras=(*STAND_IN, "api")
    ),
    "start": BenchEntry("how far apart robots begin that are to begin together"),
    "stop": BenchEntry("how soon a stop is handed over, behind a queue"),
    "strangers": BenchEntry("how soon a stop takes effect behind a flood", extras=STAND_IN),
    "scale": BenchEntry(
        "Algorithm 11 of the paper, and people, robots and rates without end",
        _scale_options,
        STAND_IN,
    ),
    "telegram": BenchEntry(
        "batches under Telegram's limits, and what receiving costs", extras=STAND_IN
    ),
    "throughput": BenchEntry(
        "Algorithm 10 of the paper: success and bytes", _throughput_options, STAND_IN
    ),
    "usability": BenchEntry(
        "taps, words and seconds of first times, by scripted people", extras=STAND_IN
    ),
}


def main(arguments: Sequence[str], benches: Mapping[str, BenchEntry] = BENCHES) -> int:
    """Run what is asked for, print it, then what did not hold. Return the exit status.

    Raises:
        ConfigurationError: Something that it needs is not installed or not there.
    """
    chosen = vars(_parser(benches).parse_args(arguments))
    chosen["command"] = suite.command_of(("bench", *arguments))
    run: Callable[[dict[str, object]], int] = chosen.pop("run")
    # What a gateway that is measured warns of is no part of what is printed.
    logging.getLogger().addHandler(logging.NullHandler())
    # Whoever ends it otherwise than by Ctrl-C leaves no process of it behind, either.
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        return run(chosen)
    finally:
        signal.signal(signal.SIGTERM, before)


def _parser(benches: Mapping[str, BenchEntry]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="rosic bench", description="Measure ROSIC here.")
    names = parser.add_subparsers(metavar="NAME", required=True)
    for name, entry in sorted(benches.items()):
        one = names.add_parser(name, help=entry.summary, description=entry.summary)
        one.add_argument("--quick", action="store_true", help="one short run of each case")
        _add_outputs(one)
        entry.options(one)
        one.set_defaults(run=lambda chosen, name=name, entry=entry: _run(name, entry, chosen))
    _add_report(names, benches)
    _add_compare(names)
    _add_budgets(names)
    return parser


def _add_outputs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write every table there too")
    parser.add_argument("--xlsx", type=Path, metavar="FILE", help="write a workbook there too")
    parser.add_argument("--charts", type=Path, metavar="FOLDER", help="draw the charts there")


# ---- one bench ----


def _run(name: str, entry: BenchEntry, chosen: dict[str, object]) -> int:
    as_object, csv, xlsx, charts = (chosen.pop(one) for one in ("json", "csv", "xlsx", "charts"))
    command = str(chosen.pop("command"))
    if xlsx is not None:
        output.require_workbooks()
    if charts is not None:
        require_charts()
    _require_places(csv, xlsx, chosen.get("file"), folders=(charts, chosen.get("out")))
    progress = sys.stderr if sys.stderr.isatty() else None
    recorder = BenchRecorder(name, quick=bool(chosen.pop("quick")), progress=progress)
    report, status = _measured(entry, recorder, chosen)
    report = structs.replace(report, command=command)
    writers = ((csv, output.write_csv), (xlsx, output.write_xlsx), (charts, output.write_charts))
    try:
        for path, writer in writers:
            if isinstance(path, Path):
                writer(report, path)
    finally:  # neither is lost for the other
        sys.stdout.write((as_json(report) if as_object else as_text(report)) + "\n")
        sys.stdout.flush()  # before what did not hold, wherever both go
        for failure in report.failures:
            sys.stderr.write(f"failed: {failure}\n")
    return status


def _require_places(*files: object, folders: Sequence[object]) -> None:
    """Make sure, before anything is measured, that there is a place for what is written of it."""
    for path in files:
        if isinstance(path, Path):
            output.require_file(path)
    for path in folders:
        if isinstance(path, Path):
            output.make_folder(path)


def _measured(
    entry: BenchEntry, recorder: BenchRecorder, options: Mapping[str, object]
) -> tuple[BenchReport, int]:
    """Return what a bench saw, all of it or until it was cut short, and the exit status."""
    try:
        report = recorder.finished(entry.measure(recorder.bench, recorder, options))
    except KeyboardInterrupt:
        return recorder.partial(CTRL_C), INTERRUPTED
    except RosicError:
        raise
    except Exception as trouble:  # noqa: BLE001 - what was measured before is not thrown away
        why = (trouble.strerror or str(trouble)) if isinstance(trouble, OSError) else ""
        if not why:  # else a full disk, a network that went
            traceback.print_exc()
            why = f"{type(trouble).__name__}: {trouble}".rstrip(": ")
        return recorder.partial(TROUBLE.format(why=why)), 1
    return report, 1 if report.failures else 0


# ---- all of them ----


def _add_report(
    names: argparse._SubParsersAction[argparse.ArgumentParser], benches: Mapping[str, BenchEntry]
) -> None:
    inside = sorted(name for name, entry in benches.items() if entry.in_report)
    one = names.add_parser("report", help="every bench, and one page of them")
    one.add_argument("--quick", action="store_true", help="one short run of each case")
    one.add_argument("--out", type=Path, metavar="FOLDER", help="left out: named by the hour")
    one.add_argument("--only", nargs="+", choices=inside, default=inside, metavar="NAME")
    _add_rosbridge(one)
    one.add_argument(
        "--from",
        nargs="+",
        type=Path,
        metavar="FILE",
        help="measure nothing: write the page of these reports; of two of one bench, the last",
    )
    one.set_defaults(run=lambda chosen: _report(chosen, benches))


def _report(chosen: Mapping[str, object], benches: Mapping[str, BenchEntry]) -> int:
    suite.require_all()
    folder = chosen["out"]
    where = folder if isinstance(folder, Path) else suite.default_folder()
    reports: list[BenchReport] = []
    for report in _reports(chosen, benches, where):
        reports.append(report)
        suite.write_suite(reports, where)
        told = f"{len(report.failures)} did not hold" if report.failures else "measured"
        sys.stdout.write(f"{report.bench}: {told}, {report.took_s:.0f} s\n")
        sys.stdout.flush()
    table = comparison.judged(reports, comparison.asked(reports))
    sys.stdout.write(f"{comparison.in_sum(table)}\nWritten: {where / suite.PAGE}\n")
    return 1 if any(report.failures for report in reports) or comparison.is_broken(table) else 0


def _reports(
    chosen: Mapping[str, object], benches: Mapping[str, BenchEntry], where: Path
) -> Iterator[BenchReport]:
    """Yield what earlier runs saw, if that is asked for, else what each bench sees now."""
    written, rosbridge = chosen["from"], chosen["rosbridge"]
    if isinstance(written, list):
        known = [one for path in written for one in comparison.read_reports(path)]
        return iter({one.bench: one for one in known}.values())
    beside = {BESIDE_ROSBRIDGE: ("--rosbridge", str(rosbridge))} if rosbridge else {}
    runs = [
        (name, *benches[name].report_options, *beside.get(name, ()))
        for name in chosen["only"]  # type: ignore[attr-defined]
    ]
    return suite.measured(runs, where, quick=bool(chosen["quick"]))


# ---- beside another hour, and beside what is promised ----


def _add_compare(names: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    one = names.add_parser("compare", help="two reports beside each other, by ratio to their pace")
    one.add_argument("old", type=Path)
    one.add_argument("new", type=Path)
    one.set_defaults(run=_compare)


def _compare(chosen: Mapping[str, Path]) -> int:
    old, new = map(comparison.read_reports, (chosen["old"], chosen["new"]))
    found = comparison.changes(old, new)
    lines = table_lines(comparison.change_table(found))
    sys.stdout.write("\n".join(lines) + "\n")
    if (together := comparison.typical(found)) is None:
        sys.stderr.write("failed: They have no case in common.\n")
        return 1
    sys.stdout.write(f"All of them together: {together:.2f} times as long.\n")
    if gone := [one for one in found if one.verdict == comparison.GONE]:
        sys.stderr.write(f"failed: {len(gone)} cases are in one of them alone.\n")
    broken = [report for report in new if report.failures]
    for report in broken:
        sys.stderr.write(f"failed: {report.bench}: {report.failures[0]}\n")
    slower = any(one.verdict == comparison.SLOWER for one in found)
    return 1 if slower or gone or broken else 0


def _add_budgets(names: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    one = names.add_parser("budgets", help="what is promised, beside what a report measured")
    one.add_argument("report", type=Path, nargs="+")
    one.set_defaults(run=_budgets)


def _budgets(chosen: Mapping[str, Sequence[Path]]) -> int:
    reports = [one for path in chosen["report"] for one in comparison.read_reports(path)]
    table = comparison.judged(reports, comparison.budgets())
    sys.stdout.write("\n".join(table_lines(table)) + "\n")
    if all(comparison.UNSEEN in row for row in table.rows):
        sys.stderr.write("failed: Nothing that is promised was measured.\n")
        return 1
    return 1 if comparison.is_broken(table) else 0
