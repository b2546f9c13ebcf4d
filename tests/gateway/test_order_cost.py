"""An order costs no more calls, and passes no more modules, than it did: a count, not a time."""

from __future__ import annotations

import sys

import pytest

from rosic.system import SystemClock
from tests import order_cost
from tests.architecture import PAGE
from tests.tracing import Tracer

# They may fall, never rise; docs/architecture.md says them as well.
CALLS, MODULES = 116, 35


@pytest.fixture(scope="module")
def found() -> order_cost.OrderCost:
    return order_cost.cost()


def test_an_order_costs_no_more_than_it_did(found: order_cost.OrderCost) -> None:
    assert found.calls <= CALLS, found.entered
    assert len(found.modules) <= MODULES, found.modules
    if sys.version_info >= (3, 12):
        return  # a comprehension is no call there
    said = f"{found.calls} calls in {len(found.modules)} modules"
    assert (found.calls, len(found.modules)) == (CALLS, MODULES), f"write {said}"
    assert said in PAGE.read_text(encoding="utf-8"), f"write {said}"


def test_all_four_rooms_are_passed_from_the_message_to_what_is_told(
    found: order_cost.OrderCost,
) -> None:
    assert found.entered[0] == order_cost.RECEIVE
    for room in ("authoriser", "organiser", "container", "linker", "robots", "gateway.delivery"):
        assert any(module.startswith(f"rosic.{room}.") for module in found.modules), room
    assert not any(module.startswith(order_cost.BENCH) for module in found.modules)


async def test_a_coroutine_counts_again_where_it_goes_on() -> None:
    tracer, clock = Tracer(), SystemClock()
    tracer.start()
    try:
        await clock.sleep(0)
    finally:
        tracer.stop()
    name = ("rosic.system", "SystemClock.sleep")
    assert tracer.entered == [(name, True), (name, False)]
    assert tracer.begun == ["rosic.system.SystemClock.sleep"]


def test_a_call_more_in_the_usual_order_is_counted_and_what_happens_once_is_not() -> None:
    usual = [(order_cost.RECEIVE, True), (("rosic.linker.linker", "Linker.dispatch"), True)]
    bench = [(("rosic.bench.senders", "BenchMessenger.edit"), True)]
    tracer, more = Tracer(), [(("rosic.core.lease", "Lease.take"), True)]
    tracer.entered = (usual + bench) * 3 + usual + more + (usual + bench) * 3
    assert order_cost.usual(tracer).calls == len(usual)
    tracer.entered = (usual + more + bench) * 5 + usual
    assert order_cost.usual(tracer).calls == len(usual) + 1
    assert order_cost.usual(tracer).modules[0] == "rosic.core.lease"
