from __future__ import annotations

from datetime import date, timedelta

import pytest

from rosic.core.local_time import (
    FIRST_YEAR,
    LAST_YEAR,
    LocalTime,
    date_of,
    day_number,
    is_date,
    month_length,
    weekday_of,
)


def test_every_day_of_two_centuries_is_that_of_the_standard_library() -> None:
    day, last = date(FIRST_YEAR, 1, 1), date(LAST_YEAR, 12, 31)
    for number in range((last - day).days + 1):
        found = day + timedelta(number)
        assert date_of(number) == (found.year, found.month, found.day)
        assert day_number(found.year, found.month, found.day) == number
        assert weekday_of(number) == found.weekday()


def test_the_calendar_is_gregorian() -> None:
    """Counted here without a library: every fourth is a leap year; 2100 is not, 2000 is."""
    number, weekday = 0, 3  # 1 January 1970, a Thursday
    for year in range(FIRST_YEAR, LAST_YEAR + 1):
        february = 28 + (year % 4 == 0 and year != 2100)
        lengths = (31, february, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)
        for month, days in enumerate(lengths, 1):
            assert month_length(year, month) == days
            assert not is_date(year, month, days + 1)
            for day in range(1, days + 1):
                assert is_date(year, month, day)
                assert (day_number(year, month, day), date_of(number)) == (
                    number,
                    (year, month, day),
                )
                assert weekday_of(number) == weekday
                number, weekday = number + 1, (weekday + 1) % 7


@pytest.mark.parametrize("days", [-1, 84_006, 10**9, 10**30, -(10**30)])
def test_a_day_beyond_the_calendar_is_refused_as_such(days: int) -> None:
    with pytest.raises(ValueError, match="no such day"):
        LocalTime.at(days)


def test_months_are_as_long_as_they_are() -> None:
    assert [month_length(2027, month) for month in (1, 2, 4, 12)] == [31, 28, 30, 31]
    assert (month_length(2028, 2), month_length(2100, 2), month_length(2000, 2)) == (29, 28, 29)


@pytest.mark.parametrize(
    "parts", [(2027, 2, 29), (2027, 0, 1), (2027, 13, 1), (1969, 1, 1), (2200, 1, 1), (2027, 4, 31)]
)
def test_there_is_no_such_day(parts: tuple[int, int, int]) -> None:
    assert not is_date(*parts)
    with pytest.raises(ValueError, match="no such day"):
        LocalTime(*parts)


@pytest.mark.parametrize("clock", [(24, 0), (-1, 0), (0, 60), (0, -1)])
def test_there_is_no_such_time_of_day(clock: tuple[int, int]) -> None:
    with pytest.raises(ValueError, match="no such time"):
        LocalTime(2027, 1, 1, *clock)


def test_hands_move_over_midnight_and_back() -> None:
    late = LocalTime(2026, 12, 31, 23, 30)
    assert late.later(45) == LocalTime(2027, 1, 1, 0, 15)
    assert late.later(45).minutes_since(late) == 45
    assert LocalTime(2027, 1, 1, 0, 15).later(-45) == late
    assert late < late.later(1)
    assert (late.date_text(), late.time_text()) == ("2026-12-31", "23:30")


def test_the_calendar_ends() -> None:
    with pytest.raises(ValueError, match="no such day"):
        LocalTime(2199, 12, 31, 23, 59).later(1)
