"""The machine: how long its disk takes to keep something, how its clocks behave, what is left."""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from contextlib import closing
from pathlib import Path
from statistics import quantiles
from typing import TYPE_CHECKING

from rosic.app.setup.findings import DiagnosticFinding, FindingVerdict
from rosic.errors import RosicError
from rosic.stores import sqlite
from rosic.stores.settings import StoreSettings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.contracts.clock import Clock

WRITES = 200
WRITES_WITHIN_S = 3.0
PAGE = bytes(4096)
SLOW_MS = 50.0
READINGS = 100_000
DRIFT_OVER_S = 0.25
DRIFT_PPM_AT_MOST = 1_000.0
COARSE_NS = 1_000_000
LITTLE_BYTES = 500 * 10**6
FULL = 2


def examine_disk(folder: Path) -> Iterator[DiagnosticFinding]:
    """Look at the disk of a data folder; of its nearest parent while it does not exist."""
    there = _nearest(folder)
    place = "" if there == folder else f" (measured in {there}: the data folder is not made yet)"
    try:
        yield _fsync(there, place)
        yield _record(there)
        free = shutil.disk_usage(there).free
    except OSError as error:
        yield DiagnosticFinding(
            "disk", FindingVerdict.LOOK, f"{there} cannot be written ({error.strerror}). "
            "Give it to the user who runs ROSIC."
        )  # fmt: skip
        return
    little = free < LITTLE_BYTES
    verdict = FindingVerdict.LOOK if little else FindingVerdict.GOOD
    yield DiagnosticFinding(
        "space", verdict, f"{free / 1e9:.1f} GB free" + (": little" if little else "")
    )


def _nearest(folder: Path) -> Path:
    return next(path for path in (folder, *folder.parents) if path.is_dir())


def _fsync(folder: Path, place: str) -> DiagnosticFinding:
    times_ms = _time_writes(folder)
    p50, p99 = (quantiles(times_ms, n=100, method="inclusive")[i] for i in (49, 98))
    text = f"fsync {p50:.2f} ms p50, {p99:.2f} ms p99 over {len(times_ms)} writes of 4 KiB{place}"
    if p99 > SLOW_MS:
        return DiagnosticFinding(
            "disk", FindingVerdict.LOOK, f"{text}. Every command waits for this."
        )
    return DiagnosticFinding("disk", FindingVerdict.GOOD, text)


def _time_writes(folder: Path) -> list[float]:
    """Overwrite one page again and again, each time until the disk has it; milliseconds each."""
    with tempfile.TemporaryFile(dir=folder, prefix="doctor-") as file:
        descriptor = file.fileno()
        os.pwrite(descriptor, PAGE, 0)
        os.fsync(descriptor)
        times_ms: list[float] = []
        end_ns = time.monotonic_ns() + int(WRITES_WITHIN_S * 1e9)
        while len(times_ms) < WRITES and (len(times_ms) < 2 or time.monotonic_ns() < end_ns):  # noqa: PLR2004 - quantiles need two
            begun_ns = time.perf_counter_ns()
            os.pwrite(descriptor, PAGE, 0)
            os.fsync(descriptor)
            times_ms.append((time.perf_counter_ns() - begun_ns) / 1e6)
    return times_ms


def _record(folder: Path) -> DiagnosticFinding:
    """Set a scratch record up on this disk as a real one is, and read back what holds."""
    with tempfile.TemporaryDirectory(dir=folder, prefix="doctor-") as scratch:
        path, settings = Path(scratch) / "record.db", StoreSettings()
        sqlite.make_file(path)
        with closing(sqlite.engine_for(path, settings).connect()) as connection:
            try:
                sqlite.make_durable(connection, settings)
            except RosicError as error:
                return DiagnosticFinding("record", FindingVerdict.LOOK, str(error))
            journal = sqlite.pragma(connection, "journal_mode")
            synchronous = sqlite.pragma(connection, "synchronous")
    text = f"journal mode {journal}, synchronous {synchronous} (2 is FULL), as read back"
    good = journal == "wal" and isinstance(synchronous, int) and synchronous >= FULL
    return DiagnosticFinding("record", FindingVerdict.GOOD if good else FindingVerdict.LOOK, text)


async def examine_clock(clock: Clock) -> DiagnosticFinding:
    """Look at the clocks: how fine, whether they go back, whether they agree."""
    resolution_ns = time.get_clock_info("monotonic").resolution * 1e9
    backwards = _backwards(clock)
    wall_ns, monotonic_ns = clock.wall_ns(), clock.monotonic_ns()
    await clock.sleep(DRIFT_OVER_S)
    monotonic_past_ns = clock.monotonic_ns() - monotonic_ns
    ppm = abs((clock.wall_ns() - wall_ns) / monotonic_past_ns - 1) * 1e6
    text = (
        f"resolution {resolution_ns:.0f} ns, monotonic went back {backwards} times in "
        f"{READINGS:,} readings, wall clock {ppm:.0f} ppm off it over {DRIFT_OVER_S:g} s"
    )
    if backwards or resolution_ns > COARSE_NS or ppm > DRIFT_PPM_AT_MOST:
        return DiagnosticFinding(
            "clock", FindingVerdict.LOOK, f"{text}. ROSIC counts lifetimes with these."
        )
    return DiagnosticFinding("clock", FindingVerdict.GOOD, text)


def _backwards(clock: Clock) -> int:
    count, last_ns = 0, clock.monotonic_ns()
    for _ in range(READINGS):
        now_ns = clock.monotonic_ns()
        count += now_ns < last_ns
        last_ns = now_ns
    return count
