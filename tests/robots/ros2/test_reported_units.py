"""Values as robots report them, in the units of their profiles."""

from __future__ import annotations

import logging

import pytest

from rosic.robots.ros2.telemetry import UnitScale


def test_a_battery_that_speaks_in_per_cent_is_understood(caplog: pytest.LogCaptureFixture) -> None:
    scale = UnitScale("%", "battery of agv")
    with caplog.at_level(logging.WARNING):
        assert [scale(15.0), scale(14.0), scale(0.9)] == [15.0, 14.0, 0.9]
    [record] = caplog.records
    assert record.getMessage().startswith("battery of agv is 15, and no fraction of 1")
    assert scale.guessed


def test_a_battery_whose_profile_says_what_full_is_is_read_so_from_the_beginning(
    caplog: pytest.LogCaptureFixture,
) -> None:
    """Nearly empty after a start, nothing else tells it from a battery that is nearly full."""
    scale = UnitScale("%", "battery of agv", 100.0)
    assert [scale(0.9), scale(15.0), scale(102.0)] == pytest.approx([0.9, 15.0, 102.0])
    assert not scale.guessed
    assert caplog.records == []


def test_a_battery_that_speaks_in_fractions_may_be_more_than_full() -> None:
    scale = UnitScale("%", "battery of agv")
    assert [scale(1.02), scale(0.15)] == pytest.approx([102.0, 15.0])


@pytest.mark.parametrize(("unit", "shown"), [("cm", 1500.0), ("m", 15.0), ("", 15.0)])
def test_other_units_are_what_they_are(unit: str, shown: float) -> None:
    assert UnitScale(unit, "x of agv")(15.0) == shown
