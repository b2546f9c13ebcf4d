"""How slow this machine is: what is promised in seconds is promised of a free one, as is usual.

Usual are two processors, each of which does a sample of work in `SAMPLE_S`. `pace` is measured at
the start of a run and holds for the whole of it, in every process: limits and waits are that much
longer. `slowness` and `patience` are of this moment, for what is promised in seconds.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from functools import cache

PACE = "ROSIC_PACE"
"""Where the pace of a run stands once it was measured: in the environment of its processes."""
SAMPLE = 1_500_000
SAMPLE_S = 0.1
STARTS_S = 0.015
"""And an interpreter starts in so much, without what is installed for it."""
USUAL_PROCESSORS = 2
AT_ONCE = 4
"""As many as `make test` has workers."""
TIMES = 3
"""So often it is measured: the best of them is the machine, the others may be a passing crowd."""
SLOWEST = 10.0
"""Nothing is waited for longer than so many times the usual, or a hang would last for hours."""
# Other workers of the same run use the processors, now or in the moment that was measured before.
SHARED = 3.0 if "PYTEST_XDIST_WORKER" in os.environ else 1.0


@cache
def pace() -> float:
    """Return how many times longer than usual a run of tests takes here; 1.0 at least."""
    if PACE not in os.environ:
        slow = min(_measured() for _ in range(TIMES))
        os.environ[PACE] = f"{min(max(1.0, slow), SLOWEST):.2f}"
    return float(os.environ[PACE])


def slowness() -> float:
    """Return how many times longer than on a free processor work takes now; 1.0 at least.

    A promise times this is as strict as the promise where nothing else runs, and no more than fair
    where processors are shared.
    """
    begun_s = time.perf_counter()
    _work()
    return max(1.0, (time.perf_counter() - begun_s) / SAMPLE_S)


def patience() -> float:
    """Return by how much more than what is promised of a free machine may be taken here now."""
    return max(SHARED * pace(), slowness())


def _measured() -> float:
    """Let as many processes work at once as a run has, and see how long they all take."""
    sample = [sys.executable, "-I", "-S", __file__]
    begun_s = time.perf_counter()
    working = [subprocess.Popen(sample) for _ in range(AT_ONCE)]  # noqa: S603 - this module
    for process in working:
        process.wait()
    usual_s = (STARTS_S + SAMPLE_S) * AT_ONCE / USUAL_PROCESSORS
    return (time.perf_counter() - begun_s) / usual_s


def sample_of_work_s() -> float:
    """Return what the sample costs in processor time now: work is told as a multiple of it."""
    begun_s = time.thread_time()
    _work()
    return time.thread_time() - begun_s


def _work() -> None:
    total = 0
    for number in range(SAMPLE):
        total = (total * 31 + number) % 65_537


if __name__ == "__main__":
    _work()
