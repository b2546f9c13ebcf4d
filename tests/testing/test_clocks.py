"""The clock runs on while the machine sleeps; Python's own monotonic clock does not."""

from __future__ import annotations

import asyncio
import shutil
import subprocess
import sys

import pytest

from rosic.testing.clock import ManualClock

HOURS_S = 8 * 3600
# A time namespace is a machine that has slept: its boot clock is ahead of what runs awake.
ASLEEP = ("unshare", "--user", "--map-root-user", "--time", "--boottime", str(HOURS_S), "--fork")
READINGS = """
import time
from rosic.cli.client import begun_ns
from rosic.system import SystemClock
print(SystemClock().monotonic_ns() - time.monotonic_ns(), SystemClock().monotonic_ns() - begun_ns())
"""


def _may_sleep() -> bool:
    if shutil.which("unshare") is None:
        return False
    # As another user in there, this one may not reach an interpreter below a folder that is closed.
    tried = subprocess.run(  # noqa: S603
        (*ASLEEP, sys.executable, "-c", ""), capture_output=True, check=False
    )
    return tried.returncode == 0


@pytest.mark.skipif(not _may_sleep(), reason="no time namespace may be made here (unshare --time)")
def test_the_clock_has_run_on_while_the_machine_slept() -> None:
    run = subprocess.run(  # noqa: S603
        (*ASLEEP, sys.executable, "-c", READINGS), capture_output=True, text=True, check=True
    )
    slept_ns, age_ns = map(int, run.stdout.split())
    assert abs(slept_ns / 1e9 - HOURS_S) < 60, "it stands still in suspend"
    assert 0 <= age_ns / 1e9 < 60, "the start of this process is told by another clock"


async def test_in_suspend_both_clocks_run_on_and_nobody_wakes() -> None:
    clock = ManualClock()
    wall_ns, monotonic_ns = clock.wall_ns(), clock.monotonic_ns()
    clock.suspend(HOURS_S)
    assert clock.wall_ns() - wall_ns == HOURS_S * 10**9
    assert clock.monotonic_ns() - monotonic_ns == HOURS_S * 10**9


@pytest.mark.parametrize(("seconds", "wakes_ns"), [(1e-12, 1), (0.9e-9, 1), (0.07, 70_000_000)])
async def test_every_sleep_takes_time(seconds: float, wakes_ns: int) -> None:
    clock = ManualClock()
    begun_ns = clock.monotonic_ns()
    sleeping = asyncio.create_task(clock.sleep(seconds))
    await clock.advance(0.0)
    assert not sleeping.done()
    await clock.advance((wakes_ns - 1) / 1e9)
    assert not sleeping.done()
    await clock.advance(1e-9)
    assert sleeping.done()
    assert clock.monotonic_ns() - begun_ns == wakes_ns


async def test_whoever_waits_for_what_is_left_of_a_time_comes_to_its_end() -> None:
    clock = ManualClock()
    end_s = clock.monotonic_ns() / 1e9 + 0.1000000004

    async def wait() -> None:
        for _ in range(100):
            left_s = end_s - clock.monotonic_ns() / 1e9
            if left_s <= 0:
                return
            await clock.sleep(left_s)
        pytest.fail("it waits for ever at one moment")

    waiting = asyncio.create_task(wait())
    await clock.advance(0.2)
    await waiting
