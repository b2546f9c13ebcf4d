"""RRULE of RFC 5545, on a wall clock. The one home of python-dateutil.

Only rules that come again within weeks or months, so that working one out stays cheap: dateutil
looks for the next match until the year 9999, and a rule that never matches would hold everybody up.
"""

from __future__ import annotations

import re
from datetime import datetime
from itertools import islice, pairwise
from typing import TYPE_CHECKING

import msgspec
from dateutil.rrule import rrule, rrulestr

from rosic.core.i18n import said
from rosic.core.language.sanitise import quote
from rosic.core.local_time import LocalTime, month_length
from rosic.core.time_units import DAY_S, MINUTE_NS, SECOND_NS
from rosic.errors import NotUnderstood, OutOfBounds
from rosic.organiser import calendar_messages as words
from rosic.organiser.timezones import zone_named

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.time_parser import RequestedTime
    from rosic.core.robot.profile import RobotId
    from rosic.core.slot import Pattern
    from rosic.organiser.timezones import Zone


# ---- RRULE of RFC 5545 ----

LONGEST_RULE = 256
MOST_INTERVAL = {"DAILY": 366, "WEEKLY": 52, "MONTHLY": 11}

_DAY = r"(?:MO|TU|WE|TH|FR|SA|SU)"
_SHAPES = {
    "FREQ": re.compile(r"(?:DAILY|WEEKLY|MONTHLY)\Z"),
    "INTERVAL": re.compile(r"[1-9]\d{0,2}\Z", re.ASCII),
    "COUNT": re.compile(r"[1-9]\d{0,5}\Z", re.ASCII),
    "UNTIL": re.compile(r"\d{8}(?:T\d{6}Z?)?\Z", re.ASCII),
    "BYDAY": re.compile(rf"(?:[+-]?[1-5])?{_DAY}(?:,(?:[+-]?[1-5])?{_DAY}){{0,6}}\Z", re.ASCII),
    "BYMONTHDAY": re.compile(r"-?[1-9]\d?(?:,-?[1-9]\d?){0,30}\Z", re.ASCII),
    "BYMONTH": re.compile(r"(?:[1-9]|1[0-2])(?:,(?:[1-9]|1[0-2])){0,11}\Z", re.ASCII),
    "BYSETPOS": re.compile(r"-?[1-4]\Z", re.ASCII),
    "WKST": re.compile(_DAY + r"\Z"),
}
_EXAMPLE = said("Write it as FREQ=WEEKLY;BYDAY=TU;COUNT=10.")
_A_LEAP_YEAR = 2000
_MOST_DAYS = 31


class RecurrenceRule(msgspec.Struct, frozen=True):
    """A rule that was looked at and found fit to be worked out.

    Attributes:
        body: Without its end.
        count: How often at most; None when the rule does not say.
        until: The last start that counts; None when the rule does not say.
    """

    body: str
    count: int | None
    until: LocalTime | None

    @property
    def ends(self) -> bool:
        """Whether it says when it is over."""
        return self.count is not None or self.until is not None


def read_rule(text: str, zone: Zone) -> RecurrenceRule:
    """Read an RRULE, with or without the word itself.

    Args:
        text: As typed or as it came in a calendar file.
        zone: Whose wall clock an ``UNTIL`` in UTC is turned into.

    Raises:
        NotUnderstood: Malformed, or more than is done here. The sentence says which part.
    """
    parts = _parts(text)
    for name, value in parts.items():
        if not _SHAPES[name].match(value):
            raise _unfit(f"{name}={value}")
    _check_together(parts)
    if "COUNT" in parts and "UNTIL" in parts:
        raise NotUnderstood(
            said("A rule has an UNTIL or a COUNT, not both. {example}", example=_EXAMPLE)
        )
    until = _until(parts["UNTIL"], zone) if "UNTIL" in parts else None
    count = int(parts["COUNT"]) if "COUNT" in parts else None
    body = ";".join(f"{k}={v}" for k, v in parts.items() if k not in {"COUNT", "UNTIL"})
    return RecurrenceRule(body, count, until)


def occurrences(
    rule: RecurrenceRule, first: LocalTime, last: LocalTime, most: int
) -> tuple[LocalTime, ...]:
    """Return when a rule comes, on the wall clock, from ``first`` on.

    Args:
        rule: From `read_rule`.
        first: Where counting begins; itself an occurrence only if it fits the rule.
        last: Nothing after this is wanted. Occurrences that `count` still owes are then missing.
        most: More are not worked out: at most one more than this is returned.
    """
    end = min(last, rule.until or last)
    if end < first:
        return ()
    found = rrulestr(rule.body, dtstart=_wall(first))
    assert isinstance(found, rrule)  # noqa: S101 - a single rule, as its shape was checked
    wanted = min(rule.count or most + 1, most + 1)
    starts = islice(found.replace(until=_wall(end)), wanted)
    return tuple(LocalTime(s.year, s.month, s.day, s.hour, s.minute) for s in starts)


