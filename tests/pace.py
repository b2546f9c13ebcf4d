"""How slow this machine is at the moment: what is promised in seconds is promised of a free one."""

from __future__ import annotations

import os
import time

SAMPLE_S = 0.1
# Other workers of the same run use the processors, now or in the moment that was measured before.
SHARED = 3.0 if "PYTEST_XDIST_WORKER" in os.environ else 1.0


def slowness() -> float:
    """Return how many times longer than on a free processor work takes now; 1.0 at least.

    A promise times this is as strict as the promise where nothing else runs, and no more than fair
    where processors are shared.
    """
    begun_s, spent_s = time.perf_counter(), time.thread_time()
    while time.thread_time() - spent_s < SAMPLE_S:
        pass
    return max(1.0, (time.perf_counter() - begun_s) / SAMPLE_S)


def patience() -> float:
    """Return by how much more than what is promised of a free machine may be taken here now."""
    return max(SHARED, slowness())
