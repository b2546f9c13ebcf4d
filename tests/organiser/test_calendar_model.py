"""The calendar against a list that is searched from end to end, whatever happens to both.

The judge is judged too: calendars with one fault each have to be found out.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rosic.core.local_time import LocalTime
from rosic.core.slot import BookedSlot, Pattern
from rosic.errors import Refusal
from rosic.organiser.calendar import Calendar
from rosic.organiser.calendar_conflicts import SlotTaken
from rosic.organiser.calendar_index import Timeline
from rosic.testing.clock import ManualClock
from tests.organiser.booking import MIN, NOW, UNNAMED, VIENNA, S

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from rosic.core.records import Fact
    from rosic.organiser.calendar_conflicts import SlotConflict

ROBOTS = ("kuka1", "omni")
PEOPLE = ("ann", "ben", "cem")
STEP = 10 * MIN

WHO, WHICH = st.sampled_from(PEOPLE), st.sampled_from(ROBOTS)
PLACE = st.integers(0, 24)
OPS = st.lists(
    st.one_of(
        st.tuples(st.just("book"), WHO, WHICH, PLACE, st.integers(1, 6)),
        st.tuples(st.just("series"), WHO, WHICH, PLACE, st.integers(1, 3)),
        st.tuples(st.just("cancel"), st.integers(0, 9)),
        st.tuples(st.just("wait"), st.integers(0, 90)),
        st.tuples(st.just("back"), st.integers(0, 90)),
        st.tuples(st.just("restart")),
    ),
    max_size=25,
)


class Naive:
    """What is so, found by looking at everything."""

    def __init__(self) -> None:
        self.slots: list[BookedSlot] = []

    def of_robot(self, robot: str) -> list[BookedSlot]:
        return [slot for slot in self.slots if slot.robot == robot]

    def overlapping(self, robot: str, start: int, end: int) -> list[BookedSlot]:
        return [s for s in self.of_robot(robot) if s.start_ns < end and start < s.end_ns]

    def present(self, robot: str, now: int) -> BookedSlot | None:
        found = [s for s in self.of_robot(robot) if s.start_ns <= now < s.end_ns]
        assert len(found) <= 1
        return found[0] if found else None

    def following(self, robot: str, now: int) -> BookedSlot | None:
        later = [s for s in self.of_robot(robot) if s.start_ns > now]
        return min(later, key=lambda s: s.start_ns, default=None)

    def next_free(self, robot: str, start: int, length: int, principal: str | None) -> int:
        others = [s for s in self.of_robot(robot) if s.principal != principal]
        starts = sorted({start, *(s.end_ns for s in others if s.end_ns > start)})
        return next(
            at
            for at in starts
            if not any(s.start_ns < at + length and at < s.end_ns for s in others)
        )

    def may(self, principal: str, robot: str, now: int, *, required: bool) -> bool:
        slot = self.present(robot, now)
        return slot.principal == principal if slot is not None else not required


class Judge:
    """Does the same to a calendar and to the list, and compares whatever can be asked."""

    def __init__(self, made: Callable[[ManualClock], Calendar]) -> None:
        self.made = made
        self.clock = ManualClock(NOW)
        self.calendar = made(self.clock)
        self.naive = Naive()
        self.disk: dict[tuple[str, str], Fact] = {}

    def run(self, ops: list[tuple[Any, ...]]) -> None:
        for op, *rest in ops:
            getattr(self, op)(*rest)
            self.compare()

    def write(self, facts: tuple[Fact, ...]) -> None:
        for fact in facts:
            self.disk[fact.kind, fact.key] = fact
            self.calendar.apply(fact)

    def book(self, who: str, robot: str, place: int, length: int) -> None:
        start = self.clock.wall_ns() // STEP * STEP + (place + 1) * STEP
        end = start + length * STEP
        taken = self.naive.overlapping(robot, start, end)
        try:
            facts = self.calendar.book(who, robot, start, length * 600, who)
        except SlotTaken as refused:
            self.rightly_refused(refused, taken, length * STEP)
            return
        assert not taken
        self.write(facts)
        found = self.calendar.slot(facts[0].key)
        assert found is not None
        assert (found.principal, found.robot, found.start_ns, found.end_ns) == (
            who,
            robot,
            start,
            end,
        )
        self.naive.slots.append(found)

    def rightly_refused(self, refused: SlotTaken, taken: list[BookedSlot], length: int) -> None:
        assert refused.slot in taken
        assert refused.holder == refused.slot.principal
        robot, free = refused.slot.robot, refused.next_free_ns
        assert not self.naive.overlapping(robot, free, free + length)

    def series(self, who: str, robot: str, place: int, count: int) -> None:
        first = VIENNA.local(self.clock.wall_ns() // STEP * STEP + (place + 1) * STEP)
        pattern = Pattern(first, 1200, f"FREQ=DAILY;COUNT={count}", "Europe/Vienna")
        days = (LocalTime.at(first.day_number + n, first.minute_of_day) for n in range(count))
        starts = [VIENNA.instant(day).start_ns for day in days]
        taken = [self.naive.overlapping(robot, at, at + 1200 * S) for at in starts]
        try:
            facts = self.calendar.book_series(who, robot, pattern, who)
        except SlotTaken:
            assert any(taken)
            return
        assert not any(taken)
        self.write(facts)
        found = [slot for fact in facts if (slot := self.calendar.slot(fact.key)) is not None]
        assert [slot.start_ns for slot in found] == starts
        self.naive.slots.extend(found)

    def cancel(self, place: int) -> None:
        now = self.clock.wall_ns()
        if place >= len(self.naive.slots):
            return
        slot = self.naive.slots[place]
        try:
            facts = self.calendar.cancel(slot.id, slot.principal)
        except Refusal:
            assert slot.end_ns <= now
            return
        assert slot.end_ns > now
        self.write(facts)
        left = self.calendar.slot(slot.id)
        del self.naive.slots[place]
        if now > slot.start_ns:
            assert left is not None
            assert (left.start_ns, left.end_ns) == (slot.start_ns, now)
            self.naive.slots.append(left)

    def wait(self, minutes: int) -> None:
        self.clock.jump_wall(minutes * 60)

    def back(self, minutes: int) -> None:
        self.clock.jump_wall(-minutes * 60)

    def restart(self) -> None:
        self.calendar = self.made(self.clock)
        self.calendar.restore(self.disk.values())

    # ---- what is compared ----

    def compare(self) -> None:
        assert len(self.calendar) == len(self.naive.slots)
        now = self.clock.wall_ns()
        for robot in ROBOTS:
            self.compare_order(robot)
            for at in (now, now + STEP, now + 5 * STEP, now - 1, now + 7 * STEP + 1, now):
                self.compare_at(robot, at)
        for who in PEOPLE:
            mine = [slot for slot in self.naive.slots if slot.principal == who]
            assert set(map(id_of, self.calendar.of(who))) == set(map(id_of, mine))

    def compare_order(self, robot: str) -> None:
        slots = self.calendar.on(robot, 0, NOW * 2)
        for one, other in pairwise(slots):
            assert one.end_ns <= other.start_ns
        assert set(map(id_of, slots)) == set(map(id_of, self.naive.of_robot(robot)))

    def compare_at(self, robot: str, at: int) -> None:
        present = self.naive.present(robot, at)
        assert self.calendar.present(robot, at) == present
        assert self.calendar.next_of(robot, at) == self.naive.following(robot, at)
        for length in (600, 3600):
            for who in (None, "ann"):
                free = self.naive.next_free(robot, at, length * S, who)
                assert self.calendar.next_free(robot, at, length, who) == free
        for who in PEOPLE:
            assert self.calendar.holds(who, robot, at) == (
                present is not None and present.principal == who
            )
            for required in (False, True):
                self.compare_hindrance(who, robot, at, required=required)

    def compare_hindrance(self, who: str, robot: str, at: int, *, required: bool) -> None:
        conflict = self.calendar.why_not(who, robot, at, required)
        assert (conflict is None) == self.naive.may(who, robot, at, required=required)
        if conflict is None:
            return
        present = self.naive.present(robot, at)
        assert conflict.holder == (present.principal if present else None)
        whose = None if required else who
        assert conflict.free_ns == self.naive.next_free(robot, at, 900 * S, whose)
        coming = [s for s in self.naive.of_robot(robot) if s.principal == who and s.end_ns > at]
        assert conflict.own == min(coming, key=lambda s: s.start_ns, default=None)
        assert str(self.calendar.refusal(conflict, who))


def id_of(slot: BookedSlot) -> str:
    return slot.id


@settings(max_examples=250, deadline=None)
@given(OPS)
def test_the_calendar_agrees_with_a_list(ops: list[tuple[Any, ...]]) -> None:
    Judge(lambda clock: Calendar(clock, UNNAMED)).run(ops)


# ---- calendars that have to be found out ----


class ForgetsToForget(Timeline):
    """The answer to "who has it now" outlives a change."""

    def add(self, slot: BookedSlot) -> bool:
        kept = self._since_ns, self.until_ns
        added = super().add(slot)
        self._since_ns, self.until_ns = kept
        return added


class RemembersFreeTime(Timeline):
    """When it is free next outlives a change."""

    def add(self, slot: BookedSlot) -> bool:
        kept = dict(self._free)
        added = super().add(slot)
        self._free.update(kept)
        return added


class LooksAheadOnly(Timeline):
    """What has begun already is not seen as being in the way."""

    def overlapping(self, from_ns: int, to_ns: int) -> BookedSlot | None:
        found = super().overlapping(from_ns, to_ns)
        return found if found is None or found.start_ns >= from_ns else None


class EndsTooLate(Timeline):
    """A slot is still somebody's in the moment in which it ends."""

    def present(self, now_ns: int) -> BookedSlot | None:
        return super().present(now_ns) or super().present(now_ns - 1)


