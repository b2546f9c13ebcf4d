"""A world that waits for its computer."""

from __future__ import annotations

import os
import time

from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.client.executor_thread import ahead_ns

# ---- realtime priority ----

# Being given the processor at once when a moment comes that others rely on.


class RealtimePriority:
    """Real-time priority of this thread for a short while, where the system grants it.

    Controllers of robots take it for as long as they run. Here it lasts from shortly before a
    common start until all have begun and said so: nobody else is kept waiting for longer.

    Attributes:
        wanted: False never asks for it, and so does a system that has refused it once.
    """

    def __init__(self, *, wanted: bool) -> None:
        self.wanted = wanted and hasattr(os, "SCHED_FIFO")
        self._urgent = False

    def be(self, urgent: bool) -> None:
        """Take the priority, or give it back."""
        if urgent == self._urgent or not self.wanted:
            return
        policy = os.SCHED_FIFO if urgent else os.SCHED_OTHER
        priority = os.sched_get_priority_min(os.SCHED_FIFO) if urgent else 0
        try:
            os.sched_setscheduler(0, policy, os.sched_param(priority))
        except OSError:
            self.wanted = False  # not granted to us; the same as on most machines
        else:
            self._urgent = urgent


# ---- waiting clock ----

LONGEST_GAP_S = 0.2


class WaitingClock:
    """Monotonic seconds that stand still while this process was not given the processor.

    Robots do not freeze in mid-air because a computer was busy, and neither do these: without it,
    a drone that was not stepped for a second would take its peers for lost.
    """

    def __init__(self) -> None:
        self._last_s = time.monotonic()
        self._slip_s = 0.0
        self._stalled_s, self._slip_before_s = self._last_s, 0.0

    def now_s(self) -> float:
        """Return the present of the world."""
        real_s = time.monotonic()
        gap_s = real_s - self._last_s
        if gap_s > LONGEST_GAP_S:
            self._stalled_s, self._slip_before_s = self._last_s, self._slip_s
            self._slip_s += gap_s - LONGEST_GAP_S
        self._last_s = real_s
        return real_s - self._slip_s

    def past_s(self, wall_ns: int) -> float:
        """Return when something that carries a wall clock stamp was; never in the future."""
        now_s = self.now_s()
        real_s = self._last_s - max(0, time.time_ns() - wall_ns) / SECOND_NS
        before_s = min(real_s, self._stalled_s) - self._slip_before_s
        return min(now_s, max(real_s - self._slip_s, before_s))

    def coming_s(self, wall_ns: int) -> float:
        """Return when something that is to be at a wall clock time will be."""
        self.now_s()  # brings the slip up to date
        return (wall_ns - ahead_ns(time.time_ns, time.monotonic_ns)) / SECOND_NS - self._slip_s
