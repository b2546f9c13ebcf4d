"""When a process began, whatever happened to it since."""

from __future__ import annotations

import os
import subprocess
import sys
import time

from rosic.cli.client import begun_ns
from tests.cli.running import environment
from tests.pace import pace

AGE = "import time; from rosic.cli.client import begun_ns; print(time.monotonic_ns() - begun_ns())"
# As the ROS wheels do: another program, the same process.
ANEW = f"""
import os, sys, time
time.sleep(0.4)
os.execv(sys.executable, [sys.executable, "-c", {AGE!r}])
"""


def age_s(code: str) -> float:
    done = subprocess.run(  # noqa: S603 - our own interpreter
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        timeout=120 * pace(),
        env=environment(),
    )
    return int(done.stdout) / 1e9


def test_starting_python_and_starting_it_again_count() -> None:
    before_s = time.monotonic()
    age = age_s(ANEW)
    took_s = time.monotonic() - before_s

    assert 0.4 < age < took_s + 0.05


def test_it_does_not_change_while_a_process_lives() -> None:
    tick_ns = 10**9 // os.sysconf("SC_CLK_TCK")

    assert abs(begun_ns() - begun_ns()) < tick_ns
    assert begun_ns() < time.monotonic_ns()
