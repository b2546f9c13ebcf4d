"""When this process began: what a person waits for includes importing Python."""

from __future__ import annotations

import os
import time
from pathlib import Path

from rosic.system import SystemClock

_STARTED_FIELD = 19  # of /proc/self/stat, counted behind the name


def begun_ns() -> int:
    """Return the monotonic clock at the start of this process; now, where it cannot be known.

    The kernel's word, within 10 ms: starting the interpreter counts, and so does starting it anew
    in the same process, which the ROS wheels do.
    """
    now_ns = SystemClock.monotonic_ns()
    try:
        fields = Path("/proc/self/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
        ticks = int(fields[_STARTED_FIELD])
        age_ns = time.clock_gettime_ns(time.CLOCK_BOOTTIME) - ticks * 10**9 // os.sysconf(
            "SC_CLK_TCK"
        )
    except (OSError, ValueError, IndexError, AttributeError):
        return now_ns
    return now_ns - max(0, age_ns)
