"""What comes again, and clocks that change."""

from __future__ import annotations

from datetime import datetime, timedelta
from itertools import pairwise
from zoneinfo import ZoneInfo

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosic.core.language.time_parser import RequestedTime, read_when
from rosic.core.local_time import LocalTime
from rosic.core.slot import Pattern
from rosic.errors import NotPermitted, NotUnderstood, OutOfBounds, TooManyRequests
from rosic.organiser.calendar_conflicts import SlotTaken
from rosic.organiser.recurrence import SeriesLimits, occasion, occasions, occurrences, read_rule
from rosic.organiser.timezones import Zone, no_such_zone, zone_named
from tests.organiser.booking import HOUR, NOW, VIENNA, S, a_calendar, booked, write

WALL = ZoneInfo("Europe/Vienna")
LORD_HOWE = zone_named("Australia/Lord_Howe")  # its summer time is half an hour
TUESDAYS = "FREQ=WEEKLY;BYDAY=TU;COUNT=3"


def a_pattern(
    rrule: str = TUESDAYS, first: LocalTime | None = None, *, length_s: int = 3600, zone: str = ""
) -> Pattern:
    return Pattern(first or LocalTime(2026, 11, 24, 14), length_s, rrule, zone or "Europe/Vienna")


def a_when(text: str, zone: Zone = VIENNA, now_ns: int = NOW) -> RequestedTime:
    found = read_when(text, now_ns, zone.local)
    assert isinstance(found, RequestedTime)
    return found


# ---- clocks that change ----


def test_what_the_clocks_skip_is_refused_with_the_reason_and_what_is_possible() -> None:
    with pytest.raises(OutOfBounds) as refused:
        occasion("kuka1", a_when("2027-03-28 02:30 1h"), VIENNA)
    assert str(refused.value) == (
        "On Sun 28 Mar the clocks in Europe/Vienna go forward, and there is no 02:30. "
        "The next possible time is 03:00. Nothing was booked."
    )
    assert refused.value.offers == ("book kuka1 2027-03-28 03:00 1 h",)
    assert (
        occasion(
            "kuka1", a_when(refused.value.offers[0].removeprefix("book kuka1 ")), VIENNA
        ).length_s
        == 3600
    )


@pytest.mark.parametrize(
    ("text", "offer"),
    [
        ("2027-03-28 1:00-2:30", "book kuka1 2027-03-28 01:00 1 h 30 min"),
        ("2027-03-28 2:10-2:40", "book kuka1 2027-03-28 03:00 30 min"),
        ("2027-03-28 2:30-4", "book kuka1 2027-03-28 03:00 1 h 30 min"),
    ],
)
def test_what_is_offered_instead_of_a_skipped_time_is_possible(text: str, offer: str) -> None:
    with pytest.raises(OutOfBounds) as refused:
        occasion("kuka1", a_when(text), VIENNA)
    assert refused.value.offers == (offer,)
    instead = occasion("kuka1", a_when(offer.removeprefix("book kuka1 ")), VIENNA)
    assert instead.note == ""


def test_a_time_that_comes_twice_is_the_first_and_that_is_said() -> None:
    found = occasion("kuka1", a_when("2027-10-31 02:30 1h"), VIENNA)
    first = datetime(2027, 10, 31, 2, 30, tzinfo=WALL, fold=0)
    assert found.start_ns == int(first.timestamp()) * S
    assert "02:30 comes twice. This is the first one." in found.note
    assert occasion("kuka1", a_when("2027-10-31 03:00 1h"), VIENNA).note == ""


def test_an_end_that_was_said_is_an_end_on_the_wall() -> None:
    assert occasion("kuka1", a_when("2027-03-28 1-4"), VIENNA).length_s == 2 * 3600
    assert occasion("kuka1", a_when("2027-10-31 1-4"), VIENNA).length_s == 4 * 3600
    assert occasion("kuka1", a_when("2027-03-28 1:00 3h"), VIENNA).length_s == 3 * 3600


def test_now_in_an_hour_that_comes_twice_is_now() -> None:
    second = int(datetime(2027, 10, 31, 2, 30, tzinfo=WALL, fold=1).timestamp()) * S
    found = occasion("kuka1", a_when("now 30 min", now_ns=second), VIENNA)
    assert (found.start_ns, found.note) == (second, "")


