"""Being given the processor at once when a moment comes that others rely on."""

from __future__ import annotations

import os


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
