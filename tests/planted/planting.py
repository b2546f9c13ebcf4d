"""Planting a fault, and the run of tests that has to fail because of it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import contextmanager
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import pytest

from tests.pace import pace
from tests.planted.faults import place
from tests.planted.nursery import Run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from tests.planted.faults import Fault

ROOT = Path(__file__).parents[2]
WITHIN_S = 240
# A plugin of the run that is to fail: which source it was that failed, and what was no link in it.
SAYS_WHERE = "says_where"
WHERE = """
import functools, gc, os, sys
from tests.pace import pace
def pytest_collection_finish():
    gc.freeze()
    gc.enable()
def pytest_sessionfinish():
    gc.freeze()  # what it would look for now, it would throw away with the process
@functools.cache
def real(folder):
    return os.path.realpath(folder)
def pytest_terminal_summary(terminalreporter):
    import rosic
    terminalreporter.write_line(f"source: {rosic.__file__}")
    here = real(os.path.dirname(__file__))
    for module in tuple(sys.modules.values()):
        file = getattr(module, "__file__", None) or ""
        if file == __file__ or os.path.islink(file):
            continue
        if real(os.path.dirname(file)).startswith(here):
            terminalreporter.write_line(f"changed: {file}")
"""


class Nursery:
    """Where runs are forked that are to fail; one for many faults."""

    def __init__(self) -> None:
        own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.planted.nursery"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            cwd=ROOT,
            # A fork takes one thread along, so that there should be no others.
            env=own | {"OPENBLAS_NUM_THREADS": "1"},
            start_new_session=True,
        )

    def end_of(self, run: Run) -> int:
        """Let something run; return its exit status."""
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(msgspec.json.encode(run) + b"\n")
        process.stdin.flush()
        return int(process.stdout.readline())

    def close(self) -> None:
        """End it, and whatever still runs there."""
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.communicate()


@contextmanager
def opened() -> Iterator[Nursery]:
    """Keep one open while inside."""
    nursery = Nursery()
    try:
        yield nursery
    finally:
        nursery.close()


def assert_caught(fault: Fault, folder: Path, nursery: Nursery) -> None:
    """Plant a fault below an empty folder, and see the tests that it names fail because of it."""
    source = folder / "src"
    plant(fault, source)
    (folder / f"{SAYS_WHERE}.py").write_text(WHERE)
    log = folder / "log"
    run = Run(
        arguments=(
            "-q",
            "-x",
            "--tb=line",
            "-p",
            SAYS_WHERE,
            "--hypothesis-profile=unread",
            *fault.caught_by,
        ),
        paths=(str(source), str(folder)),
        log=str(log),
        within_s=ceil(WITHIN_S * pace()),
    )
    status, said = nursery.end_of(run), log.read_text()
    assert status == pytest.ExitCode.TESTS_FAILED, f"nothing noticed: {fault.name}\n{said[-2500:]}"
    assert f"source: {source}" in said, "the planted source was not what ran"
    assert f"changed: {source / place(fault.file)}" in said, "the fault was not loaded"


def plant(fault: Fault, source: Path) -> None:
    """Lay out the source once more: what is changed is written, all else is a link.

    Compiled files come along, with the times that make them valid: only what changes is compiled.
    """
    here, there = ROOT / "src", source
    *folders, name = place(fault.file).parts
    for folder in (*folders, None):
        compiled = there / "__pycache__"
        compiled.mkdir(parents=True)
        for each in here.iterdir():
            if each.name not in {folder or name, compiled.name}:
                (there / each.name).symlink_to(each)
        for each in here.glob("__pycache__/*.pyc"):
            if folder is not None or each.name.partition(".")[0] != Path(name).stem:
                (compiled / each.name).symlink_to(each)
        if folder is not None:
            here, there = here / folder, there / folder
    text = (here / name).read_text(encoding="utf-8")
    assert text.count(fault.guard) == 1, f"{fault.file} has changed: the fault must be planted anew"
    (there / name).write_text(text.replace(fault.guard, fault.without), encoding="utf-8")
