# ruff: noqa: RUF001 - people type what is ambiguous
"""When? Read in a fixed zone, one hour before Greenwich's noon of Saturday 21 November 2026."""

from __future__ import annotations

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosic.core.language.ast import Misunderstood
from rosic.core.language.time_parser import EXAMPLES, RequestedTime, read_when
from rosic.core.local_time import LocalTime, day_number
from rosic.core.time_units import DAY_NS, MINUTE_NS

HOURS_AHEAD = 1
NOW_NS = day_number(2026, 11, 21) * DAY_NS + (9 * 60 + 30) * MINUTE_NS + 17_000_000_000


def local_at(at_ns: int) -> LocalTime:
    return LocalTime.at(0, at_ns // MINUTE_NS + HOURS_AHEAD * 60)


def read(text: str) -> RequestedTime | Misunderstood:
    return read_when(text, NOW_NS, local_at)


def understood(text: str) -> RequestedTime:
    found = read(text)
    assert isinstance(found, RequestedTime), found
    return found


def over(text: str, now_ns: int = NOW_NS) -> bool:
    """Whether a time has begun already."""
    found = read_when(text, now_ns, local_at)
    assert isinstance(found, RequestedTime), found
    now, start = local_at(now_ns), found.start
    return (start.day_number, start.minute_of_day) < (now.day_number, now.minute_of_day)


def misunderstood(text: str) -> Misunderstood:
    found = read(text)
    assert isinstance(found, Misunderstood), found
    return found


@pytest.mark.parametrize(
    ("text", "start", "length_s"),
    [
        ("tomorrow 14:00 1h", "2026-11-22 14:00", 3600),
        ("today 9-10", "2026-11-21 09:00", 3600),
        ("mon 14:00 90min", "2026-11-23 14:00", 5400),
        ("2026-11-24 14:00 1 h 30 min", "2026-11-24 14:00", 5400),
        ("24.11. 14:00 2h", "2026-11-24 14:00", 7200),
        ("24.11.2026 14:00 2h", "2026-11-24 14:00", 7200),
        ("24.11.26 14:00 2h", "2026-11-24 14:00", 7200),
        ("24 Nov 14:00 2h", "2026-11-24 14:00", 7200),
        ("Nov 24 2pm 2 hours", "2026-11-24 14:00", 7200),
        ("24. november 2027 at 14:00 for 2h", "2027-11-24 14:00", 7200),
        ("now 30m", "2026-11-21 10:30", 1800),
        ("in 20 min 1h", "2026-11-21 10:50", 3600),
        ("in 1 h for 30 min", "2026-11-21 11:30", 1800),
        ("in 1h 30min 2h", "2026-11-21 12:00", 7200),
        ("now until 16:00", "2026-11-21 10:30", 19_800),
        ("14:00 1h", "2026-11-21 14:00", 3600),
        ("9:00 1h", "2026-11-22 09:00", 3600),
        ("Saturday 10:29 1h", "2026-11-28 10:29", 3600),
        ("Saturday 10:30 1h", "2026-11-21 10:30", 3600),
        ("fridays 9 1h", "2026-11-27 09:00", 3600),
        ("Tue 24 Nov 14:00 1h", "2026-11-24 14:00", 3600),
        ("tomorrow 2pm 1h", "2026-11-22 14:00", 3600),
        ("tomorrow 2 p.m. 1h", "2026-11-22 14:00", 3600),
        ("tomorrow 12 am 1h", "2026-11-22 00:00", 3600),
        ("tomorrow 12pm 1h", "2026-11-22 12:00", 3600),
        ("tomorrow noon 1h", "2026-11-22 12:00", 3600),
        ("9-10pm", "2026-11-21 21:00", 3600),
        ("11-1pm", "2026-11-21 11:00", 7200),
        ("11 am - 1 pm", "2026-11-21 11:00", 7200),
        ("2pm-4", "2026-11-21 14:00", 7200),
        ("tomorrow from 9:00 to 10:30", "2026-11-22 09:00", 5400),
        ("9:00–10:30 tomorrow", "2026-11-22 09:00", 5400),
        ("22-2", "2026-11-21 22:00", 14_400),
        ("tomorrow 20-24", "2026-11-22 20:00", 14_400),
        ("tomorrow 24:00 1h", "2026-11-23 00:00", 3600),
        ("tomorrow 9 1h30", "2026-11-22 09:00", 5400),
        ("tomorrow 9 1,5 h", "2026-11-22 09:00", 5400),
        ("tomorrow 9 ½h", "2026-11-22 09:00", 1800),
        ("half an hour tomorrow at 9", "2026-11-22 09:00", 1800),
        ("an hour tomorrow at 9", "2026-11-22 09:00", 3600),
        ("tomorrow 9 1/2 h", "2026-11-22 09:00", 1800),
        ("ｔｏｍｏｒｒｏｗ １４:００ 1h", "2026-11-22 14:00", 3600),
        ("29.2. 9:00 1h", "2028-02-29 09:00", 3600),
        ("1.1. 9:00 1h", "2027-01-01 09:00", 3600),
        ("21.11. 9:00 1h", "2026-11-21 09:00", 3600),
        ("tomorrow 14:00 0h", "2026-11-22 14:00", 0),
        ("tomorrow 14:00 30 s", "2026-11-22 14:00", 30),
        ("tomorrow 14:00 400 days", "2026-11-22 14:00", 400 * 86_400),
    ],
)
def test_what_people_type(text: str, start: str, length_s: int) -> None:
    found = understood(text)
    assert f"{found.start.date_text()} {found.start.time_text()}" == start
    assert (found.length_s, found.rrule) == (length_s, "")


@pytest.mark.parametrize(
    ("text", "first", "rrule"),
    [
        (
            "every tue 14:00 1h until 2027-02-01",
            "2026-11-24 14:00",
            "FREQ=WEEKLY;BYDAY=TU;UNTIL=20270201T235959",
        ),
        ("weekdays 9:00 30min", "2026-11-23 09:00", "FREQ=WEEKLY;BYDAY=MO,TU,WE,TH,FR"),
        ("every weekday 9 1h 5x", "2026-11-23 09:00", "FREQ=WEEKLY;BYDAY=MO,TU,WE,TH,FR;COUNT=5"),
        (
            "every thu, tue and sat 9:00 1h 10 times",
            "2026-11-24 09:00",
            "FREQ=WEEKLY;BYDAY=TU,TH,SA;COUNT=10",
        ),
        (
            "every other wed 9-11 3 times",
            "2026-11-25 09:00",
            "FREQ=WEEKLY;INTERVAL=2;BYDAY=WE;COUNT=3",
        ),
        ("daily 7:30 45m until 24 dec", "2026-11-22 07:30", "FREQ=DAILY;UNTIL=20261224T235959"),
        ("every day 14:00 until 1 dec 1h", "2026-11-21 14:00", "FREQ=DAILY;UNTIL=20261201T235959"),
        ("tomorrow 14:00 1h FREQ=weekly;COUNT=3", "2026-11-22 14:00", "FREQ=WEEKLY;COUNT=3"),
        ("tomorrow 14:00 1h RRULE:FREQ=DAILY", "2026-11-22 14:00", "FREQ=DAILY"),
    ],
)
def test_what_comes_again(text: str, first: str, rrule: str) -> None:
    found = understood(text)
    assert f"{found.start.date_text()} {found.start.time_text()}" == first
    assert found.rrule == rrule


def test_now_is_a_moment_and_the_rest_a_clock_on_a_wall() -> None:
    now, later, tomorrow = understood("now 1h"), understood("in 20 min 1h"), understood("14:00 1h")
    assert now.start_ns == NOW_NS // MINUTE_NS * MINUTE_NS
    assert later.start_ns == now.start_ns + 20 * MINUTE_NS
    assert tomorrow.start_ns is None


def test_an_end_that_was_said_is_kept() -> None:
    assert understood("tomorrow 22-2").ends == LocalTime(2026, 11, 23, 2)
    assert understood("tomorrow 22:00 4h").ends is None


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "When"),
        ("soon", '"soon"'),
        ("tomorrow", "At what time?"),
        ("1h", "At what time?"),
        ("tomorrow 14:00", "For how long?"),
        ("now", "For how long?"),
        ("in", "In how long?"),
        ("in 1h 30min", "for how long?"),
        ("every", "Every which day?"),
        ("every month 9:00 1h", "Every which day?"),
        ("tomorrow 25:00 1h", "on a clock"),
        ("tomorrow 9:75 1h", "on a clock"),
        ("tomorrow 13 pm 1h", 'There is no "13 pm" on a clock.'),
        ("tomorrow 13pm 1h", 'There is no "13pm" on a clock.'),
        ("30.2.2027 9:00 1h", "Feb 2027 has no day 30"),
        ("2027-13-01 9:00 1h", "no such month"),
        ("2300-01-01 9:00 1h", "no such month"),
        ("11/24 9:00 1h", "one day here and another there"),
        ("14:00 -1h", "shorter than nothing"),
        ("tomorrow 14:00 1,500 h", "no length"),
        ("tomorrow 14:00 1e999 h", "no length"),
        ("9-9", "ends as it begins"),
        ("9-10 1h", "One of them is enough"),
        ("today tomorrow 9-10", "two times at once"),
        ("mon tue 9-10", "two times at once"),
        ("today mon 9-10", "two days at once"),
        ("Wed 24 Nov 9-10", "another day of the week"),
        ("now 9:00 1h", "two times at once"),
        ("now tomorrow 1h", "two times at once"),
        ("in 10000 h 1h", "a year"),
        ("31 feb 14:00 1h", "Feb 2027 has no day 31"),
        ("31 nov 14:00 1h", "Nov 2026 has no day 31"),
        ("31.2.2020 14:00 1h", "Feb 2020 has no day 31"),
        ("32.13. 9:00 1h", "no such month"),
        ("tomorrow 14:00 1h RRULE:", "A rule says how often."),
        ("today 1h", "At what time?"),
        ("yesterday 1h", "At what time?"),
        ("every tue 1h 3 times", "At what time?"),
        ("tomorrow 14:00 1h Europe/Berlin", 'leave "europe/berlin" out. /settings zone'),
        ("tomorrow 14:00 UTC 1h", 'leave "utc" out. /settings zone'),
        ("tomorrow 14:00 CEST 1h", 'leave "cest" out. /settings zone'),
        ("every mon 14:00 1h until whenever", '"whenever"'),
        ("tomorrow until", '"until"'),
        ("tomorrow 9:00 1h until 2027-02-01", "Every which day"),
        ("tomorrow 9:00 1h 5 times", "Every which day"),
        ("every tue 9:00 1h until 2026-11-01", "over before it begins"),
        ("every tue 9:00 1h 0 times", "At least once"),
        ("every tue 9:00 1h 5 times until 2027-02-01", "One is enough"),
        ("daily 9:00 1h FREQ=DAILY", "twice how often"),
        ("2199-12-31 24:00 1h", "further away than the calendar"),
        ("9-x", "9-x"),
        ("x" * 10_000, "longer than any time"),
    ],
)
def test_what_nobody_can_read_is_said_with_what_can_be(text: str, why: str) -> None:
    found = misunderstood(text)
    assert why in found.sentence
    assert found.offers
    for offer in found.offers:
        assert not over(offer), offer


