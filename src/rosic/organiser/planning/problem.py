"""Dynamic allocation (Algorithm 3): wishes, what is booked, and the proposal made of them.

Values and arithmetic only. What a proposal is worth is said here and nowhere else, so that the
solver, the order of arrival and the tests are judged by the same sum. Times are wall clock in
nanoseconds since 1970 (UTC); lengths are real durations, so a change of the clocks moves nothing.
"""

from __future__ import annotations

from enum import StrEnum
from itertools import pairwise
from typing import TYPE_CHECKING, TypeAlias

import msgspec

from rosic.core.identity import PrincipalId
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import MINUTE_NS, SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterable

ALWAYS_NS = 2**62
"""Later than any slot: the end of the opening of a place that never closes."""

PRIORITIES = range(1, 6)

# The weights, in minutes of use. docs/scheduling.md says why these.
GRANT_MIN = 15.0
WAIT_COSTS = 0.1
WAIT_COSTS_AT_MOST = 0.6
WINDOW_COSTS = 0.3
BREAK_MIN = 1.0

Span: TypeAlias = tuple[int, int]
"""From, inclusive, to, exclusive; nanoseconds."""


class Wish(msgspec.Struct, frozen=True, kw_only=True):
    """Somebody would like a robot for a while.

    Attributes:
        id: Unique among the wishes of one problem.
        robots: Any one of these will do.
        earliest_ns: The slot starts then at the earliest; waiting is counted from here.
        latest_ns: The slot has ended by then.
        priority: 1 (ordinary) to 5; a minute of priority 3 counts as three.
    """

    id: str
    principal: PrincipalId
    robots: tuple[RobotId, ...]
    length_s: int
    earliest_ns: int
    latest_ns: int
    priority: int = 1

    def __post_init__(self) -> None:
        if self.length_s <= 0:
            raise ValueError("length_s must be greater than 0")
        if self.priority not in PRIORITIES:
            raise ValueError("priority must be from 1 to 5")

    @property
    def length_ns(self) -> int:
        """Return how long the slot is."""
        return self.length_s * SECOND_NS

    @property
    def length_min(self) -> float:
        """Return how long the slot is, in minutes."""
        return self.length_s / 60


class StandingSlot(msgspec.Struct, frozen=True):
    """A slot that stands: nothing is proposed across it."""

    robot: RobotId
    start_ns: int
    end_ns: int


class PlanningProblem(msgspec.Struct, frozen=True, kw_only=True):
    """What is to be decided.

    Attributes:
        wishes: In the order in which they came.
        robots: Those that exist.
        openings: When the place is open, for all robots; empty means always.
    """

    wishes: tuple[Wish, ...]
    robots: tuple[RobotId, ...]
    booked: tuple[StandingSlot, ...] = ()
    openings: tuple[Span, ...] = ()


class Allocation(msgspec.Struct, frozen=True):
    """One wish granted: this robot, from then on, for the length of the wish."""

    wish: Wish
    robot: RobotId
    start_ns: int

    @property
    def end_ns(self) -> int:
        """Return when the robot is free again."""
        return self.start_ns + self.wish.length_ns

    @property
    def wait_min(self) -> float:
        """Return the minutes from the earliest wished start to the proposed one."""
        return (self.start_ns - self.wish.earliest_ns) / MINUTE_NS


class LeftOverReason(StrEnum):
    """Why a wish was left over. The sentences are in `metrics`."""

    NO_SUCH_ROBOT = "no-such-robot"
    WINDOW_TOO_SHORT = "window-too-short"
    CLOSED = "closed"
    BOOKED = "booked"
    CROWDED = "crowded"
    OWN_SLOTS = "own-slots"


class PlanCaveat(StrEnum):
    """Why a plan may not be the best there is. The sentences are in `metrics`."""

    NOT_PROVEN = "not-proven"
    NOTHING_FOUND = "nothing-found"
    NO_SOLVER = "no-solver"
    TOO_MANY = "too-many"


class LeftOverWish(msgspec.Struct, frozen=True):
    """A wish that is not granted.

    Attributes:
        free_ns: When one of its robots would next be free for that long, outside the window;
            None when that is not known.
        free_robot: Which one.
    """

    wish: Wish
    why: LeftOverReason
    free_ns: int | None = None
    free_robot: RobotId = ""


class PlanWorth(msgspec.Struct, frozen=True, kw_only=True):
    """What a proposal is worth, in minutes of ordinary use; more is better.

    Attributes:
        use: Minutes granted, times priority.
        granted: For each wish granted, whatever its length, times priority.
        waiting: What waiting takes away again; never more than nine tenths of the two above.
        breaks: What it costs that robots stand idle between slots, once for each time.
    """

    use: float
    granted: float
    waiting: float
    breaks: float

    @property
    def score(self) -> float:
        """Return the one number that is made as large as possible."""
        return self.use + self.granted - self.waiting - self.breaks