def test_a_change_of_half_an_hour_is_found_to_the_minute() -> None:
    instant = LORD_HOWE.instant(LocalTime(2026, 10, 4, 2, 15))
    assert (instant.kind, instant.possible) == ("never", LocalTime(2026, 10, 4, 2, 30))
    assert LORD_HOWE.local(instant.start_ns) == LocalTime(2026, 10, 4, 2, 45)


@pytest.mark.parametrize("minute", range(0, 180, 7))
def test_every_skipped_minute_leads_to_the_same_next_one(minute: int) -> None:
    instant = VIENNA.instant(LocalTime(2027, 3, 28, 1).later(minute))
    gap = 60 <= minute < 120
    assert instant.kind == ("never" if gap else "once")
    if gap:
        assert instant.possible == LocalTime(2027, 3, 28, 3)


@settings(max_examples=300)
@given(
    st.datetimes(datetime(2026, 1, 1), datetime(2035, 1, 1)),  # noqa: DTZ001
    st.sampled_from(["Europe/Vienna", "Australia/Lord_Howe", "America/New_York", "Asia/Kolkata"]),
)
def test_the_wall_agrees_with_the_standard_library(wall: datetime, name: str) -> None:
    local = LocalTime(wall.year, wall.month, wall.day, wall.hour, wall.minute)
    instant = zone_named(name).instant(local)
    expected = datetime(*wall.timetuple()[:5], tzinfo=ZoneInfo(name))
    assert instant.start_ns == int(expected.timestamp()) * S
    if instant.kind != "never":
        assert zone_named(name).local(instant.start_ns) == local


# ---- zones ----


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("europe/vienna", "Did you mean Europe/Vienna?"),
        ("Vienna", "Did you mean Europe/Vienna?"),
        ("Europe/Viena", "Did you mean Europe/Vienna?"),
        ("new york", "Did you mean America/New_York?"),
        ("Olympus/Mons", "Write it as Europe/Vienna or UTC."),
        ("../../etc/passwd", "Write it as Europe/Vienna or UTC."),
        ("Europe", "I know no time zone"),
        ("", "Write it as Europe/Vienna or UTC."),
        ("x" * 5000, "Write it as Europe/Vienna or UTC."),
        ("\ud800\0", "Write it as Europe/Vienna or UTC."),
    ],
)
def test_a_zone_that_does_not_exist_is_refused_with_one_that_does(name: str, instead: str) -> None:
    with pytest.raises(OutOfBounds, match="I know no time zone") as refused:
        zone_named(name)
    assert instead in str(refused.value)


def test_a_machine_without_zone_data_says_how_to_get_it_and_still_has_utc() -> None:
    assert "tzdata" in str(no_such_zone("Europe/Vienna", frozenset()))
    assert zone_named("UTC").local(0) == LocalTime(1970, 1, 1)


# ---- rules ----


def test_a_series_keeps_its_place_on_the_wall_over_the_change_of_clocks() -> None:
    pattern = a_pattern("FREQ=WEEKLY;BYDAY=SU;COUNT=4", LocalTime(2027, 3, 14, 14))
    found = occasions(pattern, NOW, SeriesLimits())
    assert [VIENNA.local(one.start_ns).time_text() for one in found] == ["14:00"] * 4
    gaps = [b.start_ns - a.start_ns for a, b in pairwise(found)]
    assert gaps == [168 * HOUR, 167 * HOUR, 168 * HOUR]


def test_an_occurrence_that_the_clocks_skip_comes_as_much_later() -> None:
    pattern = a_pattern("FREQ=DAILY;COUNT=3", LocalTime(2027, 3, 27, 2, 30), length_s=1800)
    found = occasions(pattern, NOW, SeriesLimits())
    assert [one.moved for one in found] == [False, True, False]
    assert [VIENNA.local(one.start_ns).time_text() for one in found] == ["02:30", "03:30", "02:30"]


def test_an_occurrence_that_comes_twice_is_the_first() -> None:
    pattern = a_pattern("FREQ=DAILY;COUNT=2", LocalTime(2027, 10, 30, 2, 30))
    first, second = occasions(pattern, NOW, SeriesLimits())
    assert second.start_ns - first.start_ns == 24 * HOUR


