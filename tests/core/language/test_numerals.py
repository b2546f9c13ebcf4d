from __future__ import annotations

from math import inf, isnan

import pytest

from rosic.core.language.numbers import read_numeral


@pytest.mark.parametrize(
    ("word", "value", "rest"),
    [
        ("5", 5, ""),
        ("0.5", 0.5, ""),
        (".5", 0.5, ""),
        ("-0.5", -0.5, ""),
        ("+2", 2, ""),
        ("0,5", 0.5, ""),
        ("12,25", 12.25, ""),
        ("0,500", 0.5, ""),
        ("1500,250", 1500.25, ""),
        ("1.500", 1.5, ""),
        ("50cm", 50, "cm"),
        ("1.5m/s", 1.5, "m/s"),
        ("30°", 30, "°"),
        ("20%", 20, "%"),
        ("1e1", 10, ""),
        ("1e-2m", 0.01, "m"),
        ("2e", 2, "e"),
        ("1/2", 0.5, ""),
        ("3/4m", 0.75, "m"),
        ("-1/4", -0.25, ""),
        ("½", 0.5, ""),
        ("¼m", 0.25, "m"),
        ("10^2", 100, ""),
        ("10^-2", 0.01, ""),
        ("10^400", inf, ""),
        ("-10^400", -inf, ""),
        ("1e400", inf, ""),
        ("9" * 400, inf, ""),
    ],
)
def test_a_number_is_read(word: str, value: float, rest: str) -> None:
    numeral = read_numeral(word)

    assert numeral is not None
    assert (numeral.value, numeral.rest, numeral.readings) == (value, rest, ())


@pytest.mark.parametrize(
    ("word", "readings"),
    [
        ("1,500", ("1.5", "1500")),
        ("-2,250", ("-2.25", "-2250")),
        ("999,000", ("999", "999000")),
        ("12,345m", ("12.345", "12345")),
    ],
)
def test_a_number_that_may_be_two_says_so(word: str, readings: tuple[str, ...]) -> None:
    numeral = read_numeral(word)

    assert numeral is not None
    assert isnan(numeral.value)
    assert numeral.readings == readings


def test_a_division_by_nothing_is_no_number_that_can_be_used() -> None:
    numeral = read_numeral("1/0")

    assert numeral is not None
    assert isnan(numeral.value)


@pytest.mark.parametrize(
    "word",
    [
        "",
        "m",
        "left",
        "-",
        "+",
        ".",
        ",",
        "1-2",
        "1,2,3",
        "1.2.3",
        "1/2/3",
        "--1",
        "1½",
        "5²",
        "10²",
        "²",
        "①",
        "Ⅳ",
        "一",
        "nan",
        "inf",
        "0x10,5",
        "1:30",
        "1,500.5",
    ],
)
def test_what_is_no_number_is_not_read_as_one(word: str) -> None:
    numeral = read_numeral(word)

    assert numeral is None or numeral.rest


def test_an_underscore_is_no_part_of_a_number() -> None:
    numeral = read_numeral("1_000")

    assert numeral is not None
    assert (numeral.value, numeral.rest) == (1, "_000")
