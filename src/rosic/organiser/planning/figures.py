"""What a plan does for a place, in figures that do not depend on what the plan was made for."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING

import msgspec

from rosic.core.local_time import WEEKDAYS, weekday_of
from rosic.core.time_units import HOUR_NS
from rosic.errors import how_to_install
from rosic.organiser.planning.greedy import FreeTime, without
from rosic.organiser.planning.problem import (
    ALWAYS_NS,
    LeftOverReason,
    PlanCaveat,
    broken_rules,
    merged,
)
from rosic.organiser.timezones import UNIVERSAL, Zone, zone_named

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    from rosic.core.local_time import LocalTime
    from rosic.organiser.planning.problem import (
        Allocation,
        LeftOverWish,
        PlanningProblem,
        Proposal,
        Span,
        Wish,
    )


# ---- metrics ----

# Every sentence about a proposed plan that a person may read.

UTC = zone_named(UNIVERSAL)

NOTES = {
    PlanCaveat.NO_SOLVER: (
        "This is the order of arrival. Weighing all wishes together needs one more library: "
        f"{how_to_install('schedule')}"
    ),
    PlanCaveat.TOO_MANY: (
        "This is the order of arrival: there are too many possibilities to weigh. "
        "Shorter windows or fewer wishes at a time help."
    ),
    PlanCaveat.NOTHING_FOUND: (
        "This is the order of arrival: nothing better was found in the time given{gap}."
    ),
    PlanCaveat.NOT_PROVEN: "This is the best plan found in the time given{gap}.",
}
WHYS = {
    LeftOverReason.NO_SUCH_ROBOT: "There is no robot called {robots}.",
    LeftOverReason.WINDOW_TOO_SHORT: "The window is shorter than that.",
    LeftOverReason.CLOSED: "The opening hours leave no such time in the window.",
    LeftOverReason.BOOKED: "{robots} is booked: no gap in the window is that long.",
    LeftOverReason.CROWDED: "In the window, {robots} goes to other wishes.",
    LeftOverReason.OWN_SLOTS: "The person has another robot at that time.",
}


def plan_text(proposal: Proposal, *, zone: Zone = UTC, name_of: Callable[[str], str] = str) -> str:
    """Return a proposal as people read it.

    Args:
        proposal: What is proposed.
        zone: Whose clock the times are told on.
        name_of: From a principal to a name.
    """
    lines = [_head(proposal)]
    day = ""
    for allocation in proposal.allocations:
        if (today := _day(zone.local(allocation.start_ns))) != day:
            day = today
            lines += ["", day]
        lines.append(_slot(allocation, zone, name_of))
    if proposal.left:
        lines += ["", "Left over"]
        lines += [f"  {left_text(left, zone=zone, name_of=name_of)}" for left in proposal.left]
    return "\n".join([*lines, "", quality_text(proposal)])


def left_text(left: LeftOverWish, *, zone: Zone = UTC, name_of: Callable[[str], str] = str) -> str:
    """Return why one wish is not granted, and when it could be."""
    wish = left.wish
    said = WHYS[left.why].format(robots=_either(wish.robots))
    line = f"{name_of(wish.principal)}, {_length_text(wish)}, {_window(wish, zone)}: {said}"
    if left.free_ns is not None:
        line += f" {left.free_robot} is free for that long from {_moment(left.free_ns, zone)}."
    return line


def quality_text(proposal: Proposal) -> str:
    """Return how good the plan is, and how far that is known."""
    if proposal.note is None:
        if not proposal.solved:
            return "This is the order of arrival."
        return f"No plan on a grid of {proposal.grid_s // 60} min is better."
    gap = proposal.gap
    known = "" if gap is None else f", at most {100 * gap:.1f} % short of the best there is"
    return NOTES[proposal.note].format(gap=known)


def _head(proposal: Proposal) -> str:
    granted = len(proposal.allocations)
    wishes = granted + len(proposal.left)
    if not wishes:
        return "Nobody wishes for anything."
    text = f"{granted} of {wishes} {'wish' if wishes == 1 else 'wishes'} can be granted."
    if granted:
        waits = [allocation.wait_min for allocation in proposal.allocations]
        mean, worst = _minutes(sum(waits) / granted), _minutes(max(waits))
        text += f" Waiting: {mean} on average, {worst} at most."
    return text


def _slot(allocation: Allocation, zone: Zone, name_of: Callable[[str], str]) -> str:
    when = _from_to(allocation.start_ns, allocation.end_ns, zone)
    return f"  {when}  {allocation.robot}  {name_of(allocation.wish.principal)}"


def _window(wish: Wish, zone: Zone) -> str:
    day = _day(zone.local(wish.earliest_ns))
    return f"{day} {_from_to(wish.earliest_ns, wish.latest_ns, zone)}"


def _from_to(start_ns: int, end_ns: int, zone: Zone) -> str:
    start, end = zone.local(start_ns), zone.local(end_ns)
    same = start.day_number == end.day_number
    return f"{start.time_text()} to {end.time_text() if same else _moment(end_ns, zone)}"


def _length_text(wish: Wish) -> str:
    return _minutes(wish.length_min)


def _minutes(minutes: float) -> str:
    hours, rest = divmod(round(minutes), 60)
    if not hours:
        return f"{rest} min"
    return f"{hours} h {rest} min" if rest else f"{hours} h"


def _moment(at_ns: int, zone: Zone) -> str:
    at = zone.local(at_ns)
    return f"{_day(at)} {at.time_text()}"


def _day(at: LocalTime) -> str:
    return f"{WEEKDAYS[weekday_of(at.day_number)]} {at.date_text()}"


def _either(robots: Iterable[str]) -> str:
    names = list(dict.fromkeys(robots))
    return " or ".join(filter(None, [", ".join(names[:-1]), names[-1]])) if names else "that name"


# ---- figures ----


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
