"""A lab's week, twenty people and three robots: the proposed plan beside the order of arrival.

``python -m rosic.bench.schedule`` prints the table of docs/scheduling.md; ``rosic bench schedule``
tells how long planning takes, and with ``--json`` also all the figures.
"""

from __future__ import annotations

import argparse
import sys
from random import Random
from statistics import mean
from time import perf_counter_ns
from typing import TYPE_CHECKING, TypeVar

import msgspec

from rosic.bench.report import BenchCase, BenchReport, case_of, machine
from rosic.core.time_units import MINUTE_NS
from rosic.organiser.planning.figures import PlanMetrics, figures_of
from rosic.organiser.planning.greedy import first_come_first_served
from rosic.organiser.planning.problem import PlanningProblem, Wish
from rosic.organiser.planning.solver import LIMIT_S, propose

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.bench.recorder import BenchRecorder
    from rosic.organiser.planning.problem import Proposal


T = TypeVar("T")

PEOPLE = 20
ROBOTS = ("omni", "kuka1", "yumi")
WISHES = 150
SEEDS = 20
QUICK_SEEDS, QUICK_LIMIT_S = 2, 2.0

MONDAY_MIN = 20_759 * 24 * 60  # 2026-11-02, UTC
DAYS, OPENS_H, CLOSES_H = 5, 9, 19
# Each with its weight: most wishes are for an hour or less, at eleven or in the afternoon, for one
# certain robot; some would take either of the arms.
LENGTHS_MIN = {15: 2, 30: 4, 45: 3, 60: 6, 90: 3, 120: 2}
HOURS = {9: 2, 10: 4, 11: 5, 12: 3, 13: 1, 14: 5, 15: 5, 16: 4, 17: 2, 18: 1}
CHOICES = {("omni",): 4, ("kuka1",): 3, ("yumi",): 2, ("kuka1", "yumi"): 3}
WINDOWS = {"hour": 45, "half day": 35, "day": 13, "days": 7}
PRIORITY = {1: 8, 2: 2, 3: 1}

METHOD = (
    "Planning a week of {wishes} wishes by {people} people for {robots} robots ({weeks} generated "
    "weeks, at most {limit_s:.0f} s for the solver). Times: one whole plan. Rate: plans a second."
)


class PlanningWeek(msgspec.Struct, frozen=True, kw_only=True):
    """One generated week, planned in two ways.

    Attributes:
        gap: How far the plan may be from the best there is, as a share; None when unknown.
        took_ns: By arrival, and by the solver.
        same_wait_min: Mean waiting of the wishes that both grant, by arrival and proposed.
    """

    seed: int
    grid_s: int
    arrival: PlanMetrics
    proposed: PlanMetrics
    gap: float | None
    took_ns: tuple[int, int]
    same_wait_min: tuple[float, float]


class PlanningCase(BenchCase, frozen=True, kw_only=True):
    """One way of planning: how long it took, and the mean of each figure over the weeks."""

    figures: dict[str, float]


def generated_week(seed: int, *, wishes: int = WISHES, people: int = PEOPLE) -> PlanningProblem:
    """Return a week as a lab might wish for it; the same seed gives the same week."""
    chance = Random(seed)  # noqa: S311 - a made-up week, nothing to guess
    opens = [MONDAY_MIN + day * 24 * 60 + OPENS_H * 60 for day in range(DAYS)]
    open_min = (CLOSES_H - OPENS_H) * 60
    return PlanningProblem(
        wishes=tuple(_wish(chance, f"{n:03}", people, opens, open_min) for n in range(wishes)),
        robots=ROBOTS,
        openings=tuple((at * MINUTE_NS, (at + open_min) * MINUTE_NS) for at in opens),
    )


def _wish(chance: Random, name: str, people: int, opens: Sequence[int], open_min: int) -> Wish:
    length_min = _one(chance, LENGTHS_MIN)
    earliest, latest = _window(chance, length_min, opens, open_min)
    return Wish(
        id=name,
        principal=f"p{chance.randrange(people):02}",
        robots=_one(chance, CHOICES),
        length_s=length_min * 60,
        earliest_ns=earliest * MINUTE_NS,
        latest_ns=latest * MINUTE_NS,
        priority=_one(chance, PRIORITY),
    )


def _window(
    chance: Random, length_min: int, opens: Sequence[int], open_min: int
) -> tuple[int, int]:
    """Return earliest and latest, in minutes: about an hour, half a day, a day, two or three."""
    day = chance.randrange(len(opens))
    kind = _one(chance, WINDOWS)
    if kind == "hour":
        start = (_one(chance, HOURS) - OPENS_H) * 60 + chance.choice((0, 15, 30, 45))
        start = min(start, open_min - length_min)
        return opens[day] + start, opens[day] + min(
            start + length_min + chance.choice((0, 30, 60)), open_min
        )
    if kind == "half day":
        noon = 4 * 60
        return (
            (opens[day], opens[day] + noon)
            if chance.random() < 0.45  # noqa: PLR2004 - nearly half of them
            else (
                opens[day] + noon,
                opens[day] + open_min,
            )
        )
    last = day if kind == "day" else min(day + chance.choice((1, 2)), len(opens) - 1)
    return opens[day], opens[last] + open_min


def compare(seed: int, *, limit_s: float = LIMIT_S, wishes: int = WISHES) -> PlanningWeek:
    """Plan one generated week in both ways, on the same grid."""
    problem = generated_week(seed, wishes=wishes)
    began = perf_counter_ns()
    proposal = propose(problem, limit_s=limit_s)
    solved = perf_counter_ns()
    arrival = first_come_first_served(problem, grid_s=proposal.grid_s)
    served = perf_counter_ns()
    return PlanningWeek(
        seed=seed,
        grid_s=proposal.grid_s,
        arrival=figures_of(problem, arrival),
        proposed=figures_of(problem, proposal),
        gap=proposal.gap,
        took_ns=(served - solved, solved - began),
        same_wait_min=_same_wait_min(arrival, proposal),
    )