@pytest.mark.parametrize("minute", [0, 9 * 60, 14 * 60, 23 * 60 + 59])
def test_what_is_offered_is_never_over_whatever_the_hour(minute: int) -> None:
    now_ns = day_number(2026, 11, 21) * DAY_NS + (minute - HOURS_AHEAD * 60) * MINUTE_NS
    for text in ("", "tomorrow", "today", "1h", "mon 2h", "24 Nov", "31 feb 14:00 1h", "yesterday"):
        found = read_when(text, now_ns, local_at)
        assert isinstance(found, Misunderstood)
        assert found.offers, text
        assert not [offer for offer in found.offers if over(offer, now_ns)], text


def test_the_day_that_was_said_is_kept_in_what_is_offered() -> None:
    assert misunderstood("tomorrow").offers == ("2026-11-22 14:00 1h",)
    assert misunderstood("24 Nov 2h").offers == ("2026-11-24 14:00 2 h",)
    assert misunderstood("mon 2h").offers == ("2026-11-23 14:00 2 h",)
    assert misunderstood("1h").offers == ("2026-11-21 14:00 1 h", "2026-11-22 14:00 1 h")


def test_yesterday_is_a_time_that_is_over() -> None:
    assert over("yesterday 14:00 1h")


def test_the_examples_are_understood() -> None:
    for text in EXAMPLES:
        understood(text)


