"""A process of robots has priority only while it is urgent, and none where it is not granted."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

from rosic_sim.ros2.waiting_clock import RealtimePriority


def policies(*, wanted: bool) -> tuple[RealtimePriority, list[int]]:
    """Return what the system makes of a thread that is urgent, and is not any more."""
    urgency = RealtimePriority(wanted=wanted)

    def live() -> list[int]:
        seen = [os.sched_getscheduler(0)]
        for urgent in (True, True, False):
            urgency.be(urgent)
            seen.append(os.sched_getscheduler(0))
        return seen

    with ThreadPoolExecutor(1) as pool:
        return urgency, pool.submit(live).result()


def test_priority_lasts_while_it_is_urgent_if_the_system_grants_it() -> None:
    urgency, (before, urgent, still, after) = policies(wanted=True)

    granted = os.SCHED_FIFO if urgency.wanted else before
    assert (urgent, still, after) == (granted, granted, before)


def test_who_was_not_asked_to_be_punctual_asks_for_nothing() -> None:
    _, seen = policies(wanted=False)

    assert len(set(seen)) == 1