@pytest.mark.parametrize(
    ("rrule", "days"),
    [
        ("RRULE:FREQ=DAILY;UNTIL=20261126", ["11-24", "11-25", "11-26"]),
        ("freq=daily;until=20261126T140000", ["11-24", "11-25", "11-26"]),
        ("FREQ=DAILY;UNTIL=20261126T125900Z", ["11-24", "11-25"]),
        ("FREQ=DAILY;UNTIL=20261126T130000Z", ["11-24", "11-25", "11-26"]),
        ("FREQ=WEEKLY;BYDAY=MO,WE;COUNT=3", ["11-25", "11-30", "12-02"]),
        ("FREQ=WEEKLY;INTERVAL=2;COUNT=3", ["11-24", "12-08", "12-22"]),
        ("FREQ=MONTHLY;BYDAY=-1FR;COUNT=2", ["11-27", "12-25"]),
        ("FREQ=MONTHLY;BYDAY=MO,TU,WE,TH,FR;BYSETPOS=1;COUNT=2", ["12-01", "01-01"]),
        ("FREQ=MONTHLY;BYMONTHDAY=31;COUNT=2", ["12-31", "01-31"]),
        ("FREQ=DAILY;BYMONTH=12;BYMONTHDAY=-1;COUNT=1", ["12-31"]),
    ],
)
def test_rules_come_when_they_say(rrule: str, days: list[str]) -> None:
    found = occasions(a_pattern(rrule), NOW, SeriesLimits())
    assert [one.local.date_text()[5:] for one in found] == days


@pytest.mark.parametrize(
    ("rrule", "why"),
    [
        ("", "I cannot use"),
        ("every tuesday", "I cannot use"),
        ("FREQ=WEEKLY;;COUNT=2", "I cannot use"),
        ("FREQ=HOURLY;COUNT=2", "FREQ=HOURLY"),
        ("FREQ=SECONDLY;COUNT=2", "FREQ=SECONDLY"),
        ("FREQ=YEARLY;COUNT=2", "FREQ=YEARLY"),
        ("FREQ=DAILY;FREQ=DAILY;COUNT=2", "FREQ=DAILY"),
        ("COUNT=2", "how often"),
        ("FREQ=DAILY;BYHOUR=3;COUNT=2", "BYHOUR"),
        ("FREQ=DAILY;COUNT=0", "COUNT=0"),
        ("FREQ=DAILY;COUNT=9999999", "COUNT=9999999"),
        ("FREQ=DAILY;COUNT=two", "COUNT=TWO"),
        ("FREQ=DAILY;INTERVAL=0;COUNT=2", "INTERVAL=0"),
        ("FREQ=DAILY;UNTIL=20270230", "UNTIL=20270230"),
        ("FREQ=DAILY;UNTIL=99999999T999999Z", "UNTIL"),
        ("FREQ=DAILY;UNTIL=20261224;COUNT=3", "not both"),
        ("FREQ=WEEKLY;BYDAY=XX;COUNT=2", "BYDAY=XX"),
        ("FREQ=WEEKLY;BYDAY=1MO;COUNT=2", "FREQ=WEEKLY with BYDAY"),
        ("FREQ=DAILY;INTERVAL=7;BYDAY=WE;COUNT=2", "INTERVAL=7 with BYDAY"),
        ("FREQ=MONTHLY;INTERVAL=12;BYMONTHDAY=31;COUNT=2", "INTERVAL=12"),
        ("FREQ=DAILY;BYSETPOS=2;COUNT=2", "BYSETPOS"),
        ("FREQ=MONTHLY;BYSETPOS=2;COUNT=2", "BYSETPOS"),
        ("FREQ=MONTHLY;BYMONTHDAY=32;COUNT=2", "BYMONTHDAY=32"),
        ("FREQ=DAILY;BYDAY=" + "MO," * 200, "over 256"),
        ("FREQ=WEEKLY;BYDAY=TU", "Until when?"),
    ],
)
def test_what_is_no_rule_is_refused_with_the_part_that_is_wrong(rrule: str, why: str) -> None:
    calendar, _ = a_calendar()
    with pytest.raises(NotUnderstood, match=why) as refused:
        calendar.book_series("ann", "kuka1", a_pattern(rrule), "ann")
    assert any(word in str(refused.value) for word in ("Write it as FREQ=", "a last day"))


