"""How far a robot is that only says what is left."""

from __future__ import annotations

from importlib import import_module
from math import nan
from typing import Any

from rosic.robots.ros2.bindings.goal_fields import RemainingFraction


def test_what_is_left_is_measured_against_the_most_that_ever_was() -> None:
    message: Any = import_module("std_msgs.msg").Float32
    said = RemainingFraction("data")
    told = [said(message(data=left)) for left in (0.0, 4.0, 3.0, 5.0, 0.0)]
    # Nav2 says 0 until it has planned: that is not "there".
    assert told == [None, 0.0, 0.25, 0.0, 1.0]


def test_what_is_not_said_is_not_guessed() -> None:
    message: Any = import_module("std_msgs.msg").Float32
    assert RemainingFraction("data")(message(data=nan)) is None
    assert RemainingFraction("remaining")(message(data=1.0)) is None
