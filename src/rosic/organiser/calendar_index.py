"""Every slot there is, in memory: restart is replay, and looking is cheap."""

from __future__ import annotations

import logging
from bisect import bisect_left, bisect_right, insort
from itertools import islice
from typing import TYPE_CHECKING, ClassVar, TypeVar

from rosic.core.order import FOREVER_NS
from rosic.core.slot import SERIES, SLOT, BookedSlot, Series, SeriesId, SlotId, read_fact
from rosic.core.time_units import SECOND_NS
from rosic.organiser.calendar_events import CalendarEvent, CalendarEvents

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rosic.contracts.clock import Clock
    from rosic.core.identity import PrincipalId
    from rosic.core.records import Fact
    from rosic.core.robot.profile import RobotId


# ---- one robot's slots ----

MOST_REMEMBERED = 256


class Timeline:
    """Asked for each order who has the robot now, it remembers the answer until that changes.

    It remembers too when the robot is free next, because that is told with each refusal, and in a
    calendar without gaps many slots have to be looked at to find out.

    Attributes:
        until_ns: For how long what `present` answered last is so.
    """

    __slots__ = ("_free", "_present", "_since_ns", "_slots", "_starts", "until_ns")

    def __init__(self) -> None:
        self._starts: list[int] = []
        self._slots: list[BookedSlot] = []
        self._free: dict[tuple[int, PrincipalId | None], tuple[int, int]] = {}
        self._present: BookedSlot | None = None
        self._since_ns = self.until_ns = 0  # for this long the answer holds: not at all yet

    def __len__(self) -> int:
        return len(self._slots)

    def add(self, slot: BookedSlot) -> bool:
        """Put a slot in; return False, and change nothing, if it overlaps another."""
        if self.overlapping(slot.start_ns, slot.end_ns) is not None:
            return False
        at = bisect_left(self._starts, slot.start_ns)
        self._starts.insert(at, slot.start_ns)
        self._slots.insert(at, slot)
        self._forget()
        return True

    def remove(self, slot: BookedSlot) -> None:
        """Take a slot out that is in."""
        at = bisect_left(self._starts, slot.start_ns)
        del self._starts[at], self._slots[at]
        self._forget()

    def present(self, now_ns: int) -> BookedSlot | None:
        """Return the slot that is now."""
        if self._since_ns <= now_ns < self.until_ns:
            return self._present
        after = bisect_right(self._starts, now_ns)
        before = self._slots[after - 1] if after else None
        next_ns = self._starts[after] if after < len(self._starts) else FOREVER_NS
        if before is not None and now_ns < before.end_ns:
            self._present, self._since_ns, self.until_ns = before, before.start_ns, before.end_ns
        else:
            ended_ns = before.end_ns if before is not None else -FOREVER_NS
            self._present, self._since_ns, self.until_ns = None, ended_ns, next_ns
        return self._present

    def next_after(self, now_ns: int) -> BookedSlot | None:
        """Return the first slot that starts after a moment."""
        at = bisect_right(self._starts, now_ns)
        return self._slots[at] if at < len(self._slots) else None

    def overlapping(self, from_ns: int, to_ns: int) -> BookedSlot | None:
        """Return the first slot that takes some of this time."""
        at = self._first_ending_after(from_ns)
        if at < len(self._slots) and self._starts[at] < to_ns:
            return self._slots[at]
        return None

    def between(self, from_ns: int, to_ns: int) -> Iterator[BookedSlot]:
        """Yield the slots that take some of this time."""
        at = self._first_ending_after(from_ns)
        while at < len(self._slots) and self._starts[at] < to_ns:
            yield self._slots[at]
            at += 1

    def free_from(self, from_ns: int, length_ns: int, principal: PrincipalId | None) -> int:
        """Return from when on so much time is nobody's.

        Args:
            from_ns: Not earlier.
            length_ns: How much; at least 1.
            principal: Whose own slots count as free; None: nobody's.
        """
        asked = length_ns, principal
        since_ns, free_ns = self._free.get(asked, (FOREVER_NS, 0))
        if since_ns <= from_ns <= free_ns:
            return free_ns
        if len(self._free) >= MOST_REMEMBERED:
            self._free.clear()
        free_ns = self._search(from_ns, length_ns, principal)
        self._free[asked] = from_ns, free_ns
        return free_ns

    def _search(self, from_ns: int, length_ns: int, principal: PrincipalId | None) -> int:
        at, free_ns = self._first_ending_after(from_ns), from_ns
        while at < len(self._slots) and self._starts[at] < free_ns + length_ns:
            if self._slots[at].principal != principal:
                free_ns = self._slots[at].end_ns
            at += 1
        return free_ns

    def _forget(self) -> None:
        self._since_ns = self.until_ns = 0
        self._free.clear()

    def _first_ending_after(self, at_ns: int) -> int:
        at = bisect_right(self._starts, at_ns)
        return at - 1 if at and self._slots[at - 1].end_ns > at_ns else at


