"""A calendar to try things with; its clock stands at 10:00 in Vienna on 21 November 2026."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.local_time import LocalTime
from rosic.organiser.calendar import Calendar, CalendarNames
from rosic.organiser.timezones import zone_named
from rosic.testing.clock import ManualClock

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.core.records import Fact
    from rosic.core.slot import BookedSlot
    from rosic.organiser.recurrence import SeriesLimits

S = 1_000_000_000
MIN = 60 * S
HOUR = 60 * MIN
VIENNA = zone_named("Europe/Vienna")
NOW = VIENNA.instant(LocalTime(2026, 11, 21, 10)).start_ns
NAMES = {"ann": "Ann", "ben": "Ben", "kuka1": "KUKA iiwa"}


IN_VIENNA = CalendarNames(
    lambda who: NAMES.get(who, who),
    lambda robot: NAMES.get(robot, robot),
    lambda _: "Europe/Vienna",
)
UNNAMED = CalendarNames(str, str, lambda _: "UTC")


def a_calendar(
    now_ns: int = NOW, limits: SeriesLimits | None = None
) -> tuple[Calendar, ManualClock]:
    clock = ManualClock(now_ns)
    return Calendar(clock, IN_VIENNA, limits), clock


def write(calendar: Calendar, facts: Iterable[Fact]) -> tuple[BookedSlot, ...]:
    """Do what the caller does once the facts are on disk; return the slots among them."""
    facts = tuple(facts)
    for fact in facts:
        calendar.apply(fact)
    found = (calendar.slot(fact.key) for fact in facts)
    return tuple(slot for slot in found if slot is not None)


def booked(
    calendar: Calendar,
    start_ns: int,
    length_s: int = 3600,
    *,
    who: str = "ann",
    robot: str = "kuka1",
) -> BookedSlot:
    (slot,) = write(calendar, calendar.book(who, robot, start_ns, length_s, who))
    return slot
