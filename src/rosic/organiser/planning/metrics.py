"""Every sentence about a proposed plan that a person may read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.local_time import WEEKDAYS, weekday_of
from rosic.errors import how_to_install
from rosic.organiser.planning.problem import LeftOverReason, PlanCaveat
from rosic.organiser.timezones import UNIVERSAL, Zone, zone_named

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.local_time import LocalTime
    from rosic.organiser.planning.problem import Allocation, LeftOverWish, Proposal, Wish

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
    line = f"{name_of(wish.principal)}, {_length(wish)}, {_window(wish, zone)}: {said}"
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


def _length(wish: Wish) -> str:
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