# ---- all slots ----
# In memory: restart is replay, and looking is cheap.

log = logging.getLogger("rosic.organiser")

T = TypeVar("T", BookedSlot, Series)

_NOBODYS = Timeline()  # of a robot without slots; nothing is ever put in


class CalendarIndex:
    """Who has which robot when. Asking who has one now costs the same however many slots there are.

    Args:
        clock: The wall clock counts here.
        warnings_s: How long before the end of a slot to warn.
    """

    line_kind: ClassVar[type[Timeline]] = Timeline
    """What keeps one robot's slots; tests plant faults here."""

    def __init__(self, clock: Clock, warnings_s: tuple[int, ...]) -> None:
        self._clock = clock
        self._slots: dict[SlotId, BookedSlot] = {}
        self._series: dict[SeriesId, Series] = {}
        self._lines: dict[RobotId, Timeline] = {}
        self._people: dict[PrincipalId, list[BookedSlot]] = {}
        self._longest_ns = 0
        self._bells = CalendarEvents(self._slots, warnings_s)

    def __len__(self) -> int:
        return len(self._slots)

    # ---- what is so ----

    def restore(self, facts: Iterable[Fact]) -> None:
        """Start from what was written down. What is over by now is not told again.

        A fact that cannot be read, or overlaps one that was, is logged and left out.
        """
        slots: dict[SlotId, BookedSlot] = {}
        for fact in facts:
            if fact.kind == SERIES:
                self._apply_series(fact)
            elif fact.kind == SLOT and not fact.body:
                slots.pop(fact.key, None)
            elif fact.kind == SLOT and (slot := _read(fact, BookedSlot)) is not None:
                slots[slot.id] = slot
        in_order = sorted(slots.values(), key=_start)
        self._bells.begin([slot for slot in in_order if self._put(slot)], self._clock.wall_ns())

    def apply(self, fact: Fact) -> None:
        """Make one fact so, once it is written down. Doing it twice changes nothing more."""
        if fact.kind == SERIES:
            self._apply_series(fact)
        elif fact.kind == SLOT:
            self._apply_slot(fact)

    def _apply_slot(self, fact: Fact) -> None:
        old = self._slots.get(fact.key)
        if not fact.body:
            if old is not None:
                self._take(old)
                self._bells.removed(old, self._clock.wall_ns())
            return
        new = _read(fact, BookedSlot)
        if new is None or new == old:
            return
        if old is not None:
            self._take(old)
        if not self._put(new):
            if old is not None:
                self._put(old)
        elif old is None:
            self._bells.added(new)
        else:
            self._bells.changed(new, self._clock.wall_ns())

    def _apply_series(self, fact: Fact) -> None:
        if not fact.body:
            self._series.pop(fact.key, None)
        elif (series := _read(fact, Series)) is not None:
            self._series[series.id] = series

    def _put(self, slot: BookedSlot) -> bool:
        line = self._lines.get(slot.robot)
        if line is None:
            line = self._lines[slot.robot] = self.line_kind()
        if not line.add(slot):
            log.error("slot %s overlaps another one of %s; left out", slot.id, slot.robot)
            return False
        self._slots[slot.id] = slot
        insort(self._people.setdefault(slot.principal, []), slot, key=_start)
        self._longest_ns = max(self._longest_ns, slot.end_ns - slot.start_ns)
        return True

    def _take(self, slot: BookedSlot) -> None:
        self._lines[slot.robot].remove(slot)
        del self._slots[slot.id]
        mine = self._people[slot.principal]
        mine.remove(slot)
        if not mine:
            del self._people[slot.principal]

    # ---- looking ----

    def slot(self, slot_id: SlotId) -> BookedSlot | None:
        """Return a slot by its id."""
        return self._slots.get(slot_id)

    def series(self, series_id: SeriesId) -> Series | None:
        """Return a series by its id."""
        return self._series.get(series_id)

    def of(self, principal: PrincipalId) -> tuple[BookedSlot, ...]:
        """Return somebody's slots in order, those of the past that are kept too."""
        return tuple(self._people.get(principal, ()))

    def on(self, robot: RobotId, from_ns: int, to_ns: int) -> tuple[BookedSlot, ...]:
        """Return a robot's slots that take some of this time, in order."""
        return tuple(self._line(robot).between(from_ns, to_ns))

    def present(self, robot: RobotId, now_ns: int) -> BookedSlot | None:
        """Return the slot that is now; the one thing that is asked for every order."""
        line = self._lines.get(robot)
        return None if line is None else line.present(now_ns)

    def answer_ends_ns(self, robot: RobotId, now_ns: int) -> int:
        """Return until when `present` goes on to answer what it answers now."""
        line = self._lines.get(robot)
        if line is None:
            return FOREVER_NS
        line.present(now_ns)
        return line.until_ns

    def has_slots(self, robot: RobotId) -> bool:
        """Whether a robot was ever booked; one look-up."""
        return robot in self._lines

    def holds(self, principal: PrincipalId, robot: RobotId, now_ns: int) -> bool:
        """Whether the present slot is this person's."""
        slot = self.present(robot, now_ns)
        return slot is not None and slot.principal == principal

    def next_of(self, robot: RobotId, now_ns: int) -> BookedSlot | None:
        """Return the first slot that starts after now."""
        return self._line(robot).next_after(now_ns)

    def next_free(
        self, robot: RobotId, from_ns: int, length_s: int, principal: PrincipalId | None = None
    ) -> int:
        """Return from when on a robot is free for so long.

        ``principal``'s own slots count as free: when they may use it, not when they may book it.
        """
        return self._line(robot).free_from(from_ns, max(1, length_s) * SECOND_NS, principal)

    def _line(self, robot: RobotId) -> Timeline:
        return self._lines.get(robot, _NOBODYS)

    def _upcoming(self, principal: PrincipalId, now_ns: int) -> Iterator[BookedSlot]:
        """Yield somebody's slots that are not over, in order."""
        mine = self._people.get(principal, [])
        at = bisect_left(mine, now_ns - self._longest_ns, key=_start)
        return (slot for slot in islice(mine, at, None) if slot.end_ns > now_ns)

    # ---- events ----

    def due(self, now_ns: int) -> tuple[CalendarEvent, ...]:
        """Return starts, warnings and ends that have come, each once, in order."""
        return self._bells.due(now_ns)

    def next_event_ns(self) -> int | None:
        """Return when `due` has something next, wall clock; None if no slot is to come."""
        return self._bells.next_ns()


def _start(slot: BookedSlot) -> int:
    return slot.start_ns


def _read(fact: Fact, kind: type[T]) -> T | None:
    """Read a fact; one that cannot be read is as if it were not there."""
    try:
        read = read_fact(fact, kind)
    except ValueError:
        log.warning("a %s that was written down cannot be read; left out", fact.kind)
        return None
    if read.id != fact.key:
        log.error("a %s is written down under another id; left out", fact.kind)
        return None
    return read
