"""What is only told reaches everybody who is connected, in their order, and nobody answers."""

from __future__ import annotations

import pytest

from rosic.core.signal import Signal


def test_everybody_connected_is_told_in_their_order() -> None:
    told: list[tuple[str, int]] = []
    signal: Signal[[int]] = Signal()
    signal.emit(1)
    signal.connect(lambda number: told.append(("first", number)))
    signal.connect(lambda number: told.append(("second", number)))
    signal.emit(2)
    assert told == [("first", 2), ("second", 2)]


def test_nothing_answers() -> None:
    signal: Signal[[]] = Signal()
    signal.connect(lambda: True)
    assert signal.emit.__annotations__["return"] == "None"


def test_somebody_connected_while_it_is_told_hears_of_the_next() -> None:
    told: list[str] = []
    signal: Signal[[]] = Signal()
    signal.connect(lambda: signal.connect(lambda: told.append("late")))
    signal.emit()
    assert told == []
    signal.emit()
    assert told == ["late"]


def test_whoever_fails_at_hearing_it_keeps_it_from_nobody() -> None:
    signal, heard = Signal[[int]](), list[int]()

    def fails(_number: int) -> None:
        raise ZeroDivisionError("of a hearer")

    for hear in (fails, heard.append):
        signal.connect(hear)
    with pytest.raises(ZeroDivisionError, match="of a hearer"):
        signal.emit(7)
    assert heard == [7]
