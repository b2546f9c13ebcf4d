"""The next smaller and the next larger value: what a minus and a plus beside a number mean."""

from __future__ import annotations

from math import ceil, floor, log10
from typing import TYPE_CHECKING

from rosic.core.language.formatting import usual_values

if TYPE_CHECKING:
    from rosic.core.language.compiled import CompiledParameter
    from rosic.core.robot.skill import Argument

# Bounds this far apart are gone through by preferred numbers (1, 2, 5, 10, ...), so that ten taps
# lead from a centimetre to a few metres; others in equal steps, twenty or fewer from end to end.
WIDE, TOO_WIDE = 20.0, 1e6
STEPS = 20.0
_EVEN = 1e-9
_PREFERRED = (1.0, 2.0, 5.0, 10.0)


def stepped(parameter: CompiledParameter, si: float) -> tuple[float, float]:
    """Return the neighbours of a number, SI. At a bound the neighbour is the bound itself."""
    unit = parameter.unit
    low, high, value = map(unit.from_si, (parameter.low, parameter.high, si))
    if low > 0 and WIDE * low <= high <= TOO_WIDE * low:
        below, above = _preferred_below(value), _preferred_above(value)
    else:
        step = _preferred_from((high - low) / STEPS) if high > low else 1.0
        if parameter.integer:
            step = max(1.0, step)
        at = value / step
        near = min(0.4, _EVEN * max(1.0, abs(at)))
        below = (ceil(at - near) - 1) * step
        above = (floor(at + near) + 1) * step
    if parameter.integer:
        below, above = floor(below), ceil(above)
    # Not by way of the declared unit: a bound is met exactly.
    smaller = parameter.low if below <= low else unit.to_si(below)
    larger = parameter.high if above >= high else unit.to_si(above)
    return smaller, larger


def beginning(parameter: CompiledParameter) -> Argument | None:
    """Return what to propose first: the default, else a small round number or the first choice.

    None where only a person can know: a text.
    """
    if parameter.default is not None or parameter.text:
        return parameter.default
    if parameter.words is not None:
        return next(iter(parameter.words.values()))
    unit = parameter.unit
    value = float(usual_values(parameter)[0])
    if parameter.integer and unit.factor == 1.0 and unit.offset == 0.0:
        return int(value)
    return unit.to_si(value)


def _preferred_from(value: float) -> float:
    """Return the smallest preferred number that is not below."""
    power = 10.0 ** floor(log10(value))
    return next(float(f"{n * power:.6g}") for n in _PREFERRED if n * power >= value * (1 - _EVEN))


def _preferred_above(value: float) -> float:
    return _preferred_from(value * (1 + 1e-6))


def _preferred_below(value: float) -> float:
    power = 10.0 ** floor(log10(value * (1 - 1e-6)))
    return max(float(f"{n * power:.6g}") for n in _PREFERRED if n * power <= value * (1 - 1e-6))
