"""When? ``tomorrow 14:00 1h``, ``mon 9-10``, ``every tue 14:00 1h until 2027-02-01``.

Pure: what time it is, and what the clocks of the person's zone show at some moment, are arguments.
Total: any text gives a `When` or a `Misunderstood`, in time linear in the text.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.civil import (
    LAST_YEAR,
    MINUTE_NS,
    MINUTES_A_DAY,
    MONTHS,
    Local,
    date_of,
    day_number,
    is_date,
    month_length,
    weekday_of,
)
from rosic.core.language.lines import Misunderstood
from rosic.core.language.when_said import Said, Unclear

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.language.when_said import Date

EXAMPLES = ("tomorrow 14:00 1h", "today 9-10", "now 30 min", "every tue 14:00 1h until 2027-02-01")

_LONGEST_DELAY_S = 366 * 86_400
_CODES = ("MO", "TU", "WE", "TH", "FR", "SA", "SU")
_A_WEEK = 7


class When(msgspec.Struct, frozen=True):
    """A time that was asked for, on the wall clock of the person's zone.

    Attributes:
        start: What the clock shows at the (first) start.
        length_s: Real seconds; of ``9-10`` what the hands move. 0 is possible, negative is not.
        ends: What the clock shows at the end, if that is what was said: where the clocks change
            between start and end, this is meant, and not ``length_s``.
        start_ns: Of ``now`` and ``in 20 min`` the moment itself, cut to the minute: it is meant
            even where the clock shows its ``start`` twice.
        rrule: RFC 5545, if it comes again; perhaps with no end. A rule that was typed as a rule
            stands here as it was typed.
    """

    start: Local
    length_s: int
    ends: Local | None = None
    start_ns: int | None = None
    rrule: str = ""


def read_when(text: str, now_ns: int, local_at: Callable[[int], Local]) -> When | Misunderstood:
    """Read when somebody wants something, and for how long.

    Args:
        text: What was typed. A time that is over is read all the same; it is refused elsewhere.
        now_ns: Wall clock, UTC.
        local_at: What the person's clock shows at a moment (wall clock, UTC).
    """
    try:
        return _Reckoning(Said(text), now_ns, local_at).when()
    except Unclear as unclear:
        sentence, offers = str(unclear), unclear.offers
        if not offers:
            offers = EXAMPLES
            sentence = f"{sentence} Write it as {EXAMPLES[0]}, or the day as 2027-02-01."
        return Misunderstood(sentence, offers)


class _Reckoning:
    """Works out when that is which was said."""

    def __init__(self, said: Said, now_ns: int, local_at: Callable[[int], Local]) -> None:
        self._said = said
        self._now_ns = now_ns
        self._now = local_at(now_ns)
        self._local_at = local_at

    def when(self) -> When:
        said = self._said
        if said.delay_s is not None:
            return self._soon(said.delay_s)
        if said.start is None:
            raise self._what_time()
        if said.rrule and said.every:
            raise Unclear("That says twice how often.")
        start = self._clock_time(self._day(said.start), said.start)
        length_s, ends = self._length(start)
        return When(start, length_s, ends, None, said.rrule or self._rule(start))

    def _soon(self, delay_s: float) -> When:
        said = self._said
        days = said.day is not None or said.weekdays or said.date or said.start is not None
        if days or said.every or said.rrule or said.until or said.count:
            raise Unclear("That says two times at once.")
        if delay_s > _LONGEST_DELAY_S:
            raise Unclear("That is further away than a year; name the day.", "2027-02-01 14:00 1h")
        start_ns = (self._now_ns + int(delay_s * 1e9)) // MINUTE_NS * MINUTE_NS
        start = self._local_at(start_ns)
        length_s, ends = self._length(start)
        return When(start, length_s, ends, start_ns)

    def _what_time(self) -> Unclear:
        said = self._said
        if said.length_s is None and not (said.weekdays or said.date or said.day is not None):
            return Unclear("When, and for how long?", *EXAMPLES)
        length = _length_text(said.length_s)
        today = Local.at(self._now.day_number).date_text()
        return Unclear("At what time?", f"tomorrow 14:00 {length}", f"{today} 14:00 {length}")

    # ---- the day ----

    def _day(self, minute: int) -> int:
        """Return the day's number: the named one, or the next on which the time is to come."""
        said = self._said
        if sum((said.day is not None, bool(said.weekdays), said.date is not None)) > 1:
            return self._checked_day()
        today = self._now.day_number
        over = minute < self._now.minute_of_day
        if said.day is not None:
            return today + said.day
        if said.date is not None:
            return self._dated(said.date, today)
        if not said.weekdays:
            return today + over
        if len(said.weekdays) > 1 and not said.every:
            raise Unclear("On one day, or on each of these?", "every mon and tue 9:00 1h 5 times")
        return next(
            day for day in range(today + over, today + over + _A_WEEK)
            if weekday_of(day) in said.weekdays
        )  # fmt: skip

    def _checked_day(self) -> int:
        """Return a day said in two ways, as in ``Tue 24 Nov``: they have to agree."""
        said = self._said
        if said.date is None or said.day is not None or said.every:
            raise Unclear("That says two days at once.")
        day = self._dated(said.date, self._now.day_number)
        if weekday_of(day) not in said.weekdays:
            raise Unclear("That date is another day of the week.", self._again(day))
        return day

    def _dated(self, date: Date, today: int) -> int:
        """Return the number of a date; without a year, of the next one that is not over."""
        year, month, day = date
        years = range(self._now.year, min(self._now.year + 9, LAST_YEAR)) if year is None else ()
        for candidate in years or (year or 0,):
            if is_date(candidate, month, day):
                number = day_number(candidate, month, day)
                if year is not None or number >= today:
                    return number
        raise self._no_such_day(year or self._now.year, month, day)

    def _no_such_day(self, year: int, month: int, day: int) -> Unclear:
        if not is_date(year, month, 1):
            return Unclear("There is no such month.", self._again(self._now.day_number))
        last = day_number(year, month, month_length(year, month))
        name = MONTHS[month - 1]
        return Unclear(f"{name} {year} has no day {day}.", self._again(last))

    def _again(self, day: int) -> str:
        """Return what would be understood, on another day."""
        said = self._said
        clock = Local.at(0, said.start or 0).time_text() if said.start else "14:00"
        year, month, date = date_of(day)
        return f"{year}-{month:02}-{date:02} {clock} {_length_text(said.length_s)}"

    def _clock_time(self, day: int, minute: int) -> Local:
        try:
            return Local.at(day, minute)
        except ValueError:
            raise Unclear("That is further away than the calendar goes.") from None

    # ---- how long ----

    def _length(self, start: Local) -> tuple[int, Local | None]:
        """Return the length in seconds, and the end if that is what was said."""
        said = self._said
        if said.end is None and said.length_s is None:
            offers = [f"{self._typed(start)} {length}" for length in ("30 min", "1h", "2h")]
            raise Unclear("For how long?", *offers)
        if said.end is None:
            return round(said.length_s or 0.0), None
        if said.length_s is not None:
            raise Unclear("That says how long, and until when. One of them is enough.")
        minutes = (said.end - start.minute_of_day) % MINUTES_A_DAY
        if not minutes:
            raise Unclear("That ends as it begins.", f"{self._typed(start)} 1h")
        return minutes * 60, self._clock_time(start.day_number, start.minute_of_day + minutes)

    def _typed(self, start: Local) -> str:
        if self._said.delay_s is not None:
            return "now"
        return f"{start.date_text()} {start.time_text()}"

    # ---- again and again ----

    def _rule(self, start: Local) -> str:
        said = self._said
        if not said.every:
            if said.until or said.count is not None:
                raise Unclear("Every which day until then?", "every tue 14:00 1h until 2027-02-01")
            return ""
        parts = ["FREQ=DAILY" if len(said.weekdays) == _A_WEEK else "FREQ=WEEKLY"]
        if said.every > 1:
            parts.append(f"INTERVAL={said.every}")
        if len(said.weekdays) < _A_WEEK:
            parts.append("BYDAY=" + ",".join(_CODES[day] for day in said.weekdays))
        parts.extend(self._end_of_rule(start))
        return ";".join(parts)

    def _end_of_rule(self, start: Local) -> list[str]:
        said = self._said
        if said.until is not None and said.count is not None:
            raise Unclear("That ends on a day and after a number of times. One is enough.")
        if said.count is not None:
            if said.count < 1:
                raise Unclear("At least once.", "every tue 14:00 1h 10 times")
            return [f"COUNT={said.count}"]
        if said.until is None:
            return []
        last = self._dated(said.until, start.day_number)
        if last < start.day_number:
            raise Unclear("That is over before it begins.", "every tue 14:00 1h 10 times")
        year, month, day = date_of(last)
        return [f"UNTIL={year:04}{month:02}{day:02}T235959"]


def _length_text(length_s: float | None) -> str:
    if not length_s:
        return "1h"
    hours, rest = divmod(round(length_s), 3600)
    minutes = f"{rest // 60} min" if rest >= 60 else "" if hours else "1 min"  # noqa: PLR2004
    return " ".join(part for part in (f"{hours} h" if hours else "", minutes) if part)
