"""Whether everything that was asked has ended and was told: what a script waits for."""

from __future__ import annotations

import asyncio
import gc
from datetime import datetime, tzinfo
from typing import TYPE_CHECKING, Any, TypeVar

from rosic.core.fleet.candidates import fits
from rosic.core.fleet.task import FleetMembership
from rosic.core.rate_limit import RateLimit
from rosic.core.time_units import SECOND_NS
from rosic.features.fleet import FleetFeature

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine

    from rosic.app.gateway import Gateway
    from rosic.contracts.clock import Clock
    from rosic.core.fleet.task import Task
    from rosic.core.order_status import Face


# ---- whether all has ended ----

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
    fleet = gateway.features.get(FleetFeature).dispatching.fleet
    return bool(fleet.holds) or any(_begins(gateway, fleet.tasks[key]) for key in fleet.waiting)


def _begins(gateway: Gateway, task: Task) -> bool:
    """Whether some robot will begin a task once it is free; one that is stopped never is."""
    rooms, fleet = gateway.rooms, gateway.features.get(FleetFeature)
    state, candidate = fleet.dispatching.fleet, fleet.watching.candidate
    return state.ready(task) and any(
        not rooms.stops[robot].latched
        and state.standing(robot) is FleetMembership.ACTIVE
        and rooms.linker.presence(robot).online is not False
        and fits(task, candidate(robot))
        for robot in task.left
    )


# ---- the garbage collector ----

# The collector looks for cycles among young objects whenever so many more were made than freed.
# A command makes some fifty objects and no cycle: at the usual 700 it would look every dozen
# commands. What may lie about uncollected meanwhile is a few megabytes.
YOUNG, MIDDLE, OLD = 50_000, 20, 50


def settle() -> None:
    """Leave what was made at start alone from now on, and look for cycles less often."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(YOUNG, MIDDLE, OLD)


# ---- the event loop ----

T = TypeVar("T")


def _factory() -> Callable[[], asyncio.AbstractEventLoop] | None:
    try:
        from uvloop import new_event_loop  # noqa: PLC0415  optional, and only a gateway needs it
    except ImportError:
        return None
    return new_event_loop


def run(main: Coroutine[Any, Any, T]) -> T:
    """Run to its end, as ``asyncio.run`` does."""
    with asyncio.Runner(loop_factory=_factory()) as runner:
        return runner.run(main)


def name() -> str:
    """Return which loop ``run`` takes, for a report."""
    return "asyncio" if _factory() is None else "uvloop"


# ---- the time of day in the place's zone ----


def face_of(zone: tzinfo | None = None) -> Face:
    """Return a function from wall clock nanoseconds to ``14:02:07``.

    Args:
        zone: None takes the machine's own.
    """
    shown_second = -1
    shown = ""

    def face(at_ns: int) -> str:
        # Many lives step within one second: the text of that second is made once.
        nonlocal shown_second, shown
        second = at_ns // SECOND_NS
        if second != shown_second:
            shown = datetime.fromtimestamp(second, zone).astimezone(zone).strftime("%H:%M:%S")
            shown_second = second
        return shown

    return face
