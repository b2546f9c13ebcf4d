"""Wishes to plan, and judges of plans that share no code with what they judge."""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING

from rosic.bench.schedule import QUICK_LIMIT_S
from rosic.organiser.planning.greedy import first_come_first_served
from rosic.organiser.planning.problem import Allocation, PlanningProblem, StandingSlot, Wish
from rosic.organiser.planning.solver import propose

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence
    from random import Random

    from rosic.organiser.planning.problem import Proposal

MIN = 60_000_000_000
MONDAY = 20_759 * 24 * 60  # 2026-11-02, in minutes since 1970


def at(hour: int, minute: int = 0, day: int = 0) -> int:
    return (MONDAY + (day * 24 + hour) * 60 + minute) * MIN


def a_wish(  # noqa: PLR0913 - what is left out does not matter to the test
    name: str,
    length_min: int,
    earliest_ns: int,
    latest_ns: int,
    *,
    robots: str = "kuka1",
    person: str = "",
    priority: int = 1,
) -> Wish:
    return Wish(
        id=name,
        principal=person or name,
        robots=tuple(robots.split()),
        length_s=length_min * 60,
        earliest_ns=earliest_ns,
        latest_ns=latest_ns,
        priority=priority,
    )


def a_problem(
    *wishes: Wish, booked: Iterable[StandingSlot] = (), openings: Iterable[tuple[int, int]] = ()
) -> PlanningProblem:
    return PlanningProblem(
        wishes=wishes, robots=("kuka1", "yumi"), booked=tuple(booked), openings=tuple(openings)
    )


def both(problem: PlanningProblem) -> tuple[Proposal, Proposal]:
    return first_come_first_served(problem), propose(problem, limit_s=QUICK_LIMIT_S)


# ---- judges ----


def clashes(problem: PlanningProblem, given: Sequence[Allocation]) -> list[str]:
    """What is wrong with a plan, minute by minute."""
    wrong = [
        f"{a.wish.id} leaves its window, its robots or the opening hours"
        for a in given
        if not (a.wish.earliest_ns <= a.start_ns <= a.wish.latest_ns - a.wish.length_s * 10**9)
        or a.robot not in set(a.wish.robots) & set(problem.robots)
        or any(not is_open(problem, minute) for minute in minutes(a))
    ]
    for one, other in combinations(given, 2):
        shared = {one.robot, one.wish.principal} & {other.robot, other.wish.principal}
        if one.wish.id == other.wish.id or (shared and minutes(one) & minutes(other)):
            wrong.append(f"{one.wish.id} and {other.wish.id} clash")
    wrong += [
        f"{a.wish.id} runs into a booking"
        for a in given
        for b in problem.booked
        if a.robot == b.robot and minutes(a) & set(range(b.start_ns // MIN, b.end_ns // MIN))
    ]
    return wrong


def minutes(a: Allocation) -> set[int]:
    return set(range(a.start_ns // MIN, a.start_ns // MIN + a.wish.length_s // 60))


def is_open(problem: PlanningProblem, minute: int) -> bool:
    return not problem.openings or any(
        begin <= minute * MIN < end for begin, end in problem.openings
    )


def best_by_trying(problem: PlanningProblem, step_min: int) -> float:
    """The highest score of all plans whatever, slots starting on the step."""

    def plans(left: Sequence[Wish], given: list[Allocation]) -> Iterator[list[Allocation]]:
        if not left:
            yield given
            return
        yield from plans(left[1:], given)
        wish = left[0]
        for robot in set(wish.robots):
            for start_ns in range(wish.earliest_ns, wish.latest_ns, step_min * MIN):
                more = [*given, Allocation(wish, robot, start_ns)]
                if not clashes(problem, more):
                    yield from plans(left[1:], more)

    return max(score(problem, plan) for plan in plans(problem.wishes, []))


def score(problem: PlanningProblem, given: Sequence[Allocation]) -> float:
    """The sum of docs/scheduling.md, worked out minute by minute."""
    total = 0.0
    for a in given:
        wish_min = a.wish.length_s / 60
        slack = (a.wish.latest_ns - a.wish.earliest_ns) / MIN - wish_min
        waited = (a.start_ns - a.wish.earliest_ns) / MIN
        full = a.wish.priority * (wish_min + 15)
        total += full - min(0.1 * waited * a.wish.priority, 0.6 * full)
        total -= 0.3 * full * waited / slack if slack else 0
    for robot in problem.robots:
        busy = set().union(*(minutes(a) for a in given if a.robot == robot))
        for b in problem.booked:
            busy |= set(range(b.start_ns // MIN, b.end_ns // MIN)) if b.robot == robot else set()
        total -= sum(minute - 1 not in busy for minute in busy)
    return total


def small_problem(chance: Random) -> PlanningProblem:
    """Three or four wishes that get in each other's way, a booking, sometimes opening hours."""
    wishes = []
    for n in range(chance.choice((3, 3, 4))):
        length = chance.choice((15, 20, 30, 45))
        earliest = chance.randrange(0, 50, 5)
        latest = earliest + length + chance.choice((0, 15, 25))
        wishes.append(
            a_wish(
                f"w{n}",
                length,
                at(9, earliest),
                at(9, latest),
                robots=chance.choice(("kuka1", "yumi", "kuka1 yumi")),
                person=chance.choice(("ann", "bob", "cem")),
                priority=chance.choice((1, 1, 2)),
            )
        )
    begin = chance.randrange(0, 80, 5)
    booked = [StandingSlot(chance.choice(("kuka1", "yumi")), at(9, begin), at(9, begin + 10))]
    openings = [(at(9, 10), at(10, 30))] if chance.random() < 0.3 else []
    return a_problem(*wishes, booked=booked, openings=openings)
