"""Time at work: by tasks and by orders, every second of it once."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.core.order import OrderEnding, Outcome
from rosic.features.fleet.overview import FleetUsage
from rosic.testing.clock import ManualClock
from rosic.testing.factories import OrderBook
from tests.gateway.place import profile

if TYPE_CHECKING:
    from rosic.core.order import Order

SECOND_NS = 1_000_000_000
DONE = Outcome(OrderEnding.DONE)
ORDERS = OrderBook(profile("w1"), ManualClock())
MOVES, ASKS = ORDERS.order("wave"), ORDERS.order("look")


class Watch:
    """A clock that is set by hand."""

    now_ns = 0

    def __call__(self) -> int:
        return self.now_ns


@given(st.lists(st.tuples(st.sampled_from(["task", "order", "question"]), st.integers(0, 9))))
def test_each_second_counts_once_whatever_begins_and_ends_in_it(
    steps: list[tuple[str, int]],
) -> None:
    clock = Watch()
    told_ns = 0

    def worked(robot: str, past_ns: int) -> None:
        nonlocal told_ns
        assert robot == "w1"
        told_ns += past_ns

    usage = FleetUsage(clock, worked)
    clock.now_ns += SECOND_NS
    worked_s, idle_s = 0, 1
    has_task = False
    under_way: Order | None = None
    for what, seconds in steps:
        if what == "task":
            has_task = not has_task
            usage.note({"w1"} if has_task else set())
        elif under_way is not None:
            usage.ended(under_way, DONE)
            under_way = None
        else:
            under_way = MOVES if what == "order" else ASKS
            usage.began(under_way)
        at_work = has_task or under_way is MOVES
        assert usage.works("w1") == at_work
        clock.now_ns += seconds * SECOND_NS
        worked_s += seconds * at_work
        idle_s = 0 if at_work else idle_s + seconds
        assert usage.idle_s("w1") == idle_s
    assert usage.share(["w1", "w2"]) == pytest.approx(worked_s * SECOND_NS / clock.now_ns / 2)
    usage.settle()
    assert told_ns == worked_s * SECOND_NS
