"""How slow this machine is at the moment: what is promised in seconds is promised of a free one."""

from __future__ import annotations

import time

SAMPLE_S = 0.1


def slowness() -> float:
    """Return how many times longer than on a free processor work takes now; 1.0 at least.

    A promise times this is as strict as the promise where nothing else runs, and no more than fair
    where processors are shared.
    """
    begun_s, spent_s = time.perf_counter(), time.thread_time()
    while time.thread_time() - spent_s < SAMPLE_S:
        pass
    return max(1.0, (time.perf_counter() - begun_s) / SAMPLE_S)
