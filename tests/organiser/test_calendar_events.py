"""Starts, warnings and ends: each once, whatever the clock does."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from hypothesis import example, given, settings
from hypothesis import strategies as st

from rosic.organiser.calendar import Calendar
from rosic.testing.clock import ManualClock
from tests.organiser.booking import HOUR, MIN, NOW, UNNAMED, S, a_calendar, booked, write

if TYPE_CHECKING:
    from rosic.core.slot import BookedSlot
    from rosic.organiser.calendar_events import CalendarEvent


ALL = [("start", 3600), ("warning", 300), ("warning", 60), ("end", 0)]


def told(events: tuple[CalendarEvent, ...]) -> list[tuple[str, int]]:
    return [(event.kind, event.left_s) for event in events]


def test_a_slot_rings_four_times() -> None:
    calendar, _ = a_calendar()
    slot = booked(calendar, NOW + HOUR)
    rung = []
    while (at_ns := calendar.next_event_ns()) is not None:
        assert calendar.due(at_ns - 1) == ()
        (event,) = calendar.due(at_ns)
        assert event.slot == slot
        assert not event.overtaken
        rung.append((event.kind, event.left_s, (event.at_ns - NOW) // MIN))
    assert rung == [
        ("start", 3600, 60),
        ("warning", 300, 115),
        ("warning", 60, 119),
        ("end", 0, 120),
    ]


def test_a_short_slot_has_no_warning_before_its_start() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW + HOUR, 300)
    assert told(calendar.due(NOW + 2 * HOUR)) == [("start", 300), ("warning", 60), ("end", 0)]


def test_a_slot_from_now_on_starts_although_now_is_just_over() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW - 30 * S)
    assert told(calendar.due(NOW)) == [("start", 3600)]


def test_one_persons_end_comes_before_the_next_ones_start() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW + HOUR, who="ben")
    booked(calendar, NOW, who="ann")
    calendar.due(NOW + HOUR - 1)
    events = calendar.due(NOW + HOUR)
    assert [(event.kind, event.slot.principal) for event in events] == [
        ("end", "ann"),
        ("start", "ben"),
    ]


def test_after_a_pause_all_of_it_comes_in_order_and_only_the_last_is_not_overtaken() -> None:
    calendar, _ = a_calendar()
    booked(calendar, NOW)
    events = calendar.due(NOW + 3 * HOUR)
    assert told(events) == ALL
    assert [event.overtaken for event in events] == [True, True, True, False]
    assert calendar.due(NOW + 4 * HOUR) == ()


def test_a_clock_set_back_repeats_nothing_and_loses_nothing() -> None:
    calendar, clock = a_calendar()
    booked(calendar, NOW)
    calendar.due(NOW + 2 * HOUR)
    clock.jump_wall(-86_400)
    assert calendar.due(NOW - 24 * HOUR) == ()
    booked(calendar, NOW - 20 * HOUR)
    assert told(calendar.due(NOW)) == ALL
    assert calendar.due(NOW + 2 * HOUR) == ()


def test_after_a_restart_the_past_is_not_told_again() -> None:
    calendar, clock = a_calendar()
    slots = [booked(calendar, NOW), booked(calendar, NOW + HOUR)]
    clock.jump_wall(56 * 60)
    again = Calendar(clock, UNNAMED)
    again.restore(slot.fact() for slot in slots)
    assert again.due(NOW + 56 * MIN) == ()
    assert told(again.due(NOW + HOUR)) == [("warning", 60), ("end", 0), ("start", 3600)]


def test_a_slot_that_is_cut_short_ends_once_and_now() -> None:
    calendar, clock = a_calendar()
    slot = booked(calendar, NOW)
    calendar.due(NOW)
    clock.jump_wall(600)
    write(calendar, calendar.cancel(slot.id, "ann"))
    assert calendar.next_event_ns() == NOW + 600 * S
    assert told(calendar.due(NOW + 600 * S)) == [("end", 0)]
    assert calendar.due(NOW + 2 * HOUR) == ()


def test_a_slot_to_come_that_is_cancelled_does_not_ring() -> None:
    calendar, _ = a_calendar()
    slot = booked(calendar, NOW + HOUR)
    write(calendar, calendar.cancel(slot.id, "ann"))
    assert calendar.next_event_ns() is None
    assert calendar.due(NOW + 9 * HOUR) == ()


def test_a_slot_that_vanishes_while_it_is_under_way_ends() -> None:
    calendar, clock = a_calendar()
    slot = booked(calendar, NOW)
    calendar.due(NOW)
    clock.jump_wall(600)
    calendar.apply(slot.no_more())
    assert told(calendar.due(NOW + 600 * S)) == [("end", 0)]
    assert calendar.due(NOW + 2 * HOUR) == ()


def test_booking_and_cancelling_for_ever_leaves_nothing_behind() -> None:
    calendar, _ = a_calendar()
    for _ in range(4000):
        slot = booked(calendar, NOW + HOUR)
        write(calendar, calendar.cancel(slot.id, "ann"))
    assert len(calendar._bells._heap) < 2000
    assert calendar.next_event_ns() is None


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("book"), st.integers(0, 40)),
        st.tuples(st.just("cancel"), st.integers(0, 5)),
        st.tuples(st.just("wait"), st.integers(0, 120)),
        st.tuples(st.just("jump"), st.integers(-90, 90)),
    ),
    max_size=30,
)


class Slot:
    """A calendar that is lived with, and every event it has told."""

    def __init__(self) -> None:
        self.calendar, self.clock = a_calendar()
        self.ever: dict[str, BookedSlot] = {}
        self.counts: Counter[tuple[str, str, int]] = Counter()

    def listen(self) -> None:
        for event in self.calendar.due(self.clock.wall_ns()):
            self.counts[
                event.slot.id, event.kind, event.left_s if event.kind == "warning" else 0
            ] += 1

    def step(self, what: str, number: int) -> None:
        now_ns = self.clock.wall_ns()
        if what == "book":
            span = (now_ns + number * 5 * MIN, now_ns + (number * 5 + 20) * MIN)
            if not self.calendar.on("kuka1", *span):
                slot = booked(self.calendar, span[0], 1200)
                self.ever[slot.id] = slot
        elif what == "cancel":
            mine = [slot for slot in self.calendar.of("ann") if slot.end_ns > now_ns]
            if number < len(mine):
                write(self.calendar, self.calendar.cancel(mine[number].id, "ann"))
        else:
            self.clock.jump_wall(number * 60)
        if what != "jump":
            self.listen()


@settings(max_examples=150, deadline=None)
@given(STEPS)
@example([("book", 0), ("cancel", 0), ("book", 0)])
@example([("book", 0), ("wait", 2), ("cancel", 0), ("jump", -1), ("cancel", 0)])
def test_whatever_happens_each_is_told_once(steps: list[tuple[str, int]]) -> None:
    life = Slot()
    for what, number in steps:
        life.step(what, number)
    life.clock.jump_wall(30 * 86_400)
    life.listen()
    assert max(life.counts.values(), default=1) == 1
    for slot_id in life.ever:
        starts, ends = (life.counts[slot_id, kind, 0] for kind in ("start", "end"))
        assert starts == ends  # whoever began has ended
        slot = life.calendar.slot(slot_id)
        if slot is not None:
            assert starts == 1
            if slot == life.ever[slot_id]:  # not cut short
                assert [life.counts[slot_id, "warning", left] for left in (300, 60)] == [1, 1]


def test_nobody_listens_to_a_manual_clock_by_itself() -> None:
    """The calendar sets no timer: `next_event_ns` is for the caller's."""
    clock = ManualClock(NOW)
    calendar = Calendar(clock, UNNAMED)
    assert calendar.next_event_ns() is None
    booked(calendar, NOW + HOUR)
    assert calendar.next_event_ns() == NOW + HOUR