class TakesTheFirstGap(Timeline):
    """The next free time is the next end, however short the gap."""

    def free_from(self, from_ns: int, length_ns: int, principal: str | None) -> int:
        return super().free_from(from_ns, min(length_ns, 1), principal)


class Calendars:
    """Calendars with a fault each."""

    class ForgetsToForget(Calendar):
        line_kind = ForgetsToForget

    class RemembersFreeTime(Calendar):
        line_kind = RemembersFreeTime

    class LooksAheadOnly(Calendar):
        line_kind = LooksAheadOnly

    class EndsTooLate(Calendar):
        line_kind = EndsTooLate

    class TakesTheFirstGap(Calendar):
        line_kind = TakesTheFirstGap

    class FreeTimeIsEverybodys(Calendar):
        """Where a slot is required, none is needed."""

        def why_not(
            self, principal: str, robot: str, now_ns: int, required: bool
        ) -> SlotConflict | None:
            return super().why_not(principal, robot, now_ns, required and robot != "omni")

    class LosesTheFirst(Calendar):
        """After a restart, the first fact is missing."""

        def restore(self, facts: Iterable[Fact]) -> None:
            super().restore(list(facts)[1:])


FAULTS = [fault for fault in vars(Calendars).values() if isinstance(fault, type)]


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.__name__)
def test_a_calendar_with_a_fault_is_found_out(fault: type[Calendar]) -> None:
    @settings(
        max_examples=300,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
        report_multiple_bugs=False,
    )
    @given(OPS)
    def search(ops: list[tuple[Any, ...]]) -> None:
        Judge(lambda clock: fault(clock, UNNAMED)).run(ops)

    with pytest.raises(AssertionError):
        search()
