"""Under another date it is that date, and everything takes as long as it does today."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

from tests.pace import pace
from tests.shifted.clock import compiled, shifted

WAITS_S = 0.05
LEAP_DAY_S = datetime(2028, 2, 29, 12, tzinfo=UTC).timestamp()
WAITING = f"""
import asyncio, contextlib, json, queue, subprocess, sys, threading, time
import uvloop
def locked():
    lock = threading.Lock(); lock.acquire(); lock.acquire(timeout={WAITS_S})
def empty():
    with contextlib.suppress(queue.Empty): queue.SimpleQueue().get(timeout={WAITS_S})
def ended():
    with contextlib.suppress(subprocess.TimeoutExpired):
        subprocess.run(["sleep", "60"], timeout={WAITS_S})
ways = dict(
    sleep=lambda: time.sleep({WAITS_S}), event=lambda: threading.Event().wait({WAITS_S}),
    lock=locked, queue=empty, process=ended,
    asyncio=lambda: asyncio.run(asyncio.sleep({WAITS_S})),
    uvloop=lambda: uvloop.run(asyncio.sleep({WAITS_S})),
)
took_s = {{}}
for name, wait in ways.items():
    begun_s = time.monotonic()
    wait()
    took_s[name] = time.monotonic() - begun_s
child = subprocess.check_output([sys.executable, "-c", "import time; print(time.time())"])
print(json.dumps(dict(
    now_s=time.time(), today=time.strftime("%F"), child_s=float(child), took_s=took_s,
    up_s=time.clock_gettime(time.CLOCK_BOOTTIME), monotonic_s=time.monotonic(),
)))
"""


def test_the_date_is_another_and_every_wait_as_long() -> None:
    here_s, up_s = time.monotonic(), time.clock_gettime(time.CLOCK_BOOTTIME)
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        there = shifted(compiled(Path(folder)), LEAP_DAY_S) | {"TZ": "Pacific/Apia"}
        said = subprocess.run(  # noqa: S603 - the program stands in the test
            [sys.executable, "-c", WAITING],
            env=os.environ | there,
            stdout=subprocess.PIPE,
            check=True,
            timeout=60 * pace(),
        ).stdout
    found = json.loads(said)
    spent_s = time.monotonic() - here_s + 1  # a whole number of seconds is shifted by

    assert LEAP_DAY_S - 1 < found["now_s"] < LEAP_DAY_S + spent_s
    assert LEAP_DAY_S - 1 < found["child_s"] < LEAP_DAY_S + spent_s
    assert found["today"] == "2028-03-01"
    assert here_s < found["monotonic_s"] < here_s + spent_s
    assert up_s < found["up_s"] < up_s + spent_s
    assert all(WAITS_S <= took_s < spent_s for took_s in found["took_s"].values())
