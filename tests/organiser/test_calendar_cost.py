"""Asking who has a robot now looks at as many slots with fifty thousand as with a hundred."""

from __future__ import annotations

import gc
import sys
from typing import TYPE_CHECKING

import pytest

from tests.organiser.booking import MIN, NOW, S
from tests.organiser.cost import facts, restored

if TYPE_CHECKING:
    from collections.abc import Callable
    from types import FrameType

    from rosic.organiser.calendar import Calendar


def lines_of(work: Callable[[], object]) -> int:
    """Return how many lines of Python were carried out: a clock that nobody else can slow down."""
    count = 0

    def trace(_frame: FrameType, event: str, _argument: object) -> object:
        nonlocal count
        count += event == "line"
        return trace

    before = sys.gettrace()
    gc.disable()  # whoever hears of a collection is no part of the work
    sys.settrace(trace)  # type: ignore[arg-type]
    try:
        work()
    finally:
        sys.settrace(before)
        gc.enable()
    return count


def asking(calendar: Calendar) -> int:
    for second in range(0, 3600, 60):  # two slots and the gaps after them
        calendar.present("robot1", NOW + second * S)
    return lines_of(lambda: [calendar.present("robot1", NOW + s * S) for s in range(0, 3600, 60)])


def test_looking_costs_the_same_with_many_slots() -> None:
    few, many = restored(facts(100)), restored(facts(50_000))
    assert len(many) == 50_000
    assert asking(many) <= 1.1 * asking(few)
    once = lines_of(lambda: many.present("robot1", NOW + 3600 * S))
    assert lines_of(lambda: many.present("robot1", NOW + 3601 * S)) < once


def test_a_refusal_in_a_calendar_without_gaps_looks_at_it_once() -> None:
    calendar = restored(facts(3000))
    slot = calendar.present("robot1", NOW)
    assert slot is not None
    now_ns = [slot.start_ns]

    def ask() -> None:
        now_ns[0] += MIN
        assert calendar.why_not("nobody", "robot1", now_ns[0], required=True) is not None

    assert lines_of(ask) > 500
    assert lines_of(ask) < 100


@pytest.mark.parametrize("many", [100, 10_000])
def test_a_booking_and_a_cancellation_do_not_look_at_every_slot(many: int) -> None:
    calendar = restored(facts(many))

    def there_and_back() -> None:
        (fact,) = calendar.book("new", "robot1", NOW + 21 * MIN, 60, "new")
        calendar.apply(fact)
        (gone,) = calendar.cancel(fact.key, "new")
        calendar.apply(gone)

    assert lines_of(there_and_back) < 500