def _wall(local: LocalTime) -> datetime:
    return datetime(local.year, local.month, local.day, local.hour, local.minute)  # noqa: DTZ001 - of no zone, as RFC 5545 counts


def _parts(text: str) -> dict[str, str]:
    """Take a rule apart; each part once, and only parts that are known here."""
    if len(text) > LONGEST_RULE:
        raise NotUnderstood(
            said(
                "That rule has over {longest_rule} characters. {example}",
                longest_rule=LONGEST_RULE,
                example=_EXAMPLE,
            )
        )
    parts: dict[str, str] = {}
    for part in text.strip().upper().removeprefix("RRULE:").split(";"):
        name, _, value = part.partition("=")
        if name not in _SHAPES or name in parts:
            raise _unfit(part or text)
        parts[name] = value
    if "FREQ" not in parts:
        raise NotUnderstood(said("That rule does not say how often. {example}", example=_EXAMPLE))
    return parts


def _unfit(part: str) -> NotUnderstood:
    return NotUnderstood(
        said("I cannot use {quote} in a rule. {example}", quote=quote(part), example=_EXAMPLE)
    )


def _check_together(parts: Mapping[str, str]) -> None:
    """Refuse what together could never come: each of these alone is fine."""
    often = parts["FREQ"]
    interval = int(parts.get("INTERVAL", "1"))
    if interval > MOST_INTERVAL[often]:
        raise _unfit(f"INTERVAL={interval}")
    narrowed = [name for name in ("BYDAY", "BYMONTHDAY", "BYMONTH") if name in parts]
    if interval > 1 and ("BYMONTH" in parts or (often == "DAILY" and narrowed)):
        raise _unfit(f"INTERVAL={interval} with {narrowed[-1]}")
    if "BYMONTHDAY" in parts:
        _check_month_days(parts)
    ordinal = any(c.isdigit() for c in parts.get("BYDAY", ""))
    if often != "MONTHLY" and (ordinal or "BYSETPOS" in parts):
        raise _unfit(f"FREQ={often} with {'BYDAY' if ordinal else 'BYSETPOS'}")
    if "BYSETPOS" in parts and ("BYDAY" not in parts or ordinal):
        raise _unfit(f"BYSETPOS={parts['BYSETPOS']}")


def _check_month_days(parts: Mapping[str, str]) -> None:
    days = [abs(int(day)) for day in parts["BYMONTHDAY"].split(",")]
    months = [int(month) for month in parts.get("BYMONTH", "1").split(",")]
    longest = max(month_length(_A_LEAP_YEAR, month) for month in months)
    if "BYDAY" in parts or parts["FREQ"] == "WEEKLY" or max(days) > _MOST_DAYS:
        raise _unfit(f"BYMONTHDAY={parts['BYMONTHDAY']}")
    if min(days) > longest:
        raise OutOfBounds(said("None of these months has that many days. Nothing was booked."))


def _until(text: str, zone: Zone) -> LocalTime:
    """Read the end of a rule; a day alone counts to its end."""
    clock = text[9:13] if len(text) > len("20270201") else "2359"
    try:
        given = LocalTime(
            int(text[:4]), int(text[4:6]), int(text[6:8]), int(clock[:2]), int(clock[2:])
        )
    except ValueError:
        raise _unfit(f"UNTIL={text}") from None
    if not text.endswith("Z"):
        return given
    minutes = given.minutes_since(LocalTime(1970, 1, 1))
    return zone.local(minutes * MINUTE_NS)


# ---- from what was said to moments ----


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
    longest_s: int = DAY_S
    grace_s: int = 120
    ahead_s: int = 731 * DAY_S
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


def occasion(robot: RobotId, when: RequestedTime, zone: Zone) -> SlotOccasion:
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
    return SlotOccasion(start_ns, (end_ns - start_ns) // SECOND_NS, note or end_note)


def _moment(robot: RobotId, when: RequestedTime, local: LocalTime, zone: Zone) -> tuple[int, str]:
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
    last = zone.local(now_ns + limits.ahead_s * SECOND_NS)
    locals_ = occurrences(rule, pattern.first, last, limits.most_occurrences)
    if len(locals_) > limits.most_occurrences:
        raise OutOfBounds(words.too_often(limits.most_occurrences))
    owed = rule.count is not None and len(locals_) < rule.count
    if owed or (rule.until is not None and rule.until > last):
        raise OutOfBounds(words.too_far(words.day(last, zone.local(now_ns))))
    if not locals_:
        raise OutOfBounds(words.never_comes())
    found = tuple(_occurrence(local, zone) for local in locals_)
    length_ns = pattern.length_s * SECOND_NS
    for one, other in pairwise(found):
        if one.start_ns + length_ns > other.start_ns:
            raise OutOfBounds(words.overlaps_itself())
    return found


def _occurrence(local: LocalTime, zone: Zone) -> Occurrence:
    instant = zone.instant(local)
    return Occurrence(local, instant.start_ns, instant.kind == "never")
