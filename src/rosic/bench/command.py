"""``rosic bench NAME [--json]``."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.bench.report import BenchReport, as_json, as_text

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence


def _pipeline(quick: bool) -> BenchReport:
    from rosic.bench.pipeline import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _stop(quick: bool) -> BenchReport:
    from rosic.bench.stop import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _schedule(quick: bool) -> BenchReport:
    from rosic.bench.schedule import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _start(quick: bool) -> BenchReport:
    from rosic.bench.start import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _strangers(quick: bool) -> BenchReport:
    from rosic.bench.strangers import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _telegram(quick: bool) -> BenchReport:
    from rosic.bench.telegram import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _fleet(quick: bool) -> BenchReport:
    from rosic.bench.fleet import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _language(quick: bool) -> BenchReport:
    from rosic.bench.language import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _idle(quick: bool) -> BenchReport:
    from rosic.bench.idle import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick)


def _api(quick: bool, rosbridge: Path | None = None) -> BenchReport:
    from rosic.bench.api import measure  # noqa: PLC0415 - only the bench that runs is loaded

    return measure(quick=quick, rosbridge=rosbridge)


BENCHES: dict[str, Callable[[bool], BenchReport]] = {
    "api": _api,
    "fleet": _fleet,
    "idle": _idle,
    "language": _language,
    "pipeline": _pipeline,
    "schedule": _schedule,
    "start": _start,
    "stop": _stop,
    "strangers": _strangers,
    "telegram": _telegram,
}


def main(
    arguments: Sequence[str], benches: Mapping[str, Callable[[bool], BenchReport]] = BENCHES
) -> int:
    """Run one bench and print its report, then what did not hold. Return the exit status."""
    parser = argparse.ArgumentParser(prog="rosic bench", description="Measure ROSIC here.")
    parser.add_argument("name", choices=sorted(benches))
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--quick", action="store_true", help="one short run of each case")
    parser.add_argument(
        "--rosbridge",
        type=Path,
        metavar="PATH",
        help="api: beside this checkout of rosbridge_suite",
    )
    chosen = parser.parse_args(arguments)
    run = benches[chosen.name]
    if chosen.rosbridge is not None:
        if chosen.name != "api":
            parser.error("--rosbridge belongs to: rosic bench api")
        run = partial(_api, rosbridge=chosen.rosbridge.absolute())  # nodes run elsewhere
    report = run(chosen.quick)
    sys.stdout.write((as_json(report) if chosen.json else as_text(report)) + "\n")
    sys.stdout.flush()  # before what did not hold, wherever both go
    for failure in report.failures:
        sys.stderr.write(f"failed: {failure}\n")
    return 1 if report.failures else 0
