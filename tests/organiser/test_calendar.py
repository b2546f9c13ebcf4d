"""Booking, refusing, cancelling, asking: with a clock that stands at 10:00 on 21 November 2026."""

from __future__ import annotations

import pytest

from rosic.core.language.time_parser import RequestedTime, read_when
from rosic.core.records import Fact
from rosic.core.slot import SLOT
from rosic.errors import (
    Expired,
    NotPermitted,
    NotUnderstood,
    OutOfBounds,
    RobotTaken,
    TooManyRequests,
)
from rosic.organiser.calendar import Calendar
from rosic.organiser.calendar_conflicts import OutsideSlot, SlotTaken
from rosic.organiser.recurrence import SeriesLimits, occasion
from tests.organiser.booking import HOUR, MIN, NOW, UNNAMED, VIENNA, S, a_calendar, booked, write

# ---- booking ----


def test_deciding_changes_nothing_until_it_is_written_down() -> None:
    calendar, _ = a_calendar()
    facts = calendar.book("ann", "kuka1", NOW + HOUR, 3600, "ann")
    assert (len(calendar), calendar.of("ann")) == (0, ())
    (slot,) = write(calendar, facts)
    assert calendar.of("ann") == (slot,)
    assert (slot.start_ns, slot.end_ns) == (NOW + HOUR, NOW + 2 * HOUR)
    assert (slot.made_ns, slot.by, slot.series) == (NOW, "ann", "")


def test_an_overlap_is_refused_with_who_when_and_the_next_free_time() -> None:
    calendar, _ = a_calendar()
    slot = booked(calendar, NOW + 4 * HOUR)
    booked(calendar, NOW + 5 * HOUR, who="cem")
    with pytest.raises(SlotTaken) as refused:
        calendar.book("ben", "kuka1", NOW + 4 * HOUR + 30 * MIN, 3600, "ben")
    assert str(refused.value) == (
        "KUKA iiwa is taken by Ann from 14:00 to 15:00. It is free from 16:00 on."
    )
    assert refused.value.offers == ("book kuka1 2026-11-21 16:00 1 h",)
    assert (refused.value.holder, refused.value.slot) == ("ann", slot)
    assert (refused.value.until_ns, refused.value.next_free_ns) == (NOW + 5 * HOUR, NOW + 6 * HOUR)
    assert isinstance(refused.value, RobotTaken)


def test_what_is_offered_can_be_booked() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW + 4 * HOUR, 5430)  # ends within a minute
    with pytest.raises(SlotTaken) as refused:
        calendar.book("ben", "kuka1", NOW + 5 * HOUR, 3600, "ben")
    said = refused.value.offers[0].removeprefix("book kuka1 ")
    when = read_when(said, NOW, VIENNA.local)
    assert isinstance(when, RequestedTime)
    found = occasion("kuka1", when, VIENNA)
    assert calendar.book("ben", "kuka1", found.start_ns, found.length_s, "ben")


def test_ones_own_overlap_is_called_ones_own() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW + 4 * HOUR)
    with pytest.raises(SlotTaken, match="KUKA iiwa is yours already from 14:00 to 15:00"):
        calendar.book("ann", "kuka1", NOW + 4 * HOUR, 3600, "ann")


def test_slots_may_touch_and_other_robots_do_not_matter() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW + HOUR)
    booked(calendar, NOW + 2 * HOUR, who="ben")
    booked(calendar, NOW, who="cem")
    booked(calendar, NOW + HOUR, who="cem", robot="omni")
    assert [slot.principal for slot in calendar.on("kuka1", NOW, NOW + 9 * HOUR)] == [
        "cem",
        "ann",
        "ben",
    ]


