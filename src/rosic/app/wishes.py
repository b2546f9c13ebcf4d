"""From a file of wishes to a problem that can be solved."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.app.planning import Who
from rosic.app.source import read_text
from rosic.errors import ConfigurationError
from rosic.organiser.allocation import NS_PER_MIN, Booked, Problem
from rosic.organiser.wishlist import Names, wishes_from_csv, wishes_from_json
from rosic.organiser.zones import zone_named

if TYPE_CHECKING:
    from collections.abc import Iterable
    from pathlib import Path

    from rosic.app.planning import Taken
    from rosic.organiser.allocation import Wish

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
    names = Names(robots=who.robots, zone=zone_named(who.zone), people=who.people)
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


def problem_of(wishes: tuple[Wish, ...], who: Who, taken: Iterable[Taken]) -> Problem:
    """Return the problem: wishes, the robots there are, and what is booked."""
    robots = tuple(dict.fromkeys(robot for some in who.robots.values() for robot in some))
    booked = tuple(Booked(*slot) for part in taken for slot in part.slots)
    return Problem(wishes=wishes, robots=robots, booked=booked)
