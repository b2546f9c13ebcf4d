"""``rosic schedule plan``: who could have which robot when."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.api import AdminRequest, AdminVerb
from rosic.app.admin.schedule import (
    BookParameters,
    KnownNames,
    ScheduleWindow,
    SlotBooking,
    TakenSlot,
    merged_who,
    not_over,
    openings_of,
    problem_of,
    read_wishes,
)
from rosic.cli.client import add_where, changed, looked_up
from rosic.errors import ConfigurationError
from rosic.organiser.planning.figures import plan_text
from rosic.organiser.planning.solver import LIMIT_S, propose
from rosic.organiser.timezones import zone_named
from rosic.system import SystemClock

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.organiser.planning.problem import PlanningProblem, Proposal, Span, Wish


ABOUT = """Propose who gets which robot when, from wishes in a table (CSV) or a list (JSON) with
person, robots, length, earliest, latest and priority. Nothing is booked without --book. Works with
and without a running gateway."""


def plan(arguments: Sequence[str]) -> int:
    """Plan, print, and book if asked to. Return 2 when a line of the file is wrong.

    Raises:
        RosicError: Why not; nothing was booked.
    """
    parser = argparse.ArgumentParser(prog="rosic schedule plan", description=ABOUT)
    parser.add_argument("file", metavar="FILE", help="ends in .csv or .json")
    parser.add_argument("--book", action="store_true", help="book it: all of it, or nothing")
    parser.add_argument("--open", metavar="08:00-18:00", help="plan within these hours alone")
    add_where(parser)
    options = parser.parse_args(arguments)
    who = _who(options)
    wishes, complaints = read_wishes(Path(options.file), who)
    wishes, late = not_over(wishes, SystemClock().wall_ns())
    for complaint in (*complaints, *late):
        print(complaint, file=sys.stderr)
    if complaints or late:
        count = len(complaints) + len(late)
        said = "line is" if count == 1 else "lines are"
        print(f"{count} {said} wrong. Nothing was planned.", file=sys.stderr)
        return 2
    proposal = propose(_problem(options, who, wishes), limit_s=LIMIT_S)
    print(plan_text(proposal, zone=zone_named(who.zone), name_of=lambda p: who.names.get(p, p)))
    if options.book:
        print(_book(options, proposal))
    return 0


def _who(options: argparse.Namespace) -> KnownNames:
    # What is booked is booked for people of the record: the file's are taken over first.
    known = changed if options.book else looked_up
    answered = known(options, AdminRequest(AdminVerb.WHO), robots=True)
    who = merged_who(msgspec.json.decode(text, type=KnownNames) for text in answered)
    if not who.robots:
        raise ConfigurationError("There is no robot to plan for.")
    return who


def _problem(
    options: argparse.Namespace, who: KnownNames, wishes: tuple[Wish, ...]
) -> PlanningProblem:
    openings: tuple[Span, ...] = ()
    if options.open is not None:
        openings = openings_of(options.open, wishes, zone_named(who.zone))
    if not wishes:
        return problem_of(wishes, who, ())
    window = ScheduleWindow(min(w.earliest_ns for w in wishes), max(w.latest_ns for w in wishes))
    ask = AdminRequest(AdminVerb.TAKEN, body=msgspec.Raw(msgspec.json.encode(window)))
    answered = looked_up(options, ask, robots=True)
    taken = [msgspec.json.decode(text, type=TakenSlot) for text in answered]
    return problem_of(wishes, who, taken, openings)


def _book(options: argparse.Namespace, proposal: Proposal) -> str:
    slots = tuple(
        SlotBooking(a.wish.principal, a.robot, a.start_ns, a.wish.length_s)
        for a in proposal.allocations
    )
    body = msgspec.Raw(msgspec.json.encode(BookParameters(slots)))
    return "\n".join(changed(options, AdminRequest(AdminVerb.BOOK, body=body), robots=True))
