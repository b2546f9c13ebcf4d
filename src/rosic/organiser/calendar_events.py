"""What has to be said or done at which time of a slot: each of it once.

A slot has one entry in the heap, for the next of its events; it moves on when that has come. So
after a pause all that was missed comes, in order, and a clock set back repeats nothing.
"""

from __future__ import annotations

from heapq import heapify, heappop, heappush
from typing import TYPE_CHECKING, Literal, TypeAlias

import msgspec

from rosic.core.slot import BookedSlot, SlotId
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

_SPARE = 1024


class CalendarEvent(msgspec.Struct, frozen=True, gc=False):
    """One event of a slot that has come: its start, a warning before its end, or its end.

    Attributes:
        at_ns: When it was due, wall clock; much earlier than now after a pause.
        left_s: How long the slot still goes on at that time.
        overtaken: Another event of the same slot has come in the same call: too late to speak of
            this one.
    """

    kind: Literal["start", "warning", "end"]
    slot: BookedSlot
    at_ns: int
    left_s: int = 0
    overtaken: bool = False


# When it is due; later events first, so that one person's end comes before the next one's start;
# a number, so that nothing else is compared; which event; for which slot.
_Entry: TypeAlias = tuple[int, int, int, BookedSlot]


class CalendarEvents:
    """The events that are still to come, of all robots.

    Args:
        slots: Which slots there are, by id; owned and changed by the calendar.
        warnings_s: How long before the end to warn.
    """

    def __init__(self, slots: Mapping[SlotId, BookedSlot], warnings_s: tuple[int, ...]) -> None:
        self._slots = slots
        self._warnings_ns = tuple(sorted((s * SECOND_NS for s in warnings_s), reverse=True))
        self._last = len(warnings_s) + 1
        self._heap: list[_Entry] = []
        self._under_way: dict[SlotId, BookedSlot] = {}
        self._ended: set[SlotId] = set()  # of those that are still kept
        self._number = 0

    def added(self, slot: BookedSlot) -> None:
        """A slot was booked: from its start on, everything rings, even if that is just over."""
        self._push(slot, 0)

    def changed(self, slot: BookedSlot, now_ns: int) -> None:
        """A slot ends at another time than before; what has rung does not ring again."""
        if slot.id in self._under_way:
            self._under_way[slot.id] = slot
            self._push(slot, self._next_event(slot, 1, now_ns))
        elif slot.id not in self._ended:
            self._push(slot, 0)

    def removed(self, slot: BookedSlot, now_ns: int) -> None:
        """A slot is no more. If it had begun, it ends now; somebody has to stop."""
        self._ended.discard(slot.id)
        if self._under_way.get(slot.id) is slot:
            self._number += 1
            heappush(self._heap, (now_ns, -self._last, self._number, slot))

    def begin(self, slots: Iterable[BookedSlot], now_ns: int) -> None:
        """Start from what was written down: what is over by now is not rung again."""
        for slot in slots:
            if slot.end_ns <= now_ns:
                self._ended.add(slot.id)
                continue
            event_index = self._next_event(slot, 0, now_ns)
            if event_index:
                self._under_way[slot.id] = slot
            self._number += 1
            self._heap.append((self._at(slot, event_index), -event_index, self._number, slot))
        heapify(self._heap)

    def due(self, now_ns: int) -> tuple[CalendarEvent, ...]:
        """Return what has become due and has not been returned before, in order."""
        rung: list[tuple[int, int, BookedSlot]] = []
        while self._heap and self._heap[0][0] <= now_ns:
            at_ns, negative, _, slot = heappop(self._heap)
            event_index = -negative
            if not self._is_alive(slot, event_index):
                continue
            rung.append((at_ns, event_index, slot))
            self._go_on(slot, event_index)
        latest = {slot.id: number for number, (_, _, slot) in enumerate(rung)}
        return tuple(
            self._event(at_ns, event_index, slot, overtaken=latest[slot.id] != number)
            for number, (at_ns, event_index, slot) in enumerate(rung)
        )

    def next_ns(self) -> int | None:
        """Return when the next event is due; None if no slot is to come."""
        while self._heap and not self._is_alive(self._heap[0][3], -self._heap[0][1]):
            heappop(self._heap)
        return self._heap[0][0] if self._heap else None

    def _go_on(self, slot: BookedSlot, event_index: int) -> None:
        """One event has come; the slot's next one is due later."""
        if event_index < self._last:
            self._under_way[slot.id] = slot
            self._push(slot, self._next_event(slot, event_index + 1, slot.start_ns))
            return
        del self._under_way[slot.id]
        if slot.id in self._slots:
            self._ended.add(slot.id)

    def _event(
        self, at_ns: int, event_index: int, slot: BookedSlot, *, overtaken: bool
    ) -> CalendarEvent:
        if event_index == 0:
            left_s = (slot.end_ns - slot.start_ns) // SECOND_NS
            return CalendarEvent("start", slot, at_ns, left_s, overtaken)
        if event_index == self._last:
            return CalendarEvent("end", slot, at_ns, 0, overtaken)
        left_s = self._warnings_ns[event_index - 1] // SECOND_NS
        return CalendarEvent("warning", slot, at_ns, left_s, overtaken)

    def _is_alive(self, slot: BookedSlot, event_index: int) -> bool:
        """Whether an entry still says something: its slot is there, or has to be ended."""
        if self._slots.get(slot.id) is slot:
            return event_index == 0 or slot.id in self._under_way
        return event_index == self._last and self._under_way.get(slot.id) is slot

    def _at(self, slot: BookedSlot, event_index: int) -> int:
        if event_index == 0:
            return slot.start_ns
        return slot.end_ns - (
            0 if event_index == self._last else self._warnings_ns[event_index - 1]
        )

    def _next_event(self, slot: BookedSlot, event_index: int, after_ns: int) -> int:
        """Return the first event from this one on that is due after a moment; at last the end."""
        while event_index < self._last and self._at(slot, event_index) <= after_ns:
            event_index += 1
        return event_index

    def _push(self, slot: BookedSlot, event_index: int) -> None:
        self._number += 1
        heappush(self._heap, (self._at(slot, event_index), -event_index, self._number, slot))
        if len(self._heap) > 2 * len(self._slots) + _SPARE:
            self._heap = [entry for entry in self._heap if self._is_alive(entry[3], -entry[1])]
            heapify(self._heap)
