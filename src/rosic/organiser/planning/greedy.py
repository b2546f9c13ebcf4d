"""Where a wish can go, and the plain way to grant wishes: in the order of arrival."""

from __future__ import annotations

from bisect import bisect_left
from collections import defaultdict
from typing import TYPE_CHECKING

from rosic.core.time_units import SECOND_NS
from rosic.organiser.planning.problem import (
    ALWAYS_NS,
    Allocation,
    LeftOverReason,
    LeftOverWish,
    Proposal,
    merged,
    parts_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.core.robot.profile import RobotId
    from rosic.organiser.planning.problem import PlanningProblem, Span, Wish

FINE_S = 300
COARSE_S = 900
FINE_PLACES = 4_000
"""Up to this many places the solver proves the best on the fine grid in seconds."""


class FreeTime:
    """When each robot can be had: open, and not booked."""

    def __init__(self, problem: PlanningProblem) -> None:
        self.open: list[Span] = merged(problem.openings) or [(-ALWAYS_NS, ALWAYS_NS)]
        self.spans: dict[RobotId, list[Span]] = {
            robot: without(
                self.open, [(b.start_ns, b.end_ns) for b in problem.booked if b.robot == robot]
            )
            for robot in problem.robots
        }

    def starts(self, wish: Wish, robot: RobotId, grid_s: int) -> Iterator[int]:
        """Yield where a wish can start on a robot, in order.

        That is: at its own earliest time, when the robot becomes free, or on the grid. Without
        the first two, a window or a gap that fits to the minute would be wasted.
        """
        yield from _starts(self.spans.get(robot, []), wish, grid_s * SECOND_NS)

    def places(self, wish: Wish, grid_s: int) -> Iterator[Allocation]:
        """Yield every place for a wish."""
        for robot in dict.fromkeys(wish.robots):
            for start_ns in self.starts(wish, robot, grid_s):
                yield Allocation(wish, robot, start_ns)


class PlanTimetable:
    """What has been given so far: no robot twice at a time, and no person two robots."""

    def __init__(self, given: Iterable[Allocation] = ()) -> None:
        self._taken: defaultdict[tuple[str, str], list[Span]] = defaultdict(list)
        for allocation in given:
            self.take(allocation)

    def free(self, place: Allocation) -> bool:
        """Return whether neither the robot nor the person has anything then."""
        return self.robot_free(place) and self._is_free(("person", place.wish.principal), place)

    def robot_free(self, place: Allocation) -> bool:
        """Return whether the robot has nothing then."""
        return self._is_free(("robot", place.robot), place)

    def take(self, place: Allocation) -> None:
        """Note a place as given."""
        for key in (("robot", place.robot), ("person", place.wish.principal)):
            spans = self._taken[key]
            span = (place.start_ns, place.end_ns)
            spans.insert(bisect_left(spans, span), span)

    def taken(self, wish: Wish, robot: RobotId) -> list[Span]:
        """Return when this robot, or this person, has something."""
        return [*self._taken[("robot", robot)], *self._taken[("person", wish.principal)]]

    def _is_free(self, key: tuple[str, str], place: Allocation) -> bool:
        spans = self._taken[key]
        # Given spans never overlap, so only the last one that starts before our end matters.
        before = bisect_left(spans, (place.end_ns, place.end_ns))
        return before == 0 or spans[before - 1][1] <= place.start_ns


def grid_for(problem: PlanningProblem) -> int:
    """Return 5 minutes for a problem that the solver can weigh so finely, else 15; in seconds."""
    return FINE_S if count_places(problem, FINE_S, FINE_PLACES) <= FINE_PLACES else COARSE_S


def count_places(problem: PlanningProblem, grid_s: int, enough: int) -> int:
    """Count the places of all wishes; stop counting above ``enough``."""
    free, count = FreeTime(problem), 0
    for wish in problem.wishes:
        for _ in free.places(wish, grid_s):
            count += 1
            if count > enough:
                return count
    return count


def first_come_first_served(problem: PlanningProblem, *, grid_s: int | None = None) -> Proposal:
    """Grant each wish, in the order of arrival, the earliest place that is left.

    Args:
        problem: Its wishes are in the order of arrival.
        grid_s: What slots start on; None chooses by size.
    """
    grid_s = grid_s or grid_for(problem)
    return proposal_of(problem, fill(problem, (), grid_s), grid_s)


def fill(problem: PlanningProblem, given: Iterable[Allocation], grid_s: int) -> list[Allocation]:
    """Grant, in the order of arrival, whatever still fits beside what is given already."""
    allocations = list(given)
    free, timetable = FreeTime(problem), PlanTimetable(allocations)
    granted = {allocation.wish.id for allocation in allocations}
    for wish in problem.wishes:
        if wish.id not in granted and (place := _earliest(free, timetable, wish, grid_s)):
            timetable.take(place)
            allocations.append(place)
    return allocations


def _earliest(
    free: FreeTime, timetable: PlanTimetable, wish: Wish, grid_s: int
) -> Allocation | None:
    best: Allocation | None = None
    for robot in dict.fromkeys(wish.robots):
        for start_ns in free.starts(wish, robot, grid_s):
            if best and start_ns >= best.start_ns:
                break
            if timetable.free(place := Allocation(wish, robot, start_ns)):
                best = place
                break
    return best


def proposal_of(problem: PlanningProblem, given: Iterable[Allocation], grid_s: int) -> Proposal:
    """Return a proposal: what is given, what is left over and why, and what it is worth."""
    allocations = sorted(given, key=lambda a: (a.start_ns, a.robot, a.wish.id))
    granted = {allocation.wish.id for allocation in allocations}
    free, timetable = FreeTime(problem), PlanTimetable(allocations)
    left = [
        _left(free, timetable, wish, grid_s) for wish in problem.wishes if wish.id not in granted
    ]
    return Proposal(
        allocations=tuple(allocations),
        left=tuple(left),
        parts=parts_of(problem, allocations),
        grid_s=grid_s,
    )


def _left(free: FreeTime, timetable: PlanTimetable, wish: Wish, grid_s: int) -> LeftOverWish:
    why = _why(free, timetable, wish, grid_s)
    found = [
        (start_ns, robot)
        for robot in wish.robots
        if (start_ns := _next_free(free, timetable, wish, robot)) is not None
    ]
    return LeftOverWish(wish, why, *min(found, default=(None, "")))


def _why(free: FreeTime, timetable: PlanTimetable, wish: Wish, grid_s: int) -> LeftOverReason:
    if not any(robot in free.spans for robot in wish.robots):
        return LeftOverReason.NO_SUCH_ROBOT
    if wish.latest_ns - wish.earliest_ns < wish.length_ns:
        return LeftOverReason.WINDOW_TOO_SHORT
    if next(_starts(free.open, wish, grid_s * SECOND_NS), None) is None:
        return LeftOverReason.CLOSED
    places = list(free.places(wish, grid_s))
    if not places:
        return LeftOverReason.BOOKED
    if any(timetable.robot_free(place) for place in places):
        return LeftOverReason.OWN_SLOTS
    return LeftOverReason.CROWDED


def _next_free(free: FreeTime, timetable: PlanTimetable, wish: Wish, robot: RobotId) -> int | None:
    for begin, end in without(free.spans.get(robot, []), timetable.taken(wish, robot)):
        start_ns = max(begin, wish.earliest_ns)
        if start_ns + wish.length_ns <= end:
            return start_ns
    return None


def _starts(spans: Iterable[Span], wish: Wish, grid_ns: int) -> Iterator[int]:
    for begin, end in spans:
        first = max(begin, wish.earliest_ns)
        last = min(end, wish.latest_ns) - wish.length_ns
        if first <= last:
            yield first
            yield from range((first // grid_ns + 1) * grid_ns, last + 1, grid_ns)


def without(spans: Iterable[Span], taken: Iterable[Span]) -> list[Span]:
    """Return what is left of spans, in order, when others are taken out of them."""
    result: list[Span] = []
    gone = merged(taken)
    for begin, end in merged(spans):
        at = begin
        for off, on in gone[max(0, bisect_left(gone, (begin, begin)) - 1) :]:
            if off >= end:
                break
            if off > at:
                result.append((at, off))
            at = max(at, on)
        if at < end:
            result.append((at, end))
    return result
