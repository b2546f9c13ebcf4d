"""What holds for whatever is said: bounds, units, offers."""

from __future__ import annotations

import contextlib
from math import ceil, floor, inf, nan
from typing import TYPE_CHECKING

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rosic.app.features import command_table
from rosic.config.units import compile_units
from rosic.core.language import Do, LineContext, Misunderstood, Vocabulary, bind, show, understand
from rosic.core.order import SpokenValue
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill
from rosic.errors import NotUnderstood, OutOfBounds, Refusal

if TYPE_CHECKING:
    from collections.abc import Sequence

    from tests.core.language.conftest import Arguments, Means


UNITS = compile_units()
LENGTHS = ("m", "cm", "mm", "km", "ft", "in", "yd")
finite = st.floats(min_value=-1e6, max_value=1e6, allow_nan=False)


def digger(bounds: Sequence[float], unit: str, *, integer: bool = False) -> Vocabulary:
    low, high = bounds
    depth = Parameter(unit=unit, min=low, max=high, integer=integer)
    skill = Skill(id="dig", parameters={"depth": depth})
    return Vocabulary.build(
        [Profile(id="r1", link=Link(kind="memory"), skills={"dig": skill})], UNITS, command_table()
    )


def dig(vocabulary: Vocabulary, number: float, unit: str = "") -> float:
    skill = vocabulary.profiles["r1"].skills["dig"]
    value = bind(vocabulary, "r1", skill, (SpokenValue("", number, unit),))["depth"]
    assert isinstance(value, (int, float))
    return value


@settings(deadline=None)  # a busy machine is no fault
@given(
    bounds=st.tuples(finite, finite).map(sorted),
    number=st.floats(),
    declared=st.sampled_from(LENGTHS),
    said=st.sampled_from(("", *LENGTHS)),
)
def test_an_argument_is_inside_its_bounds_and_is_what_was_said(
    bounds: list[float], number: float, declared: str, said: str
) -> None:
    vocabulary = digger(bounds, declared)
    low, high = (bound * UNITS.exact[declared].factor for bound in bounds)
    si = number * UNITS.exact[said or declared].factor
    try:
        value = dig(vocabulary, number, said)
    except Refusal:
        assert not low <= si <= high
    else:
        assert low <= value <= high
        assert abs(value - si) <= 1e-9 * abs(si)


@settings(deadline=None)  # a busy machine is no fault
@given(
    bound=st.floats(min_value=1e-3, max_value=1e6),
    declared=st.sampled_from(LENGTHS),
    said=st.sampled_from(LENGTHS),
)
def test_a_bound_converted_by_hand_is_accepted(bound: float, declared: str, said: str) -> None:
    vocabulary = digger((0, bound), declared)
    number = bound * UNITS.exact[declared].factor / UNITS.exact[said].factor

    assert dig(vocabulary, number, said) <= bound * UNITS.exact[declared].factor


@settings(deadline=None)  # a busy machine is no fault
@given(
    bounds=st.tuples(
        st.floats(min_value=1e-3, max_value=1e6), st.floats(min_value=1e-3, max_value=1e6)
    ).map(sorted),
    number=st.floats(min_value=0, max_value=1e9),
    declared=st.sampled_from(LENGTHS),
    said=st.sampled_from(LENGTHS),
)
def test_every_bound_that_is_offered_is_accepted(
    bounds: list[float], number: float, declared: str, said: str
) -> None:
    vocabulary = digger(bounds, declared)
    try:
        dig(vocabulary, number, said)
    except OutOfBounds as refused:
        (offer,) = refused.offers
        (line,) = understand(offer, vocabulary, LineContext("", frozenset({"r1"})))
        assert isinstance(line, Do)
        bind(vocabulary, "r1", line.skills[0], line.spoken)


@settings(deadline=None)  # a busy machine is no fault
@given(
    bounds=st.tuples(finite, finite).map(sorted),
    integer=st.booleans(),
    unit=st.sampled_from(LENGTHS),
)
def test_every_value_that_is_offered_is_accepted(
    bounds: list[float], unit: str, *, integer: bool
) -> None:
    assume(not integer or ceil(bounds[0]) <= floor(bounds[1]))
    vocabulary = digger(bounds, unit, integer=integer)
    with pytest.raises(NotUnderstood) as refused:
        bind(vocabulary, "r1", vocabulary.profiles["r1"].skills["dig"], ())
    assert refused.value.offers
    for offer in refused.value.offers:
        (line,) = understand(offer, vocabulary, LineContext("", frozenset({"r1"})))
        assert isinstance(line, Do)
        bind(vocabulary, "r1", line.skills[0], line.spoken)


@settings(deadline=None)  # a busy machine is no fault
@given(
    bounds=st.tuples(
        st.floats(allow_nan=False, allow_infinity=False),
        st.floats(allow_nan=False, allow_infinity=False),
    ).map(sorted),
    number=st.floats(),
    declared=st.sampled_from(LENGTHS),
    said=st.sampled_from(LENGTHS),
    integer=st.booleans(),
)
def test_no_bounds_and_no_number_raise_anything_but_a_refusal(
    bounds: list[float], number: float, declared: str, said: str, *, integer: bool
) -> None:
    try:
        vocabulary = digger(bounds, declared, integer=integer)
    except ValueError as too_large:
        assume("too large" not in str(too_large))
        raise
    skill = vocabulary.profiles["r1"].skills["dig"]
    for spoken in ((), (SpokenValue("", number, said),), (SpokenValue("depth", number, ""),)):
        with contextlib.suppress(Refusal):
            show(vocabulary, "r1", skill, bind(vocabulary, "r1", skill, spoken))


@settings(deadline=None)  # a busy machine is no fault
@given(number=st.one_of(st.floats(), st.integers(-20, 20).map(float)))
def test_an_integer_is_whole(number: float) -> None:
    vocabulary = digger((-10, 10), "", integer=True)
    try:
        value = dig(vocabulary, number)
    except Refusal:
        assert not (-10 <= number <= 10) or abs(number - round(number)) > 1e-10
    else:
        assert isinstance(value, int)
        assert abs(value - number) < 1e-8


@pytest.mark.parametrize("number", [nan, inf, -inf, 1e308, -1e308])
def test_no_number_beyond_numbers_is_bound(number: float) -> None:
    for unit in ("", "km"):
        with pytest.raises(Refusal):
            dig(digger((-5, 5), "m"), number, unit)


def test_every_offer_to_a_misunderstood_line_is_understood(means: Means) -> None:
    lines = ["omni mvoe 2 m", "omin move 2 m", "takeof 1 m", "stauts", "help onmi", "use crazyflys"]
    for text in lines:
        line = means(text)
        assert isinstance(line, Misunderstood)
        assert line.offers
        for offer in line.offers:
            understood = means(offer)
            # Or it leads on: which robot?
            assert not isinstance(understood, Misunderstood) or "Which robot" in understood.sentence


def test_a_smaller_value_is_not_offered_beside_a_word_that_says_nothing(
    arguments: Arguments,
) -> None:
    with pytest.raises(OutOfBounds) as refused:
        arguments("omni move 40 m lfet")

    assert str(refused.value) == "omni: one move may be at most 5 m. Nothing was done."
    assert refused.value.offers == ()