def test_a_rule_that_never_comes_is_refused_at_once() -> None:
    with pytest.raises(OutOfBounds, match="that many days"):
        occasions(a_pattern("FREQ=DAILY;BYMONTH=2;BYMONTHDAY=30;COUNT=1"), NOW, SeriesLimits())
    with pytest.raises(OutOfBounds, match="never comes"):
        occasions(a_pattern("FREQ=WEEKLY;BYDAY=MO;UNTIL=20261124T235959"), NOW, SeriesLimits())


DAYS = st.sampled_from(["MO", "TU,TH", "SU", "1MO", "5FR", "-5SA", "MO,TU,WE,TH,FR"])
PARTS = st.fixed_dictionaries(
    {"FREQ": st.sampled_from(["DAILY", "WEEKLY", "MONTHLY"])},
    optional={
        "INTERVAL": st.integers(1, 400),
        "BYDAY": DAYS,
        "BYMONTHDAY": st.sampled_from(["31", "30", "-31", "1,15", "29"]),
        "BYMONTH": st.sampled_from(["2", "4", "2,4", "12"]),
        "BYSETPOS": st.sampled_from(["1", "-1", "4"]),
        "WKST": st.sampled_from(["MO", "SU"]),
    },
)


@settings(max_examples=150, deadline=2000)
@given(PARTS, st.integers(0, 400))
def test_every_rule_that_is_taken_is_worked_out_soon(parts: dict[str, object], days: int) -> None:
    """The deadline is the point: dateutil looks for a match until the year 9999."""
    first = LocalTime(2026, 11, 24, 14).later(days * 24 * 60)
    try:
        rule = read_rule(";".join(f"{k}={v}" for k, v in parts.items()), VIENNA)
    except (NotUnderstood, OutOfBounds):
        return
    last = first.later(731 * 24 * 60)
    found = occurrences(rule, first, last, 400)
    assert len(found) <= 401
    assert list(found) == sorted(set(found))
    assert all(first <= one <= last for one in found)


# ---- booking a series ----


def test_a_series_is_booked_as_a_whole() -> None:
    calendar, _ = a_calendar()
    facts = calendar.book_series("ann", "kuka1", a_pattern(), "ben")
    assert [fact.kind for fact in facts] == ["series", "slot", "slot", "slot"]
    assert len(calendar) == 0
    slots = write(calendar, facts)
    series = calendar.series(facts[0].key)
    assert series is not None
    assert (series.pattern, series.by) == (a_pattern(), "ben")
    assert {slot.series for slot in slots} == {series.id}
    assert [VIENNA.local(slot.start_ns).date_text() for slot in slots] == [
        "2026-11-24",
        "2026-12-01",
        "2026-12-08",
    ]
    assert all(slot.end_ns - slot.start_ns == HOUR for slot in slots)


def test_one_occurrence_that_is_taken_refuses_all_or_is_left_out() -> None:
    calendar, _ = a_calendar()
    other = booked(calendar, VIENNA.instant(LocalTime(2026, 12, 1, 14, 30)).start_ns, who="ben")
    with pytest.raises(SlotTaken) as refused:
        calendar.book_series("ann", "kuka1", a_pattern(), "ann")
    assert str(refused.value) == (
        "One of these times is taken: KUKA iiwa is Ben's at Tue 1 Dec 14:30. Nothing was booked."
    )
    assert refused.value.slot == other
    slots = write(
        calendar, calendar.book_series("ann", "kuka1", a_pattern(), "ann", skip_taken=True)
    )
    assert len(slots) == 2
    with pytest.raises(SlotTaken, match="3 of these 3 times are taken"):
        calendar.book_series("ann", "kuka1", a_pattern(), "ann", skip_taken=True)


