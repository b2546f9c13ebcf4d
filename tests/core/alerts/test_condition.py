"""What a rule says, and what it makes of a robot's report."""

from __future__ import annotations

from math import inf, nan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.config.profiles import known_units
from rosic.core.alerts.condition import ConditionNames, compile_condition
from rosic.core.alerts.state import AlertReading
from rosic.core.robot.profile import Presence

NAMES = ConditionNames({"battery": "%", "x": "m", "mode": "", "heat": "°C"}, known_units())
BAD, BETWEEN, GOOD, MISSING = (
    AlertReading.BAD,
    AlertReading.BETWEEN,
    AlertReading.GOOD,
    AlertReading.MISSING,
)


def read(when: str, clear: str = "", **values: float | str) -> AlertReading:
    presence = Presence(online=True, age_s=0.1, values=dict(values))
    return compile_condition(when, clear, NAMES).reading(presence)


@pytest.mark.parametrize(
    ("when", "clear", "value", "reading"),
    [
        ("battery < 20 %", "", 19.9, BAD),
        ("battery < 20 %", "", 20.0, BETWEEN),
        ("battery < 20 %", "", 21.0, GOOD),
        ("battery <= 20 %", "", 20.0, BAD),
        ("battery < 20%", "battery > 25 %", 25.0, BETWEEN),
        ("battery < 20%", "battery > 25 %", 25.1, GOOD),
        ("battery < 20%", "battery >= 25 %", 25.0, GOOD),
        ("battery > 0.8", "", 81.0, MISSING),
    ],
)
def test_one_threshold(when: str, clear: str, value: float, reading: AlertReading) -> None:
    if reading is MISSING:
        with pytest.raises(ValueError, match="needs a unit"):
            read(when, clear, battery=value)
    else:
        assert read(when, clear, battery=value) is reading


def test_a_benchmark_and_how_far_from_it_is_too_far() -> None:
    found = [read("x outside 190 to 210 cm", x=x) for x in (1.8, 1.905, 2.0, 2.095, 2.2)]
    assert found == [BAD, BETWEEN, GOOD, BETWEEN, BAD]
    within = "x within 1.95 to 2.05 m"
    assert [read("x outside 190 to 210 cm", within, x=x) for x in (1.92, 1.96)] == [BETWEEN, GOOD]


def test_units_are_understood_and_offsets_too() -> None:
    assert read("heat > 86 °F", heat=30.5) is BAD
    assert read("heat > 86 °F", heat=29.0) is BETWEEN


def test_words_and_what_the_link_says() -> None:
    assert read("mode is Manual", mode="manual") is BAD
    assert read("mode is manual", mode="auto") is GOOD
    assert read("mode is manual") is MISSING
    assert read("offline") is GOOD
    assert read("link_age > 5 s") is GOOD
    gone = Presence(online=False, age_s=9.0, values={"battery": 5.0})
    for when, reading in (
        ("offline", BAD),
        ("silent", BAD),
        ("battery silent", BAD),
        ("link_age > 5 s", BAD),
        ("battery < 20 %", MISSING),
    ):
        assert compile_condition(when, "", NAMES).reading(gone) is reading, when
    assert compile_condition("offline", "", NAMES).reading(Presence()) is MISSING


@pytest.mark.parametrize("value", [nan, inf, -inf])
def test_what_is_no_number_says_nothing_but_that_it_is_silent(value: float) -> None:
    assert read("battery < 20 %", battery=value) is MISSING
    assert read("battery silent", battery=value) is BAD
    assert read("battery silent", battery=50.0) is GOOD


@given(
    st.floats(-1e6, 1e6),
    st.sampled_from(["<", "<=", ">", ">="]),
    st.floats(-1e3, 1e3).filter(lambda limit: abs(limit) > 1e-3),
)
def test_what_is_bad_is_never_good(value: float, sign: str, limit: float) -> None:
    compare = {
        "<": value < round(limit, 6),
        "<=": value <= round(limit, 6),
        ">": value > round(limit, 6),
        ">=": value >= round(limit, 6),
    }[sign]
    found = read(f"x {sign} {limit:.6f} m", x=value)
    assert (found is BAD) == compare


@pytest.mark.parametrize(
    ("when", "clear", "sentence"),
    [
        ("y < 1 m", "", "'y' is not a value"),
        ("battery < 3 m", "", "no unit of battery"),
        ("battery < 3 furlong", "", "not a unit ROSIC knows"),
        ("battery < nan %", "", "not a number"),
        ("battery", "", "no condition"),
        ("x < 0 m", "", "threshold of 0"),
        ("battery < 20 %", "battery > 15 %", "good side"),
        ("battery < 20 %", "battery < 25 %", "good side"),
        ("battery < 20 %", "x > 25 m", "compare battery"),
        ("x outside 2 to 1 m", "", "no range"),
        ("x within 1 to 2 m", "", "outside"),
        ("offline", "battery > 3 %", "no place"),
    ],
)
def test_what_makes_no_sense_is_said(when: str, clear: str, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        compile_condition(when, clear, NAMES)
