"""The best allocation there is, by mixed-integer programming (HiGHS). The one home of scipy.

For every wish and every place where it could go there is one yes-or-no variable. A wish is
granted once at most; wherever a slot could begin, a robot and a person have one slot at most.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from contextlib import suppress
from functools import cache
from importlib import import_module
from math import inf
from typing import TYPE_CHECKING, Final, Literal, NamedTuple

import msgspec

from rosic.core.fleet.candidates import (
    asks_for,
    may,
    nearest_idle,
    refused_by_any,
    robot_cost,
    waiting_credit,
    way_cost,
)
from rosic.organiser.planning.greedy import (
    FreeTime,
    count_places,
    fill,
    first_come_first_served,
    grid_for,
    proposal_of,
)
from rosic.organiser.planning.problem import BREAK_MIN, PlanCaveat, broken_rules, merged, worth

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rosic.core.fleet.candidates import CandidateRobot
    from rosic.core.fleet.state import FleetState
    from rosic.core.fleet.task import Task, TaskId
    from rosic.core.robot.profile import RobotId
    from rosic.organiser.planning.problem import Allocation, PlanningProblem, Proposal, Span

LIMIT_S = 10.0
MOST_PLACES = 60_000
"""Beyond this, only setting the problem up takes longer than anybody waits."""

PROVEN = 1e-4
"""A share of the score that is not worth another second."""


class FoundPlan(NamedTuple):
    """What the solver said.

    Attributes:
        chosen: Indices of places, or None when it found nothing in its time.
        bound: No choice is worth more.
    """

    chosen: list[int] | None
    bound: float | None


def propose(
    problem: PlanningProblem, *, limit_s: float = LIMIT_S, grid_s: int | None = None
) -> Proposal:
    """Return the best allocation found in a bounded time; at least as good as by arrival.

    It computes for seconds: call it in a thread of its own. The solver lets other threads run.

    Args:
        problem: Wishes in the order of arrival, and what stands against them.
        limit_s: The solver's time. When it is over, the best plan so far is returned, and
            ``Proposal.gap`` says how far from the best it may be.
        grid_s: What slots start on; None chooses by size.

    Returns:
        Without scipy, or for more places than can be weighed: the order of arrival, and a note
        that says so.
    """
    grid_s = grid_s or grid_for(problem)
    by_arrival = first_come_first_served(problem, grid_s=grid_s)
    if count_places(problem, grid_s, MOST_PLACES) > MOST_PLACES:
        return msgspec.structs.replace(by_arrival, note=PlanCaveat.TOO_MANY)
    free = FreeTime(problem)
    places = [place for wish in problem.wishes for place in free.places(wish, grid_s)]
    if not places:
        return msgspec.structs.replace(by_arrival, solved=True, bound=by_arrival.parts.score)
    try:
        found = _solve(_Model(problem, places), limit_s)
    except ModuleNotFoundError:
        return msgspec.structs.replace(by_arrival, note=PlanCaveat.NO_SOLVER)
    return _better(problem, by_arrival, found, [places[i] for i in found.chosen or ()])


def _better(
    problem: PlanningProblem, by_arrival: Proposal, found: FoundPlan, chosen: Sequence[Allocation]
) -> Proposal:
    """Return the better of two plans; what the solver says is checked before it is believed."""
    best, solved = by_arrival, False
    if found.chosen is not None and not broken_rules(problem, chosen):
        # A plan that ran out of time may have left room; granting a wish never makes it worse.
        full = proposal_of(problem, fill(problem, chosen, by_arrival.grid_s), by_arrival.grid_s)
        if full.parts.score >= by_arrival.parts.score:
            best, solved = full, True
    bound = None if found.bound is None else max(found.bound, best.parts.score)
    best = msgspec.structs.replace(best, solved=solved, bound=bound)
    proven = best.gap is not None and best.gap <= PROVEN
    if proven:
        return best
    return msgspec.structs.replace(
        best, note=PlanCaveat.NOT_PROVEN if solved else PlanCaveat.NOTHING_FOUND
    )


class _Model:
    """The variables, and the rows of a sparse matrix. One column a place, then the breaks."""

    def __init__(self, problem: PlanningProblem, places: Sequence[Allocation]) -> None:
        self.costs = [-worth(place.wish, place.start_ns) for place in places]
        self.places = len(places)
        self.row_count = 0
        self.rows: list[int] = []
        self.columns: list[int] = []
        self.values: list[float] = []
        self.upper: list[float] = []
        by_wish: defaultdict[str, list[int]] = defaultdict(list)
        by_person: defaultdict[str, list[int]] = defaultdict(list)
        by_robot: dict[RobotId, list[int]] = {robot: [] for robot in problem.robots}
        for column, place in enumerate(places):
            by_wish[place.wish.id].append(column)
            by_person[place.wish.principal].append(column)
            by_robot[place.robot].append(column)
        for columns in by_wish.values():
            self._row([(column, 1.0) for column in columns], 1.0)
        for columns in by_person.values():
            if len({places[column].wish.id for column in columns}) > 1:
                self._one_at_a_time(places, columns)
        for robot, columns in by_robot.items():
            self._one_at_a_time(places, columns)
            stands = [(b.start_ns, b.end_ns) for b in problem.booked if b.robot == robot]
            self._breaks(places, columns, merged(stands))

    def _row(self, entries: Iterable[tuple[int, float]], upper: float) -> None:
        for column, value in entries:
            self.rows.append(self.row_count)
            self.columns.append(column)
            self.values.append(value)
        self.upper.append(upper)
        self.row_count += 1

    def _one_at_a_time(self, places: Sequence[Allocation], columns: Sequence[int]) -> None:
        """Slots are apart if and only if, where any one begins, no other is under way."""
        moments = sorted({places[column].start_ns for column in columns})
        under_way: list[list[tuple[int, float]]] = [[] for _ in moments]
        for column in columns:
            place = places[column]
            first = bisect_left(moments, place.start_ns)
            for at in range(first, bisect_left(moments, place.end_ns)):
                under_way[at].append((column, 1.0))
        for entries in under_way:
            self._row(entries, 1.0)

    def _breaks(
        self, places: Sequence[Allocation], columns: Sequence[int], stands: Sequence[Span]
    ) -> None:
        """What begins where nothing ends begins after a break: one more column for each."""
        change: defaultdict[int, list[tuple[int, float]]] = defaultdict(list)
        booked: defaultdict[int, float] = defaultdict(float)
        begins: set[int] = set()
        for begin, end in stands:
            begins.add(begin)
            booked[begin] -= 1.0
            booked[end] += 1.0
        for column in columns:
            begins.add(places[column].start_ns)
            change[places[column].start_ns].append((column, 1.0))
            change[places[column].end_ns].append((column, -1.0))
        for moment in sorted(begins):
            self.costs.append(BREAK_MIN)
            self._row([*change[moment], (len(self.costs) - 1, -1.0)], booked[moment])


def _solve(model: _Model, limit_s: float) -> FoundPlan:
    """Hand a model to HiGHS.

    Raises:
        ModuleNotFoundError: scipy is not installed.
    """
    from scipy.optimize import (  # noqa: PLC0415 - an extra, and slow to load
        Bounds,
        LinearConstraint,
        milp,
    )
    from scipy.sparse import coo_array  # noqa: PLC0415 - an extra, and slow to load

    width = len(model.costs)
    whole: list[Literal[0, 1]] = [1 if i < model.places else 0 for i in range(width)]
    matrix = coo_array(
        (model.values, (model.rows, model.columns)), shape=(model.row_count, width)
    ).tocsr()
    result = milp(
        model.costs,
        integrality=whole,
        bounds=Bounds([0.0] * width, [1.0] * width),
        constraints=LinearConstraint(matrix, -inf, model.upper),
        options={"time_limit": limit_s, "mip_rel_gap": PROVEN / 2},
    )
    bound = None if result.mip_dual_bound is None else -float(result.mip_dual_bound)
    if result.x is None:
        return FoundPlan(None, bound)
    return FoundPlan([i for i in range(model.places) if result.x[i] > 0.5], bound)  # noqa: PLR2004


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
    fleet: FleetState,
    levels: Iterable[Sequence[Task]],
    glances: Mapping[RobotId, CandidateRobot],
    now_ns: int,
) -> Assignment:
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
    fleet: FleetState, tasks: Sequence[Task], glances: Mapping[RobotId, CandidateRobot], now_ns: int
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
    fleet: FleetState, tasks: Sequence[Task], robots: Sequence[CandidateRobot], now_ns: int
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


def _own(fleet: FleetState, task: Task, robots: Sequence[CandidateRobot]) -> list[float]:
    left = frozenset(task.left)
    return [
        robot_cost(glance) if glance.robot in left and may(fleet, task, glance) else FORBIDDEN
        for glance in robots
    ]