@pytest.mark.parametrize(
    ("start_ns", "length_s", "why"),
    [
        (NOW + HOUR, 0, "longer than nothing"),
        (NOW + HOUR, -3600, "longer than nothing"),
        (NOW + HOUR, 59, "The shortest time is 1 min"),
        (NOW + HOUR, 86_401, "at most 1 day"),
        (NOW + HOUR, 365 * 86_400, "at most 1 day"),
        (NOW + HOUR, 10**30, "at most 1 day"),
        (NOW - 121 * S, 3600, "would have begun at 09:57, and it is 10:00"),
        (NOW - 86_400 * S, 3600, "would have begun at Fri 20 Nov 10:00"),
        (-(10**30), 3600, "That time is over"),
        (NOW + 732 * 86_400 * S, 3600, "Times can be booked until Tue 21 Nov 2028"),
        (10**30, 3600, "Times can be booked until"),
    ],
)
def test_what_is_no_time_is_refused_with_the_reason(start_ns: int, length_s: int, why: str) -> None:
    calendar, _ = a_calendar()
    with pytest.raises(OutOfBounds, match=why) as refused:
        calendar.book("ann", "kuka1", start_ns, length_s, "ann")
    assert "Nothing was booked." in str(refused.value)
    assert len(calendar) == 0


def test_the_limits_themselves_are_possible() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW - 120 * S, 60)
    booked(calendar, NOW + HOUR, 86_400)
    booked(calendar, NOW + 731 * 86_400 * S, 60)


def test_one_person_has_a_share_of_what_is_to_come() -> None:
    calendar, clock = a_calendar(limits=SeriesLimits(most_upcoming=2))
    booked(calendar, NOW)
    booked(calendar, NOW + HOUR)
    with pytest.raises(TooManyRequests, match="may have 2 times booked") as refused:
        calendar.book("ann", "kuka1", NOW + 2 * HOUR, 3600, "ben")
    assert refused.value.retry_after_s == 3600
    assert calendar.book("ben", "kuka1", NOW + 2 * HOUR, 3600, "ben")
    clock.jump_wall(3600)
    assert calendar.book("ann", "kuka1", NOW + 2 * HOUR, 3600, "ann")


def test_the_calendar_itself_is_bounded() -> None:
    calendar, _ = a_calendar(limits=SeriesLimits(most_in_all=1))
    booked(calendar, NOW)
    with pytest.raises(TooManyRequests, match="calendar is full"):
        calendar.book("ben", "kuka1", NOW + 2 * HOUR, 3600, "ben")


def test_limits_that_contradict_each_other_are_no_limits() -> None:
    for wrong in (
        {"shortest_s": 0},
        {"shortest_s": 90_000},
        {"grace_s": -1},
        {"warnings_s": (0,)},
        {"most_upcoming": 0},
    ):
        with pytest.raises(ValueError, match=r"have to|has to"):
            SeriesLimits(**wrong)


def test_an_unknown_zone_of_a_reader_is_read_as_utc() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW + 4 * HOUR)
    calendar.zone_of = lambda _: "Mars/Crater"
    with pytest.raises(SlotTaken, match="from 13:00 to 14:00"):
        calendar.book("ben", "kuka1", NOW + 4 * HOUR, 3600, "ben")


# ---- cancelling ----


def test_a_slot_to_come_is_given_back_and_free() -> None:
    calendar, _ = a_calendar()
    slot = booked(calendar, NOW + HOUR)
    assert write(calendar, calendar.cancel(slot.id, "ann")) == ()
    assert len(calendar) == 0
    assert calendar.of("ann") == ()
    booked(calendar, NOW + HOUR, who="ben")


def test_a_slot_under_way_ends_now_and_what_was_used_stays_said() -> None:
    calendar, clock = a_calendar()
    slot = booked(calendar, NOW)
    clock.jump_wall(600)
    (cut,) = write(calendar, calendar.cancel(slot.id, "ann"))
    assert (cut.id, cut.start_ns, cut.end_ns) == (slot.id, NOW, NOW + 600 * S)
    assert calendar.present("kuka1", NOW + 600 * S) is None
    booked(calendar, NOW + 600 * S, who="ben")
    with pytest.raises(Expired, match="over already"):
        calendar.cancel(slot.id, "ann")


