"""What people read about wishes and the plan made of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said, said_n
from rosic.organiser.calendar_messages import length, moment
from rosic.organiser.planning.problem import PRIORITIES, LeftOverReason

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.robot.profile import RobotId
    from rosic.features.booking.context import BookingContext
    from rosic.organiser.planning.problem import Allocation
    from rosic.organiser.planning.wishes import RecordedWish
    from rosic.organiser.timezones import Zone

WHYS = {
    LeftOverReason.NO_SUCH_ROBOT: said("they may not use it any more."),
    LeftOverReason.WINDOW_TOO_SHORT: said("the window is too short by now."),
    LeftOverReason.CLOSED: said("the place is closed then."),
    LeftOverReason.BOOKED: said("it is booked: no gap in the window is that long."),
    LeftOverReason.CROWDED: said("in that window it goes to other wishes."),
    LeftOverReason.OWN_SLOTS: said("they have another robot at that time."),
}


def _robots(times: BookingContext, robots: tuple[RobotId, ...]) -> str:
    return joined(said(" or "), [times.shown(robot) for robot in robots])


def _from_to(start_ns: int, end_ns: int, now_ns: int, zone: Zone) -> str:
    start, end = zone.local(start_ns), zone.local(end_ns)
    same = start.day_number == end.day_number
    return said(
        "{start} to {end}",
        start=moment(start_ns, now_ns, zone),
        end=end.time_text() if same else moment(end_ns, now_ns, zone),
    )


def one(times: BookingContext, wished: RecordedWish, reader: PrincipalId) -> str:
    """Return ``KUKA iiwa for 1 h, tomorrow 09:00 to 17:00``."""
    zone, now_ns = times.sides.zone_of(reader), times.clock.wall_ns()
    line = said(
        "{robots} for {length}, {window}",
        robots=_robots(times, wished.robots),
        length=length(wished.length_s),
        window=_from_to(wished.earliest_ns, wished.latest_ns, now_ns, zone),
    )
    return _weighed(line, wished.priority)


def _weighed(line: str, priority: int) -> str:
    """Add a priority that is not the ordinary one: whoever decides on a plan sees who said it."""
    if priority == PRIORITIES[0]:
        return line
    return said("{line}, priority {priority}", line=line, priority=priority)


def noted(line: str) -> str:
    """Say that a wish is down, and that nothing is booked yet."""
    return said(
        "I noted your wish: {line}. Nothing is booked yet; I tell you when it is.", line=line
    )


def how_to_wish() -> str:
    """Say how wishes are written."""
    return said("Say for how long, and between when and when.")


def once_only() -> str:
    """Say that a wish is for one time."""
    return said("A wish is for one time. Book what comes again with /book.")


def no_wishes() -> str:
    """Say that there are none, and how to have one."""
    return said("You have no wishes. Say one as /wish ROBOT 1h tomorrow 9:00 to 17:00.")


def your_wishes() -> str:
    """Head the list."""
    return said("Your wishes. /wish off 1 takes the first one back.")


def taken_back(line: str) -> str:
    """Say that one is gone."""
    return said("Taken back: {line}.", line=line)


# ---- plans ----


def not_you() -> str:
    """Say who makes plans."""
    return said("Only an admin makes a plan. /wish says what you would like.")


def nobody() -> str:
    """Say that there is nothing to plan."""
    return said("Nobody wishes for anything now.")


def busy() -> str:
    """Say that one plan at a time is worked out."""
    return said("A plan is being worked out just now. Try again in a few seconds.")


def left_as_it_is() -> str:
    """Say that nothing became of a plan."""
    return said("Nothing was booked. The wishes stay.")


def head(granted: int, wishes: int) -> str:
    """Say how many wishes are granted."""
    return said_n(
        "{granted} of {n} wish can be granted.",
        "{granted} of {n} wishes can be granted.",
        wishes,
        granted=granted,
    )


def slot(times: BookingContext, place: Allocation, reader: PrincipalId) -> str:
    """Return ``Ann: KUKA iiwa, tomorrow 09:00 to 10:00``."""
    zone, now_ns = times.sides.zone_of(reader), times.clock.wall_ns()
    line = said(
        "{who}: {robot}, {when}",
        who=times.calendar.name_of(place.wish.principal),
        robot=times.shown(place.robot),
        when=_from_to(place.start_ns, place.end_ns, now_ns, zone),
    )
    return _weighed(line, place.wish.priority)


def left(
    times: BookingContext, wished: RecordedWish, why: LeftOverReason | None, reader: PrincipalId
) -> str:
    """Say why somebody gets nothing; None is that they have as many times as one may."""
    return said(
        "{who} gets nothing for {wish}: {why}",
        who=times.calendar.name_of(wished.principal),
        wish=one(times, wished, reader),
        why=said("they have as many times booked as one may.") if why is None else WHYS[why],
    )


def more(count: int) -> str:
    """Say that the list was cut."""
    return said_n("And {n} more line.", "And {n} more lines.", count)


def use(planned: float, by_arrival: float) -> str:
    """Compare with the order of arrival; shares of the time that is free."""
    return said(
        "In use for {planned} % of the free time; first come first served: {arrival} %.",
        planned=round(100 * planned),
        arrival=round(100 * by_arrival),
    )


def no_solver() -> str:
    """Say what is missing."""
    return said(
        "This is first come first served: weighing all wishes together needs the extra {name}.",
        name="schedule",
    )


def changed() -> str:
    """Say that a plan was no longer possible."""
    return said("Things have changed meanwhile, so nothing was booked. This is a new plan.")


def booked(count: int) -> str:
    """Say that it is done."""
    return said_n(
        "Booked: {n} time. I told whose it is.", "Booked: {n} times. I told whose they are.", count
    )


def yours(times: BookingContext, place: Allocation) -> str:
    """Tell somebody their time."""
    who = place.wish.principal
    zone, now_ns = times.sides.zone_of(who), times.clock.wall_ns()
    return said(
        "Your wish came true: {robot} is yours, {when}.",
        robot=times.shown(place.robot),
        when=_from_to(place.start_ns, place.end_ns, now_ns, zone),
    )
