"""Axes: where round numbers lie, and how they are written."""

from __future__ import annotations

from math import floor, log10

from rosic.core.i18n import figure

STEPS = (1.0, 2.0, 5.0, 10.0)
FLAT = 1e-9


def nice_step(span: float, about: int) -> float:
    """Return a round step that divides a span into roughly so many parts."""
    rough = max(span, FLAT) / max(1, about)
    scale = 10.0 ** floor(log10(rough))
    return next(step * scale for step in STEPS if step * scale >= rough * (1 - FLAT))


def widened(low: float, high: float, least: float = 0.0) -> tuple[float, float]:
    """Return bounds with some room around them; what never changes gets room as well."""
    span = max(high - low, least, abs(high) * 0.02, FLAT)
    middle = (low + high) / 2
    return middle - span * 0.56, middle + span * 0.56


def ticks(low: float, high: float, about: int = 5) -> list[float]:
    """Return the round numbers between two bounds."""
    step = nice_step(high - low, about)
    first = floor(low / step)
    found = [(first + i) * step for i in range(4 * about + 8)]
    return [value for value in found if low - step * FLAT <= value <= high + step * FLAT]


def written(value: float, step: float) -> str:
    """Return a tick as text, with as many digits as its step needs."""
    if abs(value) < step * 1e-6:
        value = 0.0
    if step >= 1e6 or step < 1e-4:  # noqa: PLR2004 - beyond that nobody counts digits
        return figure(f"{value:.3g}")
    digits = max(0, -floor(log10(step) + FLAT))
    return figure(f"{value:,.{digits}f}")
