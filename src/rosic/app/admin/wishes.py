"""From a file of wishes to a problem that can be solved."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import msgspec

from rosic.app.admin.schedule import Who
from rosic.config.source_map import read_text
from rosic.core.local_time import MINUTES_A_DAY
from rosic.errors import ConfigurationError, OutOfBounds
from rosic.organiser.planning.problem import NS_PER_MIN, Booked, PlanningProblem
from rosic.organiser.planning.wish_file import (
    WishNames,
    opening_hours,
    wishes_from_csv,
    wishes_from_json,
)
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from rosic.app.admin.schedule import Taken
    from rosic.organiser.planning.problem import Span, Wish
    from rosic.organiser.timezones import Zone

_HOURS = re.compile(r"(\d{1,2}:\d{2})\s*-\s*(\d{1,2}:\d{2})")
READERS = {".csv": wishes_from_csv, ".json": wishes_from_json}


def merged_who(parts: Iterable[Who]) -> Who:
    """Return what was told in parts as one."""
    people: dict[str, str] = {}
    names: dict[str, str] = {}
    robots: dict[str, tuple[str, ...]] = {}
    zone = ""
    for part in parts:
        people |= part.people
        names |= part.names
        robots |= part.robots
        zone = part.zone or zone
    return Who(people=people, names=names, robots=robots, zone=zone)


def read_wishes(path: Path, who: Who) -> tuple[tuple[Wish, ...], tuple[str, ...]]:
    """Return the wishes of a file, and a sentence for each line that is wrong.

    Raises:
        ConfigurationError: It cannot be read, or its name does not say what it is.
    """
    read = READERS.get(path.suffix.lower())
    if read is None:
        raise ConfigurationError(
            "A list of wishes is a file that ends in .csv or .json.", where=str(path)
        )
    names = WishNames(robots=who.robots, zone=zone_named(who.zone), people=who.people)
    found = read(read_text(path), path.name, names)
    return found.wishes, found.complaints


def not_over(wishes: Iterable[Wish], now_ns: int) -> tuple[tuple[Wish, ...], tuple[str, ...]]:
    """Return wishes from now on, and a sentence for each whose time is over."""
    from_ns = -(-now_ns // NS_PER_MIN) * NS_PER_MIN
    found: list[Wish] = []
    late: list[str] = []
    for wish in wishes:
        if wish.latest_ns - wish.length_ns < from_ns:
            late.append(f"{wish.id}: That time is over.")
        elif wish.earliest_ns < from_ns:
            found.append(msgspec.structs.replace(wish, earliest_ns=from_ns))
        else:
            found.append(wish)
    return tuple(found), tuple(late)


def openings_of(text: str, wishes: Iterable[Wish], zone: Zone) -> tuple[Span, ...]:
    """Return when a place is open on each day of the wishes: ``08:00-18:00``, ``22:00-06:00``.

    Raises:
        OutOfBounds: It is no such pair of times.
    """
    found = _HOURS.fullmatch(text.strip())
    opens, closes = (_minutes(part) for part in found.groups()) if found else (None, None)
    if opens is None or closes is None or opens == closes:
        raise OutOfBounds(f"I cannot read --open {text!r}. Write --open 08:00-18:00.")
    days = {
        day
        for wish in wishes
        for day in range(
            zone.local(wish.earliest_ns).day_number - 1, zone.local(wish.latest_ns).day_number + 1
        )
    }
    beyond = 0 if closes > opens else MINUTES_A_DAY
    return opening_hours(sorted(days), opens, closes + beyond, zone)


def _minutes(text: str) -> int | None:
    hours, _, minutes = text.partition(":")
    at = int(hours) * 60 + int(minutes)
    return at if int(minutes) < 60 and at <= MINUTES_A_DAY else None  # noqa: PLR2004 - minutes


def problem_of(
    wishes: tuple[Wish, ...], who: Who, taken: Iterable[Taken], openings: tuple[Span, ...] = ()
) -> PlanningProblem:
    """Return the problem: wishes, the robots there are, what is booked, when it is open."""
    robots = tuple(dict.fromkeys(robot for some in who.robots.values() for robot in some))
    booked = tuple(Booked(*slot) for part in taken for slot in part.slots)
    return PlanningProblem(wishes=wishes, robots=robots, booked=booked, openings=openings)
