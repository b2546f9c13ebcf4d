"""``rosic bench fleet``: choosing robots for tasks, and what ever more robots and people cost."""

from __future__ import annotations

from itertools import permutations
from random import Random
from statistics import mean
from time import perf_counter_ns
from typing import TYPE_CHECKING

import msgspec

from rosic.bench import scaling
from rosic.bench.report import BenchCase, BenchReport, case_of, machine
from rosic.core.fleet.candidates import CandidateRobot, by_priority, cost, nearest_idle
from rosic.core.fleet.events import TaskGiven
from rosic.core.fleet.state import FleetState
from rosic.core.fleet.task import Task
from rosic.core.fleet.transitions import react
from rosic.core.robot.profile import RobotId
from rosic.organiser.planning.solver import assign

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.bench.recorder import BenchRecorder
    from rosic.core.fleet.task import TaskId


TASKS, ROBOTS = 1_000, 200
SMALL = 6  # so few that every way of assigning them can be tried
RUNS, QUICK_RUNS = 10, 2
SMALL_RUNS, QUICK_SMALL_RUNS = 50, 5
SIDE_M = 100.0
NOW_NS = 1_800_000_000_000_000_000
METHOD = (
    "Assigning tasks to robots by way, battery, load and waiting, on a floor of 100 m by 100 m "
    "({runs} generated floors; {small} small ones). Times: one whole assignment. Rate: assignments "
    "a second. Beside each way, what its choice costs on the average, a pair, in metres of way."
)


class AssignmentCase(BenchCase, frozen=True, kw_only=True):
    """One way of assigning, and what it chose.

    Attributes:
        pairs: How many tasks got a robot, on the average.
    """

    pairs: float


class AssignmentLoad(msgspec.Struct, frozen=True):
    """Tasks that wait, and robots that are free."""

    fleet: FleetState
    glances: dict[RobotId, CandidateRobot]

    def cost_m(self, pairs: Sequence[tuple[TaskId, RobotId]]) -> float:
        """Return the mean cost of a pair."""
        tasks, glances = self.fleet.tasks, self.glances
        return mean(cost(tasks[task], glances[robot], NOW_NS) for task, robot in pairs)


def floor(seed: int, tasks: int, robots: int) -> AssignmentLoad:
    """Return a floor; the same seed gives the same."""
    chance = Random(seed)  # noqa: S311 - a made-up floor, nothing to guess
    names = [f"robot{n}" for n in range(robots)]
    glances = {
        name: CandidateRobot(
            robot=name,
            battery=chance.uniform(20, 100),
            place=(chance.uniform(0, SIDE_M), chance.uniform(0, SIDE_M)),
            load=chance.randrange(5),
        )
        for name in names
    }
    fleet = FleetState()
    for n in range(tasks):
        # Some tasks want one of a few; most are for any.
        among = tuple(names) if chance.random() < 0.8 else tuple(chance.sample(names, robots // 2))  # noqa: PLR2004
        task = Task(
            id=str(n + 1),
            author="p",
            among=among,
            given_ns=NOW_NS - chance.randrange(10**11),
            place=(chance.uniform(0, SIDE_M), chance.uniform(0, SIDE_M)),
        )
        for fact in fleet.facts(react(fleet, TaskGiven(task), NOW_NS)):
            fleet.apply(fact)
    return AssignmentLoad(fleet, glances)


def best_pairs(small: AssignmentLoad) -> list[tuple[TaskId, RobotId]]:
    """Try every way of assigning as many tasks as there are robots; return the cheapest."""
    [tasks] = by_priority(small.fleet, small.glances, NOW_NS)
    ways = (
        [(task.id, robot) for task, robot in zip(tasks, order, strict=True)]
        for order in permutations(small.glances)
        if all(robot in task.among for task, robot in zip(tasks, order, strict=True))
    )
    return min(ways, key=small.cost_m)


def _nearest(one: AssignmentLoad) -> list[tuple[TaskId, RobotId]]:
    [tasks] = by_priority(one.fleet, one.glances, NOW_NS)
    return nearest_idle(one.fleet, tasks, one.glances, NOW_NS)


def _solved(one: AssignmentLoad) -> list[tuple[TaskId, RobotId]]:
    return assign(one.fleet, by_priority(one.fleet, one.glances, NOW_NS), one.glances, NOW_NS).pairs


WAYS = {"solver": _solved, "nearest idle": _nearest, "every way tried": best_pairs}


def _case(name: str, way: str, floors: Sequence[AssignmentLoad]) -> AssignmentCase:
    times: list[int] = []
    pairs: list[int] = []
    costs: list[float] = []
    for one in floors:
        began = perf_counter_ns()
        found = WAYS[way](one)
        times.append(perf_counter_ns() - began)
        pairs.append(len(found))
        costs.append(one.cost_m(found))
    case = case_of(f"{name}: {way}", [(1e9 / mean(times), times)])
    known = msgspec.structs.asdict(case) | {"cost_m": round(mean(costs), 3)}
    return AssignmentCase(**known, pairs=round(mean(pairs), 1))


def measure(recorder: BenchRecorder) -> BenchReport:
    """Return what ``rosic bench fleet`` prints."""
    runs, small_runs = (QUICK_RUNS, QUICK_SMALL_RUNS) if recorder.quick else (RUNS, SMALL_RUNS)
    _solved(floor(0, 2, 2))  # the solver is loaded before anything is timed
    large = [floor(seed, TASKS, ROBOTS) for seed in range(runs)]
    small = [one for seed in range(small_runs) if _full(one := floor(seed, SMALL, SMALL))]
    cases = [
        case
        for name, ways, floors in (
            (f"{SMALL} to {SMALL}", tuple(WAYS), small),
            (f"{TASKS} to {ROBOTS}", ("solver", "nearest idle"), large),
        )
        for way in ways
        for case in recorder.see([_case(name, way, floors)])
    ]
    method = METHOD.format(runs=runs, small=len(small))
    how, crowded = scaling.measure(recorder)
    return BenchReport(machine=machine(), method=f"{method} {how}", cases=(*cases, *crowded))


def _full(one: AssignmentLoad) -> bool:
    """Whether each task can have a robot, so that ways may be compared by what they cost."""
    return all(len(way(one)) == SMALL for way in (_solved, _nearest))
