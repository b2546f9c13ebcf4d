"""What a plan does for a place, in figures that do not depend on what the plan was made for."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import msgspec

from rosic.core.time_units import HOUR_NS
from rosic.organiser.planning.greedy import FreeTime, without
from rosic.organiser.planning.problem import ALWAYS_NS, broken_rules, merged

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from rosic.organiser.planning.problem import PlanningProblem, Proposal, Span


class PlanMetrics(msgspec.Struct, frozen=True, kw_only=True):
    """One plan, measured.

    Attributes:
        use: Share of the time that was open and not booked, over all robots.
        idle_h: The rest of that time, in robot hours.
        between_h: The part of it between the first and the last slot of an opening.
        breaks: How often a robot goes from idle to used.
        wait_mean_min: Over the wishes granted, from the earliest wished start.
        wait_worst_min: The same, for the one who waits longest.
        fairness: Jain's index over each person's share: time granted by time wished.
        least_share: The share of whoever gets least.
        conflicts: Rules broken; anything but 0 is a fault.
        score: What the solver makes as large as it can.
    """

    wishes: int
    granted: int
    use: float
    idle_h: float
    between_h: float
    breaks: int
    wait_mean_min: float
    wait_worst_min: float
    fairness: float
    least_share: float
    conflicts: int
    score: float


def figures_of(problem: PlanningProblem, proposal: Proposal) -> PlanMetrics:
    """Measure a plan. A place that never closes is measured over the windows of its wishes."""
    free = _free_spans(problem)
    used = {
        robot: [(a.start_ns, a.end_ns) for a in proposal.allocations if a.robot == robot]
        for robot in problem.robots
    }
    idle = [span for robot in problem.robots for span in without(free[robot], used[robot])]
    total_ns = sum(_length(spans) for spans in free.values())
    used_ns = sum(_length(spans) for spans in used.values())
    waits = [a.wait_min for a in proposal.allocations] or [0.0]
    shares = shares_of(problem, proposal)
    return PlanMetrics(
        wishes=len(problem.wishes),
        granted=len(proposal.allocations),
        use=used_ns / total_ns if total_ns else 0.0,
        idle_h=_length(idle) / HOUR_NS,
        between_h=sum(_between(problem, free[r], used[r]) for r in problem.robots) / HOUR_NS,
        breaks=sum(len(merged(spans)) for spans in used.values()),
        wait_mean_min=sum(waits) / len(waits),
        wait_worst_min=max(waits),
        fairness=jain(shares),
        least_share=min(shares, default=1.0),
        conflicts=len(broken_rules(problem, proposal.allocations)),
        score=proposal.parts.score,
    )


def shares_of(problem: PlanningProblem, proposal: Proposal) -> list[float]:
    """Return, for each person who wishes, the share of the wished time that is granted."""
    wished: defaultdict[str, int] = defaultdict(int)
    granted: defaultdict[str, int] = defaultdict(int)
    for wish in problem.wishes:
        wished[wish.principal] += wish.length_s
    for allocation in proposal.allocations:
        granted[allocation.wish.principal] += allocation.wish.length_s
    return [granted[person] / wished[person] for person in wished]


def jain(shares: Sequence[float]) -> float:
    """Return Jain's index: 1 when all have the same share, 1/n when one has everything.

    R. Jain, D. Chiu, W. Hawe: A Quantitative Measure of Fairness and Discrimination for Resource
    Allocation in Shared Computer Systems. DEC Research Report TR-301, 1984 (arXiv:cs/9809099).
    """
    squares = sum(share * share for share in shares)
    return sum(shares) ** 2 / (len(shares) * squares) if squares else 1.0


def _free_spans(problem: PlanningProblem) -> dict[str, list[Span]]:
    free = FreeTime(problem).spans
    if problem.openings:
        return free
    begin = min((wish.earliest_ns for wish in problem.wishes), default=0)
    end = max((wish.latest_ns for wish in problem.wishes), default=begin)
    outside = [(-ALWAYS_NS, begin), (end, ALWAYS_NS)]
    return {robot: without(spans, outside) for robot, spans in free.items()}


def _between(problem: PlanningProblem, free: Iterable[Span], used: Sequence[Span]) -> int:
    openings = merged(problem.openings) or [(-ALWAYS_NS, ALWAYS_NS)]
    total = 0
    for begin, end in openings:
        today = [span for span in used if begin <= span[0] < end]
        if today:
            first, last = min(span[0] for span in today), max(span[1] for span in today)
            outside = [(-ALWAYS_NS, first), (last, ALWAYS_NS)]
            total += _length(without(without(free, used), outside))
    return total


def _length(spans: Iterable[Span]) -> int:
    return sum(end - begin for begin, end in spans)
