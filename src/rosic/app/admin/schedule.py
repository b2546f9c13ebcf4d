"""What a plan is made from, and booking it: the gateway's half of ``rosic schedule plan``.

Weighing wishes takes seconds of computing, so whoever asks does it, never the gateway.
"""

from __future__ import annotations

import re
from collections import Counter, defaultdict
from itertools import pairwise
from typing import TYPE_CHECKING

import msgspec

from rosic.config.source_map import read_text
from rosic.core.identity import OPERATOR, PrincipalId
from rosic.core.records import Decided, Fact
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import DAY_S, MINUTE_NS, MINUTES_A_DAY, SECOND_NS
from rosic.errors import (
    ConfigurationError,
    NotPermitted,
    NotUnderstood,
    OutOfBounds,
    RobotTaken,
    TooManyRequests,
)
from rosic.organiser.planning.problem import PlanningProblem, StandingSlot
from rosic.organiser.planning.wish_file import (
    WishNames,
    opening_hours,
    wishes_from_csv,
    wishes_from_json,
)
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from rosic.app.admin.api import AdminContext
    from rosic.organiser.planning.problem import Span, Wish
    from rosic.organiser.timezones import Zone


# ---- planning in the gateway ----

PEOPLE_A_LINE = 2_000
SLOTS_A_LINE = 8_000


class KnownNames(msgspec.Struct, frozen=True, kw_only=True):
    """Whom and what a list of wishes may name.

    Attributes:
        people: From a name that one person alone has, or an id, to the id.
        names: From an id to how somebody is shown.
        robots: From a robot's or a group's name to its robots.
        zone: In which times without an offset are meant.
    """

    people: dict[str, PrincipalId]
    names: dict[PrincipalId, str]
    robots: dict[str, tuple[RobotId, ...]] = {}
    zone: str = ""


