"""When? ``tomorrow 14:00 1h``, ``mon 9-10``, ``every tue 14:00 1h until 2027-02-01``.

Pure: what time it is, and what the clocks of the person's zone show at some moment, are arguments.
Total: any text gives a `RequestedTime` or a `Misunderstood`, in time linear in the text.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.i18n import said
from rosic.core.language.ast import Misunderstood
from rosic.core.language.time_tokens import TimeTokens, UnclearTime
from rosic.core.language.time_words import shown_when
from rosic.core.local_time import (
    LAST_YEAR,
    MONTHS,
    LocalTime,
    date_of,
    day_number,
    is_date,
    month_length,
    weekday_of,
)
from rosic.core.time_units import DAY_S, HOUR_S, MINUTE_NS, MINUTES_A_DAY

if TYPE_CHECKING:
    from collections.abc import Callable

from rosic.core.language.time_tokens import Date

# Good at any time: none of them is over before somebody taps it.
EXAMPLES = ("tomorrow 14:00 1h", "mon 9-10", "now 30 min", "every tue 14:00 1h 10 times")

_LONGEST_DELAY_S = 366 * DAY_S
_CODES = ("MO", "TU", "WE", "TH", "FR", "SA", "SU")
_A_WEEK = 7
_A_YEAR = 365
_TWO = 14 * 60


class RequestedTime(msgspec.Struct, frozen=True):
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

    start: LocalTime
    length_s: int
    ends: LocalTime | None = None
    start_ns: int | None = None
    rrule: str = ""


def read_when(
    text: str, now_ns: int, local_at: Callable[[int], LocalTime]
) -> RequestedTime | Misunderstood:
    """Read when somebody wants something, and for how long.

    Args:
        text: What was typed. A time that is over is read all the same; it is refused elsewhere.
        now_ns: Wall clock, UTC.
        local_at: What the person's clock shows at a moment (wall clock, UTC).
    """
    try:
        return _Reckoning(TimeTokens(text), now_ns, local_at).when()
    except UnclearTime as unclear:
        sentence, offers = unclear.sentence, unclear.offers
        if not offers:
            offers = EXAMPLES
            sentence = said(
                "{sentence} Write it as {example}, or the day as 2027-02-01.",
                sentence=sentence,
                example=shown_when(EXAMPLES[0]),
            )
        return Misunderstood(sentence, offers)


class _Reckoning:
    """Works out when that is which was said."""

    def __init__(
        self, tokens: TimeTokens, now_ns: int, local_at: Callable[[int], LocalTime]
    ) -> None:
        self._tokens = tokens
        self._now_ns = now_ns
        self._now = local_at(now_ns)
        self._local_at = local_at

    def when(self) -> RequestedTime:
        given = self._tokens
        if given.delay_s is not None:
            return self._soon(given.delay_s)
        if given.start is None:
            raise self._what_time()
        if given.rrule and given.every:
            raise UnclearTime(said("That says twice how often."))
        start = self._clock_time(self._day(given.start), given.start)
        length_s, ends = self._length(start)
        return RequestedTime(start, length_s, ends, None, given.rrule or self._rule(start))

    def _soon(self, delay_s: float) -> RequestedTime:
        given = self._tokens
        days = given.day is not None or given.weekdays or given.date or given.start is not None
        if days or given.every or given.rrule or given.until or given.count:
            raise UnclearTime(said("That says two times at once."))
        if delay_s > _LONGEST_DELAY_S:
            raise UnclearTime(
                said("That is further away than a year; name the day."),
                self._again(self._now.day_number + _A_YEAR),
            )
        start_ns = (self._now_ns + int(delay_s * 1e9)) // MINUTE_NS * MINUTE_NS
        start = self._local_at(start_ns)
        length_s, ends = self._length(start)
        return RequestedTime(start, length_s, ends, start_ns)

    def _what_time(self) -> UnclearTime:
        given = self._tokens
        if given.length_s is None and not self._named_day():
            return UnclearTime(said("When, and for how long?"), *EXAMPLES)
        if given.every or given.rrule:
            return UnclearTime(said("At what time?"), EXAMPLES[-1])
        day = self._day(_TWO)
        days = dict.fromkeys((day,) if self._named_day() else (day, self._now.day_number + 1))
        return UnclearTime(said("At what time?"), *map(self._again, days))

    def _named_day(self) -> bool:
        given = self._tokens
        return bool(given.weekdays) or given.date is not None or given.day is not None

    # ---- the day ----

    def _day(self, minute: int) -> int:
        """Return the day's number: the named one, or the next on which the time is to come."""
        given = self._tokens
        if sum((given.day is not None, bool(given.weekdays), given.date is not None)) > 1:
            return self._checked_day()
        today = self._now.day_number
        over = minute < self._now.minute_of_day
        if given.day is not None:
            return today + given.day
        if given.date is not None:
            return self._dated(given.date, today)
        if not given.weekdays:
            return today + over
        if len(given.weekdays) > 1 and not given.every:
            raise UnclearTime(
                said("On one day, or on each of these?"), "every mon and tue 9:00 1h 5 times"
            )
        return next(
            day
            for day in range(today + over, today + over + _A_WEEK)
            if weekday_of(day) in given.weekdays
        )

    def _checked_day(self) -> int:
        """Return a day said in two ways, as in ``Tue 24 Nov``: they have to agree."""
        given = self._tokens
        if given.date is None or given.day is not None or given.every:
            raise UnclearTime(said("That says two days at once."))
        day = self._dated(given.date, self._now.day_number)
        if weekday_of(day) not in given.weekdays:
            raise UnclearTime(said("That date is another day of the week."), self._again(day))
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
        raise self._no_such_day(year, month, day)

    def _no_such_day(self, said_year: int | None, month: int, day: int) -> UnclearTime:
        year = said_year or self._now.year
        if not is_date(year, month, 1):
            return UnclearTime(said("There is no such month."), self._again(self._now.day_number))
        if said_year is None and day_number(year, month, 28) < self._now.day_number:
            year += 1  # the next such month is meant: this year's is over
        last = day_number(year, month, month_length(year, month))
        name = MONTHS[month - 1]
        return UnclearTime(
            said("{name} {year} has no day {day}.", name=name, year=year, day=day),
            self._again(last),
        )

    def _again(self, day: int) -> str:
        """Return what would be understood, on another day; not what is over today."""
        tokens = self._tokens
        start = _TWO if tokens.start is None else tokens.start
        day = max(day, self._now.day_number)
        day += day == self._now.day_number and start <= self._now.minute_of_day
        clock = LocalTime.at(0, start % MINUTES_A_DAY).time_text()
        year, month, date = date_of(day)
        return f"{year}-{month:02}-{date:02} {clock} {_length_text(tokens.length_s)}"

    def _clock_time(self, day: int, minute: int) -> LocalTime:
        try:
            return LocalTime.at(day, minute)
        except ValueError:
            raise UnclearTime(said("That is further away than the calendar goes.")) from None

    # ---- how long ----

    def _length(self, start: LocalTime) -> tuple[int, LocalTime | None]:
        """Return the length in seconds, and the end if that is what was said."""
        given = self._tokens
        if given.end is None and given.length_s is None:
            offers = [f"{self._typed(start)} {length}" for length in ("30 min", "1h", "2h")]
            raise UnclearTime(said("For how long?"), *offers)
        if given.end is None:
            return round(given.length_s or 0.0), None
        if given.length_s is not None:
            raise UnclearTime(said("That says how long, and until when. One of them is enough."))
        minutes = (given.end - start.minute_of_day) % MINUTES_A_DAY
        if not minutes:
            raise UnclearTime(said("That ends as it begins."), f"{self._typed(start)} 1h")
        return minutes * 60, self._clock_time(start.day_number, start.minute_of_day + minutes)

    def _typed(self, start: LocalTime) -> str:
        if self._tokens.delay_s is not None:
            return "now"
        return f"{start.date_text()} {start.time_text()}"

    # ---- again and again ----

    def _rule(self, start: LocalTime) -> str:
        given = self._tokens
        if not given.every:
            if given.until or given.count is not None:
                raise UnclearTime(said("Every which day until then?"), EXAMPLES[-1])
            return ""
        parts = ["FREQ=DAILY" if len(given.weekdays) == _A_WEEK else "FREQ=WEEKLY"]
        if given.every > 1:
            parts.append(f"INTERVAL={given.every}")
        if len(given.weekdays) < _A_WEEK:
            parts.append("BYDAY=" + ",".join(_CODES[day] for day in given.weekdays))
        parts.extend(self._end_of_rule(start))
        return ";".join(parts)

    def _end_of_rule(self, start: LocalTime) -> list[str]:
        given = self._tokens
        if given.until is not None and given.count is not None:
            raise UnclearTime(
                said("That ends on a day and after a number of times. One is enough.")
            )
        if given.count is not None:
            if given.count < 1:
                raise UnclearTime(said("At least once."), "every tue 14:00 1h 10 times")
            return [f"COUNT={given.count}"]
        if given.until is None:
            return []
        last = self._dated(given.until, start.day_number)
        if last < start.day_number:
            raise UnclearTime(said("That is over before it begins."), "every tue 14:00 1h 10 times")
        year, month, day = date_of(last)
        return [f"UNTIL={year:04}{month:02}{day:02}T235959"]


def _length_text(length_s: float | None) -> str:
    if not length_s:
        return "1h"
    hours, rest = divmod(round(length_s), HOUR_S)
    minutes = f"{rest // 60} min" if rest >= 60 else "" if hours else "1 min"  # noqa: PLR2004
    return " ".join(part for part in (f"{hours} h" if hours else "", minutes) if part)
