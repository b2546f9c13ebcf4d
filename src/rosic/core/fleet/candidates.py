"""Who could carry out what now, and what it would cost; choosing the best of it is a solver's."""

from __future__ import annotations

from math import hypot
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.fleet.task import FleetMembership, Task, TaskId
from rosic.core.identity import PrincipalId
from rosic.core.robot.profile import RobotId

if TYPE_CHECKING:
    from collections.abc import Container, Iterable, Mapping

    from rosic.core.fleet.state import FleetState

# Everything is counted in metres of way.
EMPTY_BATTERY_M: Final = 20.0
"""What an empty battery costs beside a full one."""
LOAD_M: Final = 2.0
"""What each task of late costs, so that the same robot is not always the nearest."""
UNKNOWN_WAY_M: Final = 10.0
UNKNOWN_BATTERY: Final = 50.0
WAITING_M_S: Final = 0.05
"""What a second of waiting is worth: no task waits for ever because it is far away."""


class CandidateRobot(msgspec.Struct, frozen=True, kw_only=True):
    """What a look at one robot showed.

    Attributes:
        free: It is there, not stopped, does nothing for anybody, and is not known to move.
        holder: Who has it, or whose time it is; None: nobody.
        battery: In percent; None when it does not say.
        place: Where it is, in m; None when it does not know.
        load: Tasks that it carried out of late.
        declined: Tasks that it has refused, and is not asked again yet.
    """

    robot: RobotId
    free: bool = True
    holder: PrincipalId | None = None
    battery: float | None = None
    place: tuple[float, float] | None = None
    load: float = 0.0
    declined: frozenset[TaskId] = frozenset()


def may(fleet: FleetState, task: Task, candidate: CandidateRobot) -> bool:
    """Whether a robot that can carry out a task may be asked now, as far as can be seen."""
    robot = candidate.robot
    if not candidate.free or robot in fleet.holds or task.id in candidate.declined:
        return False
    if candidate.holder is not None and candidate.holder != task.author:
        return False  # somebody's time is nobody else's to spend
    if fleet.standing(robot) is not FleetMembership.ACTIVE:
        return False
    return fits(task, candidate)


def fits(task: Task, candidate: CandidateRobot) -> bool:
    """Whether a robot has what a task needs before it begins."""
    need = task.need
    if need.localised and candidate.place is None:
        return False
    return not need.battery or (candidate.battery is not None and candidate.battery >= need.battery)


def cost(task: Task, candidate: CandidateRobot, now_ns: int) -> float:
    """Return what it costs to let a robot carry out a task, in metres of way; may be negative."""
    return robot_cost(candidate) + way_cost(task, candidate) - waiting_credit(task, now_ns)


def robot_cost(candidate: CandidateRobot) -> float:
    """Return what a robot costs whatever it does: its battery, and what it has done of late."""
    battery = UNKNOWN_BATTERY if candidate.battery is None else candidate.battery
    return EMPTY_BATTERY_M * (1.0 - battery / 100.0) + LOAD_M * candidate.load


def way_cost(task: Task, candidate: CandidateRobot) -> float:
    """Return the way to a task."""
    if task.place is None or candidate.place is None:
        return UNKNOWN_WAY_M
    return hypot(task.place[0] - candidate.place[0], task.place[1] - candidate.place[1])


def waiting_credit(task: Task, now_ns: int) -> float:
    """Return what it is worth that a task has waited."""
    return WAITING_M_S * max(0, now_ns - task.given_ns) / 1e9


def by_priority(
    fleet: FleetState,
    candidates: Mapping[RobotId, CandidateRobot],
    now_ns: int,
    *,
    leave: Container[TaskId] = (),
    at_most: int = 10_000,
) -> list[list[Task]]:
    """Return the tasks that may begin now, the most urgent together, the oldest first.

    One that no robot can begin now is left out, so that it keeps none waiting that could begin.

    Args:
        fleet: As it is now.
        candidates: How each robot is that may be asked.
        now_ns: Wall clock.
        leave: Tasks that are not to be given now.
        at_most: So many altogether, the most urgent ones.
    """
    levels: dict[int, list[Task]] = {}
    declined, seen = refused_by_any(candidates.values()), dict[tuple[object, ...], bool]()
    for key in fleet.waiting:
        task = fleet.tasks[key]
        if key in leave or task.too_late(now_ns) or not fleet.ready(task):
            continue
        alike = asks_for(task, declined)
        if alike not in seen:
            seen[alike] = _anybody(fleet, task, candidates)
        if seen[alike]:
            levels.setdefault(task.priority, []).append(task)
    found: list[list[Task]] = []
    for priority in sorted(levels, reverse=True):
        found.append(levels[priority][:at_most])
        at_most -= len(found[-1])
    return [level for level in found if level]


def _anybody(fleet: FleetState, task: Task, candidates: Mapping[RobotId, CandidateRobot]) -> bool:
    """Whether some robot may be asked now."""
    return any(robot in candidates and may(fleet, task, candidates[robot]) for robot in task.left)


def refused_by_any(candidates: Iterable[CandidateRobot]) -> frozenset[TaskId]:
    """Return every task that some robot is not asked again yet."""
    return frozenset[TaskId]().union(*(candidate.declined for candidate in candidates))


def asks_for(task: Task, declined: Container[TaskId]) -> tuple[object, ...]:
    """Return what a task asks for: those that ask for the same are looked at once.

    Args:
        task: Which.
        declined: Tasks that some robot is not asked again yet; each of them is unlike the others.
    """
    own = task.id if task.id in declined else ""
    return task.author, task.among, task.tried, task.need, own


def nearest_idle(
    fleet: FleetState,
    tasks: Iterable[Task],
    candidates: Mapping[RobotId, CandidateRobot],
    now_ns: int,
) -> list[tuple[TaskId, RobotId]]:
    """Give each task, one after another, the best robot that is left: simple, and often good."""
    left = dict(candidates)
    chosen: list[tuple[TaskId, RobotId]] = []
    for task in tasks:
        able = [left[r] for r in task.left if r in left and may(fleet, task, left[r])]
        if able:
            best = min(able, key=lambda candidate: cost(task, candidate, now_ns))
            chosen.append((task.id, best.robot))
            del left[best.robot]
    return chosen
