"""Limits on arguments: how they are read, and what they mean for a skill."""

from __future__ import annotations

from math import inf, nan

import pytest

from rosic.config.plugins import catalogue
from rosic.core.i18n import in_language
from rosic.core.policy.limits import (
    Limit,
    LimitMismatch,
    broken_limit,
    fit_limits,
    limit_in_words,
    parse_limit,
    unit_converter,
)
from rosic.core.robot.skill import Argument, Parameter, Skill
from tests.core.policy.product import UNITS

MOVE = Skill(
    id="move",
    parameters={
        "speed": Parameter(min=-1, max=1, unit="m/s"),
        "distance": Parameter(min=1, max=500, unit="cm"),
        "direction": Parameter(choices={"left": (), "right": ()}),
        "times": Parameter(min=1, max=9),
        "rise": Parameter(min=0, max=2, unit="m"),
        "reach": Parameter(min=1, max=2, unit="cubit"),
    },
)


def fitted(*texts: str) -> tuple[Limit, ...]:
    return fit_limits(map(parse_limit, texts), "move", MOVE, unit_converter(UNITS))


@pytest.mark.parametrize(
    ("texts", "low", "high"),
    [
        (("distance <= 1 m",), -inf, 1.0),
        (("distance<=100cm",), -inf, 1.0),
        (("distance ≤ 100",), -inf, 1.0),
        (("distance >= 50 cm",), 0.5, inf),
        (("distance = 2 m",), 2.0, 2.0),
        (("distance >= 1 m", "distance <= 2 m"), 1.0, 2.0),
        (("speed <= 0.2 m/s",), -0.2, 0.2),
        (("speed <= 20 cm/s",), -0.2, 0.2),
        (("speed >= -0.5 m/s", "speed <= 0.2 m/s"), -0.5, 0.2),
        (("speed <= -0.2 m/s",), -inf, -0.2),
        (("times <= 3",), -inf, 3.0),
        (("rise <= 0 m",), -inf, 0.0),
    ],
)
def test_a_limit_is_two_bounds_in_si(texts: tuple[str, ...], low: float, high: float) -> None:
    (limit,) = fitted(*texts)
    assert (limit.min, limit.max) == pytest.approx((low, high), rel=1e-8)
    assert limit.said == " and ".join(texts)


@pytest.mark.parametrize(
    ("texts", "why"),
    [
        (("distance <= 3 N",), "'N' does not fit, it is given in cm"),
        (("distance <= 3 furlong",), "'furlong' is no unit that ROSIC knows"),
        (("times <= 3 m",), "'m' does not fit, it has no unit"),
        (("direction <= 3",), "direction of move is a word"),
        (("distance <= 1 mm",), "is no unit"),
        (("reach <= 1 m",), "its unit 'cubit' is unknown"),
        (
            ("distance <= 0.5 cm",),
            "leaves nothing of distance of move, which goes from 1 to 500 cm",
        ),
        (("distance >= 3 m", "distance <= 2 m"), "leaves nothing"),
    ],
)
def test_a_limit_that_does_not_fit_says_why(texts: tuple[str, ...], why: str) -> None:
    with pytest.raises(LimitMismatch, match=why):
        fitted(*texts)


def test_a_limit_on_what_a_skill_does_not_have_says_nothing_about_it() -> None:
    assert fitted("force <= 20 N") == ()


@pytest.mark.parametrize(
    "text",
    [
        "",
        "speed",
        "speed 0.2",
        "speed <= fast",
        "speed << 2",
        "<= 3 m",
        "speed <= nan",
        "x" * 500,
        "Speed is low",
        "a:b:c speed <= 2",
    ],
)
def test_what_is_no_limit_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is not a limit: write for example speed <= "):
        parse_limit(text)


def test_a_limit_is_as_long_as_a_line_at_most() -> None:
    text = "speed <= 1 " + "m" * 109
    assert parse_limit(text).said == text
    with pytest.raises(ValueError, match="is not a limit"):
        parse_limit(text + "m")


def test_whatever_follows_the_number_is_a_unit() -> None:
    with pytest.raises(LimitMismatch, match="'x10' is no unit"):
        fitted("speed <= 0x10")


def test_an_open_bound_and_a_number_without_end_are_refused() -> None:
    with pytest.raises(ValueError, match="leaves open whether the bound itself"):
        parse_limit("speed < 2 m/s")
    with pytest.raises(ValueError, match="too large"):
        parse_limit("speed <= 1e999")


@pytest.mark.parametrize(
    ("value", "broken"),
    [
        (1.0, False),
        (100 * 0.01, False),
        (1.0001, True),
        (nan, True),
        (-inf, False),
        (inf, True),
        ("1", True),
        (None, True),
    ],
)
def test_only_a_number_within_its_bounds_keeps_a_limit(
    value: Argument | None, *, broken: bool
) -> None:
    arguments = {} if value is None else {"distance": value}
    limits = fitted("distance <= 1 m")
    assert broken_limit(limits, arguments) == (limits[0] if broken else None)


def test_exactly_the_bound_is_allowed_whatever_the_unit() -> None:
    (limit,) = fitted("distance <= 0.35 m")
    assert 35 * 0.01 > 0.35, "the trap is still there"
    assert broken_limit((limit,), {"distance": 35 * 0.01}) is None


@pytest.mark.parametrize(
    ("limit", "german"),
    [
        ("speed <= 0.2 m/s", "Tempo <= 0,2 m/s"),
        ("speed<=0.2m/s", "Tempo<=0,2m/s"),
        ("speed ≤ .5 m/s", "Tempo ≤ ,5 m/s"),
        ("speed >= -0.5 m/s and speed <= 0.2 m/s", "Tempo >= -0,5 m/s und Tempo <= 0,2 m/s"),
        ("angle = +22.5 deg", "Winkel = +22,5 Grad"),
        ("grip2 <= 1.5e-3", "grip2 <= 1,5e-3"),
        ("kuka1:grasp force <= 20 N", "kuka1:grasp Kraft <= 20 N"),
    ],
)
def test_a_limit_reads_in_whatever_language_its_reader_has(limit: str, german: str) -> None:
    assert limit_in_words(limit) == limit
    assert in_language(limit_in_words(limit), catalogue("de")) == german
