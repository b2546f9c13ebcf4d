"""Numbers and arguments as people read them, in the units of the profile."""

from __future__ import annotations

from math import ceil, floor, isfinite, log10
from typing import TYPE_CHECKING

from rosic.core.i18n import figure, joined, said, titled
from rosic.core.language.common_names import shown_name
from rosic.core.language.kept_places import place_at
from rosic.core.language.sanitise import quote
from rosic.core.units import imperial_unit, measured

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.language.compiled import CompiledParameter, CompiledSkill
    from rosic.core.language.numbers import Unit
    from rosic.core.language.vocabulary import Vocabulary
    from rosic.core.robot.profile import RobotId
    from rosic.core.robot.skill import Argument, Skill


# ---- numbers and arguments ----

_SMALL = 1e-3
_LARGE = 1e9
_DIGITS = (4, 6, 9, 12)
_EXACT = 1e-9
# Beyond these, powers of ten are no floats any more.
_ROUNDED_FROM, _ROUNDED_TO = 1e-290, 1e290
_SHARES = (0.1, 0.2, 0.5)


def show_number(value: float) -> str:
    """Return a number with at most three decimals, or in powers of ten where that hides it."""
    if value == 0:
        return "0"
    if not isfinite(value) or not _SMALL <= abs(value) < _LARGE:
        return f"{value:.6g}"
    return f"{value:.3f}".rstrip("0").rstrip(".")


def show_value(si: float, unit: Unit) -> str:
    """Return an SI value in a unit: ``0.50 m``, ``15 N``. Metres have two decimals at least."""
    value = unit.from_si(si)
    text = show_number(value)
    if unit.symbol == "m" and "e" not in text:
        whole, _, decimals = text.partition(".")
        text = f"{whole}.{decimals:0<2}"
    return measured(f"{text} {unit.symbol}".rstrip(), value, unit.symbol)


def shown_bound(low: float, high: float, unit: Unit, *, upper: bool, with_unit: bool = True) -> str:
    """Return one of two SI bounds as it is read; in other units it is rounded inwards as well."""
    shown = _with_unit(show_bound(low, high, unit, upper=upper), unit, with_unit)
    other = imperial_unit(unit)
    if other is None:
        return measured(shown, 0.0, unit.symbol if with_unit else "")
    return figure(shown, _with_unit(show_bound(low, high, other, upper=upper), other, with_unit))


def _with_unit(number: str, unit: Unit, with_unit: bool) -> str:
    return f"{number} {unit.symbol}".rstrip() if with_unit else number


def show_bound(low: float, high: float, unit: Unit, *, upper: bool) -> str:
    """Return one of two SI bounds in a unit: short, and never outside them.

    What does not come out even is rounded inwards: 5 m is at most 16.4 ft.
    """
    value = unit.from_si(high if upper else low)
    if not _ROUNDED_FROM < abs(value) < _ROUNDED_TO:
        return repr(value) if value else "0"
    short = float(f"{value:.6g}")
    if abs(short - value) <= _EXACT * abs(value):
        return f"{short:.10g}"
    for digits in _DIGITS:
        step = 10.0 ** (floor(log10(abs(value))) + 1 - digits)
        short = float(f"{(floor if upper else ceil)(value / step) * step:.{digits + 1}g}")
        if low <= unit.to_si(short) <= high:
            return f"{short:.{digits + 1}g}"
    return repr(value)


def usual_values(parameter: CompiledParameter) -> tuple[str, ...]:
    """Return a few round numbers within the bounds, in the declared unit, for offering.

    Of a large range they are the lower part: nobody is tempted to begin with the most.
    """
    unit = parameter.unit
    low, high = map(unit.from_si, (parameter.low, parameter.high))
    top = max(abs(low), abs(high))
    values: list[float] = []
    if _ROUNDED_FROM < top < _ROUNDED_TO:
        values = [_round_below(share * top) for share in _SHARES]
        if parameter.integer:
            first = ceil(low)
            values = [float(whole) for whole in range(first, min(floor(high), first + 3) + 1)]
    inside = [f"{value:.10g}" for value in values if low <= value <= high]
    return tuple(dict.fromkeys(inside)) or (
        show_bound(parameter.low, parameter.high, unit, upper=False),
    )


def _round_below(value: float) -> float:
    """Return the nearest of 1, 2, 5, 10, 20, 50 ... that is not above."""
    power = floor(log10(value))
    return max(float(f"{n}e{power}") for n in (1, 2, 5) if n * 10.0**power <= value * (1 + _EXACT))


def show(
    vocabulary: Vocabulary, robot: RobotId, skill: Skill, arguments: Mapping[str, Argument]
) -> str:
    """Return what an order does, for a reply: ``move, 0.50 m left``, ``grasp, 15 N``.

    A number at its default is left out where another number says more.

    Args:
        vocabulary: The snapshot with which they were bound.
        robot: Who does it.
        skill: One of its skills.
        arguments: SI, as `bind` returned them. One that the skill does not have is left out.
    """
    compiled = vocabulary.compiled_skill(robot, skill.id)
    if compiled is None:
        return skill.id
    told = [p for p in compiled.numbers if arguments.get(p.name, p.default) != p.default]
    numbers = [
        show_named(compiled, parameter, arguments[parameter.name])
        for parameter in told or compiled.numbers
        if parameter.name in arguments
    ]
    words = [
        _show_word(parameter, str(arguments[parameter.name]))
        for parameter in compiled.parameters
        if not parameter.is_number and parameter.name in arguments
    ]
    values = joined(" ", filter(None, (joined(", ", numbers), *words)))
    kept = vocabulary.places.get(robot)
    if kept and (place := place_at(kept, skill.id, arguments)):
        values = joined(": ", (place, values))
    name = titled(compiled.spoken, skill.titles)
    return joined(", ", (name, values)) if values else name


def _show_word(parameter: CompiledParameter, word: str) -> str:
    return quote(word) if parameter.text else show_choice(word)


def show_choice(word: str) -> str:
    """Return a choice as people read it; common ones in their language."""
    return shown_name(word)


def show_named(compiled: CompiledSkill, parameter: CompiledParameter, value: Argument) -> str:
    """Show a number; with its name where another of the same kind could be meant."""
    text = show_value(float(value), parameter.unit)
    dimension = parameter.unit.dimension
    alike = [p for p in compiled.numbers if p.unit.dimension == dimension]
    if len(alike) > 1 or not dimension:
        return joined(" ", (parameter.shown, text))
    return text


# ---- the next smaller and larger value ----

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


def live_words(skill: Skill) -> str:
    """Return what a live order does, for a reply: ``drive, live``."""
    return said("{skill}, live", skill=skill.id.replace("_", " "))