class ScheduleWindow(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """From when until when; wall clock."""

    from_ns: int
    to_ns: int


class TakenSlot(msgspec.Struct, frozen=True):
    """Slots that stand: robot, start, end."""

    slots: tuple[tuple[RobotId, int, int], ...]


class SlotBooking(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One slot to be booked."""

    principal: PrincipalId
    robot: RobotId
    start_ns: int
    length_s: int


class BookParameters(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Slots to be booked together: all of them, or none."""

    slots: tuple[SlotBooking, ...]


class ScheduleAdmin:
    """Knows who may wish for what, what is taken, and books."""

    def __init__(self, books: AdminContext) -> None:
        self._books = books
        self._calendar = books.organiser.calendar

    def who(self) -> Iterator[KnownNames]:
        """Yield who there is, some people at a time."""
        directory = self._books.authoriser.directory
        people = [p for p in directory.people() if directory.has_good_key(p.id)]
        alone = Counter(person.name for person in people)
        fleet = self._books.authority.rights.fleet
        robots = {**fleet.groups, **{robot: (robot,) for robot in fleet.skills}}
        yield KnownNames(people={}, names={}, robots=robots, zone=self._books.zone.name)
        for at in range(0, len(people), PEOPLE_A_LINE):
            some = people[at : at + PEOPLE_A_LINE]
            by_name = {person.name: person.id for person in some if alone[person.name] == 1}
            yield KnownNames(
                people={**by_name, **{person.id: person.id for person in some}},
                names={person.id: self._books.name(person.id) for person in some},
            )

    def taken(self, window: ScheduleWindow) -> Iterator[TakenSlot]:
        """Yield every slot that takes some of this time."""
        slots = [
            (slot.robot, slot.start_ns, slot.end_ns)
            for robot in self._books.profiles
            for slot in self._calendar.on(robot, window.from_ns, window.to_ns)
        ]
        for at in range(0, len(slots), SLOTS_A_LINE):
            yield TakenSlot(tuple(slots[at : at + SLOTS_A_LINE]))

    async def book(self, asked: BookParameters) -> str:
        """Book slots in one change: all of them, or none.

        Raises:
            NotUnderstood: Somebody or a robot that is not there.
            NotPermitted: Somebody would keep a robot from the others that they may not move.
            RobotTaken, OutOfBounds, TooManyRequests: One of them cannot be. Nothing was booked.
            RecordUnavailable: Not written; nothing was booked.
        """
        if not asked.slots:
            return "Nothing was booked."
        async with self._books.access.changes.turn() as turn:
            await turn.write([record for slot in self._checked(asked) for record in slot])
        count = len(asked.slots)
        return f"Booked: {count} {'slot' if count == 1 else 'slots'}."

    def _checked(self, asked: BookParameters) -> list[tuple[Decided | Fact, ...]]:
        self._check_apart(asked)
        self._check_shares(asked)
        return [self._one(slot) for slot in asked.slots]

    def _one(self, slot: SlotBooking) -> tuple[Decided | Fact, ...]:
        books = self._books
        if slot.robot not in books.profiles:
            raise NotUnderstood(f"There is no robot called {slot.robot}. Nothing was booked.")
        if not books.authoriser.directory.has_good_key(slot.principal):
            raise NotUnderstood("Somebody of this plan has no access any more. Plan again.")
        if books.organiser.why_not_move(slot.principal, slot.robot) is not None:
            who, shown = books.name(slot.principal), books.shown(slot.robot)
            raise NotPermitted(f"{who} may not move {shown} now. Nothing was booked.")
        facts = self._calendar.book(
            slot.principal, slot.robot, slot.start_ns, slot.length_s, OPERATOR
        )
        now_ns = books.clock.wall_ns()
        said = [Decided(act="book", by=OPERATOR, about=f.key, at_ns=now_ns) for f in facts]
        return (*said, *facts)

    def _check_apart(self, asked: BookParameters) -> None:
        """See that no two of the slots themselves take the same robot at one time."""
        spans: defaultdict[RobotId, list[tuple[int, int]]] = defaultdict(list)
        for slot in asked.slots:
            end_ns = slot.start_ns + slot.length_s * SECOND_NS
            spans[slot.robot].append((slot.start_ns, end_ns))
        for robot, some in spans.items():
            if any(later[0] < earlier[1] for earlier, later in pairwise(sorted(some))):
                shown = self._books.shown(robot)
                raise RobotTaken(f"{shown} would be given twice at one time. Nothing was booked.")

    def _check_shares(self, asked: BookParameters) -> None:
        """See that nobody gets more slots to come than one person may have."""
        now_ns, most = self._books.clock.wall_ns(), self._calendar.limits.most_upcoming
        for who, more in Counter(slot.principal for slot in asked.slots).items():
            upcoming = sum(slot.end_ns > now_ns for slot in self._calendar.of(who))
            if upcoming + more > most:
                raise TooManyRequests(
                    f"{self._books.name(who)} would have {upcoming + more} slots to come, and at "
                    f"most {most} are possible. Nothing was booked.",
                    retry_after_s=float(DAY_S),
                )


# ---- from wishes to a problem ----

_HOURS = re.compile(r"(\d{1,2}:\d{2})\s*-\s*(\d{1,2}:\d{2})")
READERS = {".csv": wishes_from_csv, ".json": wishes_from_json}


def merged_who(parts: Iterable[KnownNames]) -> KnownNames:
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
    return KnownNames(people=people, names=names, robots=robots, zone=zone)


def read_wishes(path: Path, who: KnownNames) -> tuple[tuple[Wish, ...], tuple[str, ...]]:
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
    from_ns = -(-now_ns // MINUTE_NS) * MINUTE_NS
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
    wishes: tuple[Wish, ...],
    who: KnownNames,
    taken: Iterable[TakenSlot],
    openings: tuple[Span, ...] = (),
) -> PlanningProblem:
    """Return the problem: wishes, the robots there are, what is booked, when it is open."""
    robots = tuple(dict.fromkeys(robot for some in who.robots.values() for robot in some))
    booked = tuple(StandingSlot(*slot) for part in taken for slot in part.slots)
    return PlanningProblem(wishes=wishes, robots=robots, booked=booked, openings=openings)
