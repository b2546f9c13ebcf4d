"""Run machines without waiting: for tests, and for demonstrations that need no clock."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic_sim.robots.machines.activity import Activity
    from rosic_sim.robots.machines.machine import Machine

TICK_S = 0.02


def to_end(machine: Machine, now_s: float, limit_s: float = 120.0) -> float:
    """Step one machine until its activity has ended; return the time then.

    Raises:
        TimeoutError: It has not ended after ``limit_s`` of simulated time.
    """
    activity: Activity | None = machine.activity
    end_s = now_s + limit_s
    while activity is not None and activity.running:
        if now_s >= end_s:
            raise TimeoutError(f"{machine.id}: {activity.skill} has not ended in {limit_s:g} s")
        now_s += TICK_S
        machine.step(now_s)
    return now_s


def to_rest(machine: Machine, now_s: float, limit_s: float = 60.0) -> float:
    """Step one machine until it is at rest and its activity has ended; return the time then.

    Raises:
        TimeoutError: It is not at rest after ``limit_s`` of simulated time.
    """
    end_s = now_s + limit_s
    while machine.moving or not machine.at_rest():
        if now_s >= end_s:
            raise TimeoutError(f"{machine.id}: not at rest after {limit_s:g} s")
        now_s += TICK_S
        machine.step(now_s)
    return now_s
