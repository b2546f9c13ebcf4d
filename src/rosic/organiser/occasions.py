"""From what was said to moments: a time once, and a time that comes again."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import msgspec

from rosic.core.local_time import LocalTime
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.organiser import calendar_messages as words
from rosic.organiser.recurrence import occurrences, read_rule
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from rosic.core.language.time_parser import When
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import Pattern
    from rosic.organiser.timezones import Zone


class SeriesLimits(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What may be booked.

    Attributes:
        grace_s: A start this long ago still counts as now: somebody had to tap a button.
        ahead_s: How far ahead a slot may start.
        most_upcoming: How many slots one person may have before them, those of series too.
        most_occurrences: How many slots one series may have.
        most_in_all: Of everybody, with those of the past that are still kept.
        useful_s: A gap shorter than this is not named as the next free time.
        warnings_s: How long before the end of a slot to warn.
    """

    shortest_s: int = 60
    longest_s: int = 86_400
    grace_s: int = 120
    ahead_s: int = 731 * 86_400
    most_upcoming: int = 500
    most_occurrences: int = 400
    most_in_all: int = 200_000
    useful_s: int = 900
    warnings_s: tuple[int, ...] = (300, 60)

    def __post_init__(self) -> None:
        if not 1 <= self.shortest_s <= self.longest_s <= self.ahead_s:
            raise ValueError("shortest_s, longest_s and ahead_s have to grow, from 1 on")
        if not (self.grace_s >= 0 and self.useful_s >= 1 and all(s > 0 for s in self.warnings_s)):
            raise ValueError("useful_s and warnings_s have to be positive, grace_s not negative")
        if not min(self.most_upcoming, self.most_occurrences, self.most_in_all) >= 1:
            raise ValueError("at least one slot has to be possible")


class SlotOccasion(msgspec.Struct, frozen=True):
    """One time, as a moment.

    Attributes:
        start_ns: Wall clock, UTC.
        length_s: Real seconds.
        note: What the person should know about it; mostly empty.
    """

    start_ns: int
    length_s: int
    note: str = ""


class Occurrence(msgspec.Struct, frozen=True):
    """One time of a series.

    Attributes:
        local: What the rule says.
        start_ns: When that is, wall clock, UTC.
        moved: The clocks skip that time; it comes later by as much (RFC 5545).
    """

    local: LocalTime
    start_ns: int
    moved: bool = False


def occasion(robot: RobotId, when: When, zone: Zone) -> SlotOccasion:
    """Return when that is which was typed.

    Args:
        robot: For what is offered instead.
        when: On the wall.
        zone: Of that wall.

    Raises:
        OutOfBounds: The clocks of the zone skip the start or the end. The sentence says why, and
            what is possible.
    """
    if when.start_ns is not None:
        start_ns, note = when.start_ns, ""
    else:
        start_ns, note = _moment(robot, when, when.start, zone)
    if when.ends is None:
        return SlotOccasion(start_ns, when.length_s, note)
    end_ns, end_note = _moment(robot, when, when.ends, zone)
    return SlotOccasion(start_ns, (end_ns - start_ns) // 1_000_000_000, note or end_note)


def _moment(robot: RobotId, when: When, local: LocalTime, zone: Zone) -> tuple[int, str]:
    found = zone.instant(local)
    if found.kind == "never":
        start = found.possible if local is when.start else when.start
        raise OutOfBounds(
            words.skipped(local, zone, found.possible),
            offers=(words.bookable_at(robot, start, when.length_s),),
        )
    return found.start_ns, words.comes_twice(local, zone) if found.kind == "twice" else ""


def occasions(pattern: Pattern, now_ns: int, limits: SeriesLimits) -> tuple[Occurrence, ...]:
    """Return when a series comes: at least once, in order, without overlap.

    Raises:
        NotUnderstood: The rule is malformed or has no end.
        OutOfBounds: No such zone; the rule comes too often, too far ahead, never, or overlaps
            itself.
    """
    zone = zone_named(pattern.zone)
    rule = read_rule(pattern.rrule, zone)
    if not rule.ends:
        raise NotUnderstood(words.no_end())
    last = zone.local(now_ns + limits.ahead_s * 1_000_000_000)
    locals_ = occurrences(rule, pattern.first, last, limits.most_occurrences)
    if len(locals_) > limits.most_occurrences:
        raise OutOfBounds(words.too_often(limits.most_occurrences))
    owed = rule.count is not None and len(locals_) < rule.count
    if owed or (rule.until is not None and rule.until > last):
        raise OutOfBounds(words.too_far(words.day(last, zone.local(now_ns))))
    if not locals_:
        raise OutOfBounds(words.never_comes())
    found = tuple(_occurrence(local, zone) for local in locals_)
    length_ns = pattern.length_s * 1_000_000_000
    for one, other in pairwise(found):
        if one.start_ns + length_ns > other.start_ns:
            raise OutOfBounds(words.overlaps_itself())
    return found


def _occurrence(local: LocalTime, zone: Zone) -> Occurrence:
    instant = zone.instant(local)
    return Occurrence(local, instant.start_ns, instant.kind == "never")
