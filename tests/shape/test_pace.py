"""Every bound of a run follows the pace that was measured before it."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

from tests.pace import PACE, pace

ROOT = Path(__file__).parents[2]
BUSY = 4
ONE_PROCESSOR = "import os; os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])\n"
MEASURED = "from tests.pace import pace; print(pace())"


def said(arguments: list[str], **changed: str) -> str:
    """Return what Python says."""
    return subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, *arguments],
        cwd=ROOT,
        env={name: value for name, value in os.environ.items() if name != PACE} | changed,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=150 * pace(),
    ).stdout


def test_the_pace_is_that_of_a_crowd() -> None:
    busy = [
        subprocess.Popen([sys.executable, "-c", f"{ONE_PROCESSOR}while True: pass"])  # noqa: S603
        for _ in range(BUSY)
    ]
    try:
        pace = float(said(["-c", ONE_PROCESSOR + MEASURED]))
    finally:
        for process in busy:
            process.kill()
            process.wait()
    assert pace > 2.0, "half of the processors, and a third of that one"


def test_a_pace_that_was_measured_is_not_measured_again() -> None:
    assert said(["-c", MEASURED], **{PACE: "1.25"}) == "1.25\n"


def test_a_run_has_longer_on_a_slow_machine(tmp_path: Path) -> None:
    (tmp_path / "timeout").write_text('#!/bin/sh\necho "$@" pace=$ROSIC_PACE\n')
    (tmp_path / "timeout").chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    command = ["-m", "tests.bounded", "1800", "make", "coffee"]

    usual = said(command, PATH=path, **{PACE: "1.00"})
    slow = said(command, PATH=path, **{PACE: "3.00"})

    assert usual == "--foreground --signal=INT --kill-after=60 1800 make coffee pace=1.00\n"
    assert slow.endswith(
        "over within 5400 s.\n"
        "--foreground --signal=INT --kill-after=180 5400 make coffee pace=3.00\n"
    )


def test_what_hangs_where_no_python_runs_has_longer_too(tmp_path: Path) -> None:
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    (tmp_path / "test_limit.py").write_text(
        "def test_it(pytestconfig):\n"
        "    assert float(pytestconfig.getini('faulthandler_timeout')) == 1200\n"
    )
    for workers in ("0", "1"):
        done = said(["-m", "tests.alone", "-n", workers, str(tmp_path)], **{PACE: "2.00"})
        assert "1 passed" in done


def test_nothing_is_waited_for_that_is_not_longer_on_a_slow_machine() -> None:
    waits = [
        f"{file.relative_to(ROOT)}:{line}"
        for file in sorted((ROOT / "tests").rglob("*.py"))
        for line in fixed_waits(ast.parse(file.read_text()))
    ]
    assert waits == []


def fixed_waits(tree: ast.Module) -> list[int]:
    """Return the lines of waits whose bound is a number; what is to expire has less than 1 s."""
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    bounds = [
        (call.lineno, call.args[-1])
        for call in calls
        if ast.unparse(call.func) in {"asyncio.timeout", "asyncio.wait_for"}
    ]
    return [
        line
        for line, bound in bounds
        if isinstance(bound, ast.Constant) and isinstance(bound.value, int | float)
        if bound.value >= 1
    ]