def _same_wait_min(arrival: Proposal, proposal: Proposal) -> tuple[float, float]:
    first = {a.wish.id: a.wait_min for a in arrival.allocations}
    second = {a.wish.id: a.wait_min for a in proposal.allocations}
    both = first.keys() & second.keys()
    return mean(first[wish] for wish in both), mean(second[wish] for wish in both)


def report(
    seeds: Iterable[int] = range(SEEDS), *, limit_s: float = LIMIT_S
) -> tuple[PlanningWeek, ...]:
    """Plan generated weeks in both ways."""
    return tuple(compare(seed, limit_s=limit_s) for seed in seeds)


def measure(recorder: BenchRecorder) -> BenchReport:
    """Return what ``rosic bench schedule`` prints."""
    seeds, limit_s = (QUICK_SEEDS, QUICK_LIMIT_S) if recorder.quick else (SEEDS, LIMIT_S)
    weeks: list[PlanningWeek] = []
    recorder.report_by(lambda: _report(weeks, limit_s))
    with recorder.turn("weeks"):
        for seed in range(seeds):
            weeks += report((seed,), limit_s=limit_s)
    return _report(weeks, limit_s)


def _report(weeks: Sequence[PlanningWeek], limit_s: float) -> BenchReport:
    """Return what weeks come to, as many as there are."""
    cases: list[BenchCase] = []
    for name, index in (("order of arrival", 0), ("proposed plan", 1)) if weeks else ():
        times = [week.took_ns[index] for week in weeks]
        case = case_of(name, [(1e9 / mean(times), times)])
        plans = [week.proposed if index else week.arrival for week in weeks]
        averages = {
            figure: round(mean(getattr(plan, figure) for plan in plans), 4)
            for figure in PlanMetrics.__struct_fields__
        }
        cases.append(PlanningCase(**msgspec.structs.asdict(case), figures=averages))
    method = METHOD.format(
        wishes=WISHES, people=PEOPLE, robots=len(ROBOTS), weeks=len(weeks), limit_s=limit_s
    )
    return BenchReport(machine=machine(), method=method, cases=tuple(cases))


class FigureRow(msgspec.Struct, frozen=True):
    """How one figure is shown."""

    figure: str
    title: str
    more_is_better: bool
    digits: int
    factor: float = 1.0


ROWS = (
    FigureRow("granted", "wishes granted", True, 1),
    FigureRow("use", "use of the open hours, %", True, 1, 100),
    FigureRow("idle_h", "idle, robot hours", False, 1),
    FigureRow("between_h", "of it between slots, hours", False, 1),
    FigureRow("breaks", "separate stretches of use", False, 1),
    FigureRow("wait_mean_min", "mean waiting of all it grants, min", False, 0),
    FigureRow("wait_worst_min", "worst waiting, min", False, 0),
    FigureRow("fairness", "fairness (Jain)", True, 3),
    FigureRow("least_share", "share of whoever gets least", True, 2),
    FigureRow("score", "score", True, 0),
    FigureRow("conflicts", "conflicts", False, 0),
)
SAME = FigureRow("", "mean waiting of what both grant, min", False, 0)
CLOSE = 1e-9


def as_table(weeks: Sequence[PlanningWeek]) -> str:
    """Return the means over the weeks, and in how many weeks which way was the better one."""
    lines = [
        "| mean of the weeks | by arrival | proposed | better by arrival | better proposed |",
        "|---|---|---|---|---|",
    ]
    for row in ROWS:
        pairs = [(getattr(w.arrival, row.figure), getattr(w.proposed, row.figure)) for w in weeks]
        lines.append(_line(row, pairs))
    lines.append(_line(SAME, [week.same_wait_min for week in weeks]))
    return "\n".join(lines)


def _line(row: FigureRow, pairs: Sequence[tuple[float, float]]) -> str:
    sign = 1 if row.more_is_better else -1
    arrival, proposed = (mean(pair[i] for pair in pairs) * row.factor for i in (0, 1))
    better = [sum(sign * (one - other) > CLOSE for one, other in pairs) for sign in (sign, -sign)]
    return (
        f"| {row.title} | {arrival:.{row.digits}f} | {proposed:.{row.digits}f} "
        f"| {better[0]} | {better[1]} |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m rosic.bench.schedule", description=__doc__)
    parser.add_argument("--weeks", type=int, default=SEEDS)
    parser.add_argument("--limit-s", type=float, default=LIMIT_S)
    chosen = parser.parse_args()
    weeks = report(range(chosen.weeks), limit_s=chosen.limit_s)
    gaps = [1.0 if week.gap is None else week.gap for week in weeks]
    times = sorted(week.took_ns[1] / 1e9 for week in weeks)
    sys.stdout.write(
        f"{machine()}\n{len(weeks)} weeks of {WISHES} wishes by {PEOPLE} people for {len(ROBOTS)} "
        f"robots, grid {weeks[0].grid_s // 60} min.\n\n{as_table(weeks)}\n\n"
        f"Proved best in {sum(week.gap is not None and week.gap < 1e-4 for week in weeks)} weeks; "  # noqa: PLR2004
        f"at most {100 * max(gaps):.1f} % may be missing in the others.\n"
        f"Solver: median {times[len(times) // 2]:.1f} s, longest {times[-1]:.1f} s.\n"
    )


def _one(chance: Random, weights: Mapping[T, int]) -> T:
    return chance.choices(list(weights), list(weights.values()))[0]


if __name__ == "__main__":
    main()
