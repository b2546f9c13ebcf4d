"""Minus and plus beside a number: always forwards, never outside, and there is always an end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosic.app.features import command_table
from rosic.config.profiles import known_units
from rosic.core.language import Vocabulary
from rosic.core.language.formatting import beginning, stepped
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Parameter, Skill

if TYPE_CHECKING:
    from rosic.core.language.compiled import CompiledParameter


def _compiled(parameter: Parameter) -> CompiledParameter:
    skill = Skill(id="go", parameters={"value": parameter})
    robot = Profile(id="omni", link=Link(kind="memory"), skills={"go": skill})
    vocabulary = Vocabulary.build([robot], known_units(), command_table())
    return vocabulary.robots["omni"].skills["go"].parameters[0]


def _up(parameter: Parameter, value: float, taps: int) -> list[float]:
    compiled, seen = _compiled(parameter), []
    unit = compiled.unit
    si = value * unit.factor + unit.offset
    for _ in range(taps):
        si = stepped(compiled, si)[1]
        seen.append(round((si - unit.offset) / unit.factor, 9))
    return seen


@pytest.mark.parametrize(
    ("parameter", "value", "expected"),
    [
        (Parameter(unit="m", min=0.01, max=5), 0.5, [1, 2, 5, 5]),
        (Parameter(unit="m", min=0.01, max=5), 0.7, [1, 2]),
        (Parameter(unit="N", min=5, max=40), 15, [16, 18, 20]),
        (Parameter(unit="deg", min=-175, max=175), -10, [0, 20, 40]),
        (Parameter(min=1, max=7, integer=True), 3, [4, 5, 6, 7, 7]),
        (Parameter(unit="m/s", min=0, max=1), 0.98, [1, 1]),
        (Parameter(unit="m", min=2, max=2), 2, [2]),
    ],
)
def test_plus(parameter: Parameter, value: float, expected: list[float]) -> None:
    assert _up(parameter, value, len(expected)) == expected


def test_where_it_begins() -> None:
    assert beginning(_compiled(Parameter(unit="N", min=5, max=40, default=15))) == 15
    assert beginning(_compiled(Parameter(unit="cm", min=1, max=500))) == 0.5
    assert beginning(_compiled(Parameter(choices={"left": (), "right": ()}))) == "left"
    assert beginning(_compiled(Parameter(text=True))) is None
    first = beginning(_compiled(Parameter(min=1, max=7, integer=True)))
    assert (type(first), first) == (int, 1)


BOUNDS = st.tuples(
    st.floats(-1e6, 1e6, allow_nan=False), st.floats(1e-6, 1e6), st.booleans(), st.floats(0, 1)
)


@given(BOUNDS, st.sampled_from(["m", "cm", "deg", "N", "", "ft"]))
def test_taps_lead_from_end_to_end_and_never_outside(
    bounds: tuple[float, float, bool, float], unit: str
) -> None:
    low, width, integer, share = bounds
    if integer:
        low, width = float(round(low)), float(round(width))
    whole = integer and not unit
    compiled = _compiled(Parameter(unit=unit, min=low, max=low + width, integer=whole))
    si = compiled.low + share * (compiled.high - compiled.low)
    for direction, end in ((1, compiled.high), (0, compiled.low)):
        for _ in range(200):
            before, si = si, stepped(compiled, si)[direction]
            assert compiled.low <= si <= compiled.high
            if si == end:
                break
            assert (si > before) if direction else (si < before)
        assert si == end
