"""Days and wall clocks: the Gregorian calendar without zones. Nothing here asks what time it is."""

from __future__ import annotations

from calendar import monthrange
from datetime import date

import msgspec

from rosic.core.i18n import said
from rosic.core.time_units import MINUTES_A_DAY

FIRST_YEAR = 1970
LAST_YEAR = 2199

WEEKDAYS = (
    said("Mon"),
    said("Tue"),
    said("Wed"),
    said("Thu"),
    said("Fri"),
    said("Sat"),
    said("Sun"),
)
MONTHS = (
    said("Jan"),
    said("Feb"),
    said("Mar"),
    said("Apr"),
    said("May"),
    said("Jun"),
    said("Jul"),
    said("Aug"),
    said("Sep"),
    said("Oct"),
    said("Nov"),
    said("Dec"),
)

_EPOCH = date(1970, 1, 1).toordinal()


def month_length(year: int, month: int) -> int:
    """Return how many days a month (1 to 12) has."""
    return monthrange(year, month)[1]


def is_date(year: int, month: int, day: int) -> bool:
    """Whether there is such a day, in the years that are kept here."""
    try:
        return FIRST_YEAR <= date(year, month, day).year <= LAST_YEAR
    except (ValueError, OverflowError):
        return False


def day_number(year: int, month: int, day: int) -> int:
    """Return how many days after 1 January 1970 a date is."""
    return date(year, month, day).toordinal() - _EPOCH


def date_of(number: int) -> tuple[int, int, int]:
    """Return year, month and day of a day number: the inverse of `day_number`.

    Raises:
        ValueError: Further away than any calendar goes.
    """
    try:
        found = date.fromordinal(number + _EPOCH)
    except (ValueError, OverflowError):
        raise ValueError("there is no such day") from None
    return found.year, found.month, found.day


def weekday_of(number: int) -> int:
    """Return the weekday of a day number, Monday being 0."""
    return date.fromordinal(number + _EPOCH).weekday()


class LocalTime(msgspec.Struct, frozen=True, gc=False, order=True):
    """What a clock and a calendar on some wall show, to the minute. It does not say which wall."""

    year: int
    month: int
    day: int
    hour: int = 0
    minute: int = 0

    def __post_init__(self) -> None:
        if not is_date(self.year, self.month, self.day):
            raise ValueError("there is no such day")
        if not (0 <= self.hour < 24 and 0 <= self.minute < 60):  # noqa: PLR2004
            raise ValueError("there is no such time of day")

    @classmethod
    def at(cls, day: int, minute: int = 0) -> LocalTime:
        """Return the wall clock at a minute of a numbered day; minutes may run over midnight.

        Raises:
            ValueError: Before 1970 or after 2199.
        """
        over, minute = divmod(minute, MINUTES_A_DAY)
        return cls(*date_of(day + over), *divmod(minute, 60))

    @property
    def day_number(self) -> int:
        """Days since 1 January 1970."""
        return day_number(self.year, self.month, self.day)

    @property
    def minute_of_day(self) -> int:
        """Minutes since midnight, as the wall clock counts them."""
        return self.hour * 60 + self.minute

    def minutes_since(self, other: LocalTime) -> int:
        """Return how far the hands have moved since another reading of the same clock."""
        days = self.day_number - other.day_number
        return days * MINUTES_A_DAY + self.minute_of_day - other.minute_of_day

    def later(self, minutes: int) -> LocalTime:
        """Return what the hands show after moving on."""
        return LocalTime.at(self.day_number, self.minute_of_day + minutes)

    def date_text(self) -> str:
        """Return ``2026-11-24``: as it is typed, and as no country misreads it."""
        return f"{self.year}-{self.month:02}-{self.day:02}"

    def time_text(self) -> str:
        """Return ``14:00``."""
        return f"{self.hour:02}:{self.minute:02}"