def test_nobody_cancels_what_is_not_theirs_unless_they_may() -> None:
    calendar, _ = a_calendar()
    slot = booked(calendar, NOW + HOUR)
    with pytest.raises(NotPermitted, match="with KUKA iiwa is Ann's"):
        calendar.cancel(slot.id, "ben")
    assert write(calendar, calendar.cancel(slot.id, "ben", anybodys=True)) == ()
    with pytest.raises(NotUnderstood, match="no such time"):
        calendar.cancel(slot.id, "ann")


def test_everything_of_somebody_who_leaves_ends() -> None:
    calendar, clock = a_calendar()
    booked(calendar, NOW)
    booked(calendar, NOW + 2 * HOUR, robot="omni")
    other = booked(calendar, NOW + 2 * HOUR, who="ben")
    clock.jump_wall(60)
    write(calendar, calendar.end_all("ann"))
    assert [slot.end_ns for slot in calendar.of("ann")] == [NOW + 60 * S]
    assert calendar.of("ben") == (other,)


def test_the_past_is_forgotten_some_at_a_time() -> None:
    calendar, _ = a_calendar()
    slots = [booked(calendar, NOW + n * HOUR) for n in range(4)]
    write(calendar, calendar.outdated(NOW + 3 * HOUR, most=1))
    assert len(calendar) == 3
    write(calendar, calendar.outdated(NOW + 3 * HOUR + 1))
    assert calendar.of("ann") == (slots[3],)


# ---- who has it now ----


def test_the_present_slot_is_found_from_its_start_to_its_end() -> None:
    calendar, _ = a_calendar()
    slot = booked(calendar, NOW + HOUR)
    asked = (NOW, NOW + HOUR - 1, NOW + HOUR, NOW + 2 * HOUR - 1, NOW + 2 * HOUR, NOW + HOUR)
    assert [calendar.present("kuka1", at) for at in asked] == [None, None, slot, slot, None, slot]
    assert calendar.present("omni", NOW + HOUR) is None
    assert calendar.holds("ann", "kuka1", NOW + HOUR)
    assert not calendar.holds("ben", "kuka1", NOW + HOUR)
    assert calendar.next_of("kuka1", NOW) == slot
    assert calendar.next_of("kuka1", NOW + HOUR) is None


def test_somebody_elses_slot_keeps_others_out_and_free_time_is_everybodys() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW)
    conflict = calendar.why_not("ben", "kuka1", NOW + MIN, required=False)
    assert conflict is not None
    assert (conflict.holder, conflict.until_ns) == ("ann", NOW + HOUR)
    assert conflict.free_ns == NOW + HOUR
    refusal = calendar.refusal(conflict, "ben")
    assert isinstance(refusal, SlotTaken)
    assert str(refusal) == "KUKA iiwa is taken by Ann until 11:00. You can have it then."
    assert refusal.offers == ("book kuka1 2026-11-21 11:00 15 min", "wait kuka1")
    assert calendar.why_not("ann", "kuka1", NOW + MIN, required=False) is None
    assert calendar.why_not("ben", "kuka1", NOW + HOUR, required=False) is None
    assert calendar.why_not("ben", "omni", NOW, required=False) is None


def test_ones_own_coming_slot_counts_as_the_next_free_time() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW)
    booked(calendar, NOW + HOUR, who="ben")
    conflict = calendar.why_not("ben", "kuka1", NOW, required=False)
    assert conflict is not None
    assert conflict.free_ns == NOW + HOUR
    assert calendar.refusal(conflict, "ben").offers == ()
    other = calendar.why_not("cem", "kuka1", NOW, required=False)
    assert other is not None
    assert other.free_ns == NOW + 2 * HOUR
    assert "until 11:00. You can have it at 12:00." in str(calendar.refusal(other, "cem"))