@pytest.mark.parametrize(
    ("pattern", "why"),
    [
        (a_pattern("FREQ=DAILY;COUNT=401"), "more than 400 times"),
        (a_pattern("FREQ=DAILY;UNTIL=20280401"), "more than 400 times"),
        (a_pattern("FREQ=WEEKLY;UNTIL=20300101"), "can be booked until Tue 21 Nov 2028"),
        (a_pattern("FREQ=WEEKLY;COUNT=200"), "can be booked until Tue 21 Nov 2028"),
        (a_pattern(first=LocalTime(2026, 11, 17, 14)), "That time is over"),
        (a_pattern(first=LocalTime(2199, 12, 1, 14)), "can be booked until"),
        (a_pattern(length_s=0), "longer than nothing"),
        (a_pattern(length_s=90_000), "at most 1 day"),
        (a_pattern(zone="Europe/Viena"), "Did you mean Europe/Vienna?"),
        (
            a_pattern("FREQ=DAILY;COUNT=3", LocalTime(2027, 3, 27, 14), length_s=86_400),
            "overlap each other",
        ),
    ],
)
def test_what_is_no_series_is_refused(pattern: Pattern, why: str) -> None:
    calendar, _ = a_calendar()
    with pytest.raises(OutOfBounds, match=why.replace("?", r"\?")):
        calendar.book_series("ann", "kuka1", pattern, "ann")
    assert len(calendar) == 0


def test_four_hundred_times_are_possible_and_a_share_is_a_share() -> None:
    calendar, _ = a_calendar()
    write(calendar, calendar.book_series("ann", "kuka1", a_pattern("FREQ=DAILY;COUNT=400"), "ann"))
    assert len(calendar) == 400
    with pytest.raises(TooManyRequests, match="may have 500 times booked"):
        calendar.book_series("ann", "omni", a_pattern("FREQ=DAILY;COUNT=101"), "ann")


def test_a_rule_without_an_end_offers_one() -> None:
    calendar, _ = a_calendar()
    when = a_when("every tue and thu 14:00 90 min")
    pattern = Pattern(when.start, when.length_s, when.rrule, "Europe/Vienna")
    with pytest.raises(NotUnderstood, match=r"Until when\?") as refused:
        calendar.book_series("ann", "kuka1", pattern, "ann")
    (offer,) = refused.value.offers
    assert offer == "book kuka1 every Tue and Thu 14:00 1 h 30 min until 2027-02-16"
    assert a_when(offer.removeprefix("book kuka1 ")).rrule.endswith("UNTIL=20270216T235959")


def test_one_occurrence_or_the_rest_is_given_back() -> None:
    calendar, clock = a_calendar()
    facts = calendar.book_series("ann", "kuka1", a_pattern(), "ann")
    first, second, third = write(calendar, facts)
    write(calendar, calendar.cancel(second.id, "ann"))
    assert calendar.of("ann") == (first, third)
    clock.jump_wall((first.start_ns - NOW) / S + 600)
    with pytest.raises(NotPermitted):
        calendar.cancel_series(first.series, "ben")
    write(calendar, calendar.cancel_series(first.series, "ann"))
    (left,) = calendar.of("ann")
    assert (left.id, left.end_ns) == (first.id, clock.wall_ns())
    with pytest.raises(NotUnderstood, match="no such time"):
        calendar.cancel_series(first.series, "ann")


def test_a_series_is_forgotten_with_its_last_slot() -> None:
    calendar, _ = a_calendar()
    slots = write(calendar, calendar.book_series("ann", "kuka1", a_pattern(), "ann"))
    key = slots[0].series
    write(calendar, calendar.outdated(slots[1].end_ns + 1))
    assert (len(calendar), calendar.series(key) is None) == (1, False)
    write(calendar, calendar.outdated(slots[2].end_ns + 1))
    assert (len(calendar), calendar.series(key)) == (0, None)
    assert calendar.outdated(2 * NOW) == ()


@settings(max_examples=60)
@given(st.integers(0, 700), st.integers(0, 1439), st.integers(1, 30))
def test_daily_slots_are_where_a_naive_count_has_them(days: int, minute: int, count: int) -> None:
    first = LocalTime(2026, 11, 22, 0, 0).later(days * 24 * 60 + minute)
    pattern = a_pattern(f"FREQ=DAILY;COUNT={count}", first, length_s=60)
    found = occasions(pattern, NOW, SeriesLimits(ahead_s=800 * 86_400))
    start = datetime(first.year, first.month, first.day, first.hour, first.minute)  # noqa: DTZ001
    naive = [(start + timedelta(days=n)).replace(tzinfo=WALL) for n in range(count)]
    assert [one.start_ns for one in found] == [int(day.timestamp()) * S for day in naive]
