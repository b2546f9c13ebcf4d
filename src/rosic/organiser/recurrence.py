"""RRULE of RFC 5545, on a wall clock. The one home of python-dateutil.

Only rules that come again within weeks or months, so that working one out stays cheap: dateutil
looks for the next match until the year 9999, and a rule that never matches would hold everybody up.
"""

from __future__ import annotations

import re
from datetime import datetime
from itertools import islice
from typing import TYPE_CHECKING

import msgspec
from dateutil.rrule import rrule, rrulestr

from rosic.core.i18n import said
from rosic.core.language.sanitise import quote
from rosic.core.local_time import MINUTE_NS, LocalTime, month_length
from rosic.errors import NotUnderstood, OutOfBounds

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.organiser.timezones import Zone

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
