"""What of an order's life a person would want to see."""

from __future__ import annotations

from rosic.core.order import OrderStage, StageReport
from rosic.core.order_status import OrderStatus

RUNNING = OrderStage.RUNNING


def test_a_report_that_says_neither_what_nor_how_far_is_no_news() -> None:
    life = OrderStatus("Forklift", "go", lambda _ns: "14:00:00", 0)
    assert life.step(StageReport(OrderStage.RECEIVED), 1)
    assert not life.step(StageReport(RUNNING), 2)
    assert life.progress() == ""
    assert life.step(StageReport(RUNNING, None, "lifting"), 3)
    assert not life.step(StageReport(RUNNING), 4)
    assert life.step(StageReport(RUNNING, 0.0), 5)
    assert not life.step(StageReport(RUNNING, 0.01), 6)
