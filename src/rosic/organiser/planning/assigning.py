"""Which robot takes which task, so that all of it together costs least (scipy's assignment).

Priorities come before costs: what is urgent chooses first. Without scipy each task takes the best
robot that is left, one after another.
"""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.core.fleet.candidates import (
    asks_for,
    may,
    nearest_idle,
    refused_by_any,
    robot_cost,
    waiting_credit,
    way_cost,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rosic.core.fleet.candidates import RobotGlance
    from rosic.core.fleet.state import FleetState
    from rosic.core.fleet.task import Task, TaskId
    from rosic.core.robot.profile import RobotId

FORBIDDEN: Final = 1e9
"""A pair that must not be: dearer than all others together."""


class Assignment(NamedTuple):
    """Who is to be asked for what.

    Attributes:
        pairs: A task and its robot; each of them once.
        best: Nothing cheaper exists, priority by priority; False: the solver is not installed.
    """

    pairs: list[tuple[TaskId, RobotId]]
    best: bool


@cache
def load() -> None:
    """Load the solver, if there is one. It takes a second, so that no event loop should wait."""
    with suppress(ModuleNotFoundError):
        import_module("scipy.optimize")


def is_loaded() -> bool:
    """Whether `load` has nothing left to do."""
    return load.cache_info().currsize > 0


def assign(
    fleet: FleetState, levels: Iterable[Sequence[Task]], glances: Mapping[RobotId, RobotGlance],
    now_ns: int,
) -> Assignment:  # fmt: skip
    """Choose robots for the tasks that wait, as many as can be given now.

    Args:
        fleet: As it is now; not changed.
        levels: Tasks that may begin, the most urgent together, as `by_priority` returns them.
        glances: How each robot is.
        now_ns: Wall clock.
    """
    left = {robot: glance for robot, glance in glances.items() if glance.free}
    pairs: list[tuple[TaskId, RobotId]] = []
    best = True
    for tasks in levels:
        if not left:
            break
        found = _solved(fleet, tasks, left, now_ns)
        if found is None:
            best = False
            found = nearest_idle(fleet, tasks, left, now_ns)
        pairs += found
        for _, robot in found:
            del left[robot]
    return Assignment(pairs, best)


def _solved(
    fleet: FleetState, tasks: Sequence[Task], glances: Mapping[RobotId, RobotGlance], now_ns: int
) -> list[tuple[TaskId, RobotId]] | None:
    """Return the cheapest way, with as many tasks as can be; None without a solver."""
    try:
        from scipy.optimize import (  # noqa: PLC0415 - an extra, and slow to load
            linear_sum_assignment,
        )
    except ModuleNotFoundError:
        return None
    robots = list(glances.values())
    costs = list(_costs(fleet, tasks, robots, now_ns))
    rows, columns = linear_sum_assignment(costs)
    return [
        (tasks[row].id, robots[column].robot)
        for row, column in zip(rows.tolist(), columns.tolist(), strict=True)
        if costs[row][column] < FORBIDDEN
    ]


def _costs(
    fleet: FleetState, tasks: Sequence[Task], robots: Sequence[RobotGlance], now_ns: int
) -> Iterator[list[float]]:
    """Yield a row of costs for each task; what may not be is forbidden.

    Tasks that ask for the same are looked at once. A place is the only thing that makes a cost of
    the pair more than a cost of each.
    """
    declined, seen = refused_by_any(robots), dict[tuple[object, ...], list[float]]()
    for task in tasks:
        alike = asks_for(task, declined)
        own = seen.get(alike)
        if own is None:
            own = seen[alike] = _own(fleet, task, robots)
        credit = waiting_credit(task, now_ns)
        yield [
            FORBIDDEN if cost == FORBIDDEN else cost + way_cost(task, glance) - credit
            for cost, glance in zip(own, robots, strict=True)
        ]


def _own(fleet: FleetState, task: Task, robots: Sequence[RobotGlance]) -> list[float]:
    left = frozenset(task.left)
    return [
        robot_cost(glance) if glance.robot in left and may(fleet, task, glance) else FORBIDDEN
        for glance in robots
    ]