def test_where_a_slot_is_required_free_time_is_nobodys() -> None:
    calendar, _ = a_calendar()
    conflict = calendar.why_not("ben", "kuka1", NOW, required=True)
    assert conflict is not None
    refusal = calendar.refusal(conflict, "ben")
    assert isinstance(refusal, OutsideSlot)
    assert str(refusal) == "KUKA iiwa has to be booked first. It is free now. Nothing was done."
    assert refusal.offers == ("book kuka1 now 15 min",)
    assert refusal.next_free_ns == NOW
    booked(calendar, NOW + 10 * MIN, who="ann")
    later = calendar.why_not("ben", "kuka1", NOW, required=True)
    assert later is not None
    assert "It is free from 11:10 on." in str(calendar.refusal(later, "ben"))  # not 10 min now
    own = calendar.why_not("ann", "kuka1", NOW, required=True)
    assert own is not None
    assert "your time begins at 10:10" in str(calendar.refusal(own, "ann"))
    assert calendar.why_not("ann", "kuka1", NOW + 10 * MIN, required=True) is None


def test_where_a_slot_is_required_somebody_elses_is_named() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW)
    conflict = calendar.why_not("ben", "kuka1", NOW, required=True)
    assert conflict is not None
    assert str(calendar.refusal(conflict, "ben")) == (
        "KUKA iiwa is booked by Ann until 11:00. You can book it from 11:00 on. Nothing was done."
    )
    booked(calendar, NOW + 24 * HOUR, who="ben")
    conflict = calendar.why_not("ben", "kuka1", NOW, required=True)
    assert conflict is not None
    assert "Your time begins at tomorrow 10:00." in str(calendar.refusal(conflict, "ben"))


# ---- restart ----


def test_a_restart_is_a_replay() -> None:
    calendar, clock = a_calendar()
    slots = [booked(calendar, NOW + n * HOUR, who=who) for n, who in ((2, "ann"), (0, "ben"))]
    again = Calendar(clock, UNNAMED)
    again.restore([*(slot.fact() for slot in slots), Fact(kind="grant", key="g", body=b"x")])
    assert again.on("kuka1", 0, NOW * 2) == calendar.on("kuka1", 0, NOW * 2)
    assert again.present("kuka1", NOW) == slots[1]


def test_the_newest_fact_of_a_slot_counts() -> None:
    calendar, clock = a_calendar()
    one, two = booked(calendar, NOW), booked(calendar, NOW + HOUR)
    again = Calendar(clock, UNNAMED)
    again.restore([one.fact(), two.fact(), one.no_more()])
    assert again.of("ann") == (two,)


@pytest.mark.parametrize("body", [b"\xc1", b"\x80"])
def test_what_cannot_be_read_is_left_out_and_the_rest_stands(
    body: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    calendar, clock = a_calendar()
    slot = booked(calendar, NOW)
    again = Calendar(clock, UNNAMED)
    again.restore([Fact(kind=SLOT, key="s9", body=body), slot.fact()])
    assert again.of("ann") == (slot,)
    assert "cannot be read" in caplog.text
    again.apply(Fact(kind=SLOT, key=slot.id, body=body))
    assert again.of("ann") == (slot,)


def test_of_two_facts_that_overlap_one_is_left_out(caplog: pytest.LogCaptureFixture) -> None:
    calendar, _ = a_calendar()
    other, _ = a_calendar()
    one, two = booked(calendar, NOW), booked(other, NOW + 30 * MIN, who="ben")
    calendar.apply(two.fact())
    assert calendar.on("kuka1", NOW, NOW + 2 * HOUR) == (one,)
    assert "overlaps another" in caplog.text


def test_a_fact_under_another_id_is_left_out() -> None:
    calendar, _ = a_calendar()
    other, _ = a_calendar()
    slot = booked(other, NOW)
    calendar.apply(Fact(kind=SLOT, key="s9", body=slot.fact().body))
    assert len(calendar) == 0


def test_a_fact_that_is_applied_twice_is_applied_once() -> None:
    calendar, _ = a_calendar()
    slot = booked(calendar, NOW)
    calendar.apply(slot.fact())
    assert len(calendar) == 1
    assert [event.kind for event in calendar.due(NOW)] == ["start"]
    calendar.apply(slot.no_more())
    calendar.apply(slot.no_more())
    assert [event.kind for event in calendar.due(NOW)] == ["end"]
