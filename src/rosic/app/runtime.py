"""Whether everything that was asked has ended and was told: what a script waits for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.fleet.candidates import fits
from rosic.core.fleet.task import FleetMembership
from rosic.core.rate_limit import RateLimit

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Callable

    from rosic.app.gateway import Gateway
    from rosic.contracts.clock import Clock
    from rosic.core.fleet.task import Task

EVERY_S = 0.02
PIPED = RateLimit(burst=100_000.0, per_s=1_000.0)
"""Of whoever wrote a script: it waits for each line anyway, and an answer that is left out because
it came too fast would be missed by nobody until it matters."""


async def until_quiet(gateway: Gateway, clock: Clock, *, seconds: float) -> bool:
    """Wait until everything has ended and was told. Return whether it has, in time."""
    return await _until(lambda: gateway.quiet, clock, seconds)


async def until_done(
    gateway: Gateway, clock: Clock, *, seconds: float, unless: asyncio.Event
) -> bool:
    """Wait likewise, and for every task that goes on by itself. Return whether all is done.

    Args:
        gateway: Running.
        clock: Of the seconds.
        seconds: At most.
        unless: Set it, and nothing is waited for any more.
    """

    def holds() -> bool:
        return unless.is_set() or (gateway.quiet and not tasks_go_on(gateway))

    return await _until(holds, clock, seconds)


async def _until(holds: Callable[[], bool], clock: Clock, seconds: float) -> bool:
    deadline_ns = clock.monotonic_ns() + int(seconds * 1e9)
    while not holds():
        if clock.monotonic_ns() > deadline_ns:
            return False
        await clock.sleep(EVERY_S)
    return True


def tasks_go_on(gateway: Gateway) -> bool:
    """Whether a task is carried out, or could be without anybody saying anything more."""
    fleet = gateway.furnishing.fleet.dispatching.fleet
    return bool(fleet.holds) or any(_begins(gateway, fleet.tasks[key]) for key in fleet.waiting)


def _begins(gateway: Gateway, task: Task) -> bool:
    """Whether some robot will begin a task once it is free; one that is stopped never is."""
    rooms, fleet = gateway.rooms, gateway.furnishing.fleet
    state, glance = fleet.dispatching.fleet, fleet.watching.glance
    return state.ready(task) and any(
        not rooms.board[robot].latched
        and state.standing(robot) is FleetMembership.ACTIVE
        and rooms.linker.presence(robot).online is not False
        and fits(task, glance(robot))
        for robot in task.left
    )
