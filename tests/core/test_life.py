"""What of an order's life a person would want to see."""

from __future__ import annotations

from rosic.core.life import Life
from rosic.core.order import Report, Stage

RUNNING = Stage.RUNNING


def test_a_report_that_says_neither_what_nor_how_far_is_no_news() -> None:
    life = Life("Forklift", "go", lambda _ns: "14:00:00", 0)
    assert life.step(Report(Stage.RECEIVED), 1)
    assert not life.step(Report(RUNNING), 2)
    assert life.progress() == ""
    assert life.step(Report(RUNNING, None, "lifting"), 3)
    assert not life.step(Report(RUNNING), 4)
    assert life.step(Report(RUNNING, 0.0), 5)
    assert not life.step(Report(RUNNING, 0.01), 6)