SOUP = """
today tomorrow now in every other each mon tue and , 14:00 9 9-10 9pm - to until till 1h 30 min
90min 1 2 24.11. 2026-11-24 30.2. nov 24 2027 times 5x for at daily weekdays weekday day hour
half an 0h -1h 1e999h 1,500h 11/24 24:00 25:00 pm am noon FREQ=DAILY rrule:freq=weekly ½ 1/0h
² Ⅷ -10 10- -- 9-10-11 9:00-10pm 2199-12-31 0000-00-00 99.99.9999 29.2. st 1st
"""
WORDS = st.sampled_from(SOUP.split())


@settings(max_examples=400)
@given(st.one_of(st.text(max_size=220), st.lists(WORDS, max_size=12).map(" ".join)))
@example("\ud800 tomorrow")
@example("٩-١٠")
@example("1e308 d 1e308 h")
def test_any_text_gives_a_time_or_a_sentence(text: str) -> None:
    found = read(text)
    if isinstance(found, RequestedTime):
        assert found.length_s >= 0
        assert found.ends is None or found.ends > found.start
        if found.start_ns is not None:
            assert local_at(found.start_ns) == found.start
    else:
        assert found.sentence
        assert found.offers
        for offer in found.offers:
            understood(offer)


@settings(max_examples=200)
@given(st.integers(0, 400), st.integers(0, 1439), st.integers(1, 1440))
def test_every_date_time_and_length_is_read_as_it_is_written(
    days: int, minute: int, minutes: int
) -> None:
    start = LocalTime.at(day_number(2026, 11, 21) + days, minute)
    found = understood(f"{start.date_text()} {start.time_text()} {minutes} min")
    assert (found.start, found.length_s) == (start, minutes * 60)