class Proposal(msgspec.Struct, frozen=True, kw_only=True):
    """Who would get which robot when. Nothing is booked by it.

    Attributes:
        allocations: By start.
        left: In the order in which they came.
        solved: Whether the solver found it; otherwise it is the order of arrival.
        bound: No plan on this grid is worth more; None when nobody has looked.
        note: Why it may not be the best; None when it is.
    """

    allocations: tuple[Allocation, ...]
    left: tuple[LeftOverWish, ...]
    parts: PlanWorth
    grid_s: int
    solved: bool = False
    bound: float | None = None
    note: PlanCaveat | None = None

    @property
    def gap(self) -> float | None:
        """Return the share of the bound that may be missing: 0 is the best there is."""
        if self.bound is None:
            return None
        return max(0.0, 1 - self.parts.score / self.bound) if self.bound > 0 else 0.0


def worth(wish: Wish, start_ns: int) -> float:
    """Return what granting a wish at this time adds to the score, breaks apart.

    A tenth of it stays however long the wait, and that is more than a break costs: late is
    better than never.
    """
    return _full(wish) - _lost(wish, start_ns)


def _full(wish: Wish) -> float:
    return wish.priority * (wish.length_min + GRANT_MIN)


def _lost(wish: Wish, start_ns: int) -> float:
    """Return the loss by waiting: by the minute at first, and a little all through the window."""
    wait_ns = start_ns - wish.earliest_ns
    slack_ns = wish.latest_ns - wish.earliest_ns - wish.length_ns
    if slack_ns <= 0:
        return 0.0
    by_the_minute = wish.priority * WAIT_COSTS * wait_ns / MINUTE_NS
    full = _full(wish)
    return min(by_the_minute, WAIT_COSTS_AT_MOST * full) + WINDOW_COSTS * full * wait_ns / slack_ns


def parts_of(problem: PlanningProblem, allocations: Iterable[Allocation]) -> PlanWorth:
    """Return what these allocations are worth."""
    given = tuple(allocations)
    busy: dict[RobotId, list[Span]] = {robot: [] for robot in problem.robots}
    for booked in problem.booked:
        busy.setdefault(booked.robot, []).append((booked.start_ns, booked.end_ns))
    for a in given:
        busy.setdefault(a.robot, []).append((a.start_ns, a.end_ns))
    blocks = sum(len(merged(busy[robot])) for robot in problem.robots)
    return PlanWorth(
        use=sum(a.wish.priority * a.wish.length_min for a in given),
        granted=sum(a.wish.priority * GRANT_MIN for a in given),
        waiting=sum(_lost(a.wish, a.start_ns) for a in given),
        breaks=blocks * BREAK_MIN,
    )


def broken_rules(problem: PlanningProblem, allocations: Iterable[Allocation]) -> list[str]:
    """Return every rule that these allocations break, for whoever found them to be ashamed of.

    It looks at finished slots only and shares nothing with the ways to find them.
    """
    given = tuple(allocations)
    known = {wish.id: wish for wish in problem.wishes}
    open_spans = merged(problem.openings) or [(-ALWAYS_NS, ALWAYS_NS)]
    found = [
        f"{a.wish.id}: {broken}"
        for a in given
        for broken, holds in (
            ("not a wish of this problem", known.get(a.wish.id) == a.wish),
            (f"{a.robot} was not wished for", a.robot in a.wish.robots),
            (f"there is no {a.robot}", a.robot in problem.robots),
            ("before its window", a.wish.earliest_ns <= a.start_ns),
            ("after its window", a.end_ns <= a.wish.latest_ns),
            ("closed", any(on <= a.start_ns and a.end_ns <= off for on, off in open_spans)),
        )
        if not holds
    ]
    if len({a.wish.id for a in given}) < len(given):
        found.append("a wish is granted twice")
    return found + _collisions(problem, given)


def _collisions(problem: PlanningProblem, given: tuple[Allocation, ...]) -> list[str]:
    found: list[str] = []
    for robot in problem.robots:
        # What was booked before may overlap as it likes; a proposal may not add to that.
        stands = merged((b.start_ns, b.end_ns) for b in problem.booked if b.robot == robot)
        if _collide([*stands, *((a.start_ns, a.end_ns) for a in given if a.robot == robot)]):
            found.append(f"{robot} is given twice at one time")
    people = sorted({a.wish.principal for a in given})
    found += [
        f"{person} has two robots at one time"
        for person in people
        if _collide([(a.start_ns, a.end_ns) for a in given if a.wish.principal == person])
    ]
    return found


def merged(spans: Iterable[Span]) -> list[Span]:
    """Return the same time as few spans, in order: what touches or overlaps becomes one."""
    result: list[Span] = []
    for begin, end in sorted(span for span in spans if span[0] < span[1]):
        if result and begin <= result[-1][1]:
            result[-1] = (result[-1][0], max(result[-1][1], end))
        else:
            result.append((begin, end))
    return result


def _collide(spans: list[Span]) -> bool:
    return any(later[0] < earlier[1] for earlier, later in pairwise(sorted(spans)))
