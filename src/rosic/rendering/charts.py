"""One value over the last minutes."""

from __future__ import annotations

from math import floor, isfinite, log10
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.i18n import figure, said
from rosic.errors import NothingToSee
from rosic.rendering.style import ACCENT, ACCENT_SOFT, ALERT, FAINT, INK, PAPER, RULE, Sheet

if TYPE_CHECKING:
    from PIL import Image

    from rosic.core.robot.view import TimeSeries
    from rosic.rendering.style import Say


# ---- axes ----

# Axes: where round numbers lie, and how they are written.

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


# ---- charts ----

SIZE, LOW_SIZE = (800, 420), (480, 270)
MOST_POINTS = 2_000
SHORTEST_S = 10.0
GAP_S = 15.0  # without a sample for so long nothing was known in between
MINUTES_FROM_S = 150.0


class Frame(NamedTuple):
    """Where a plot is on its sheet, and what it shows."""

    left: float
    top: float
    right: float
    bottom: float
    from_s: float
    low: float
    high: float

    def at(self, seconds: float, value: float) -> tuple[float, float]:
        """Return the place of a point; seconds before now are negative."""
        x = self.left + (seconds - self.from_s) / -self.from_s * (self.right - self.left)
        y = self.bottom - (value - self.low) / (self.high - self.low) * (self.bottom - self.top)
        return x, y


def chart(curve: TimeSeries, *, low: bool, say: Say = str) -> Image.Image:
    """Draw a curve with its axes, its unit, and its newest value."""
    points = [point for point in curve.points[-MOST_POINTS:] if isfinite(point[1])]
    if not points:
        raise NothingToSee(said("There is nothing to draw yet."))
    width, height = LOW_SIZE if low else SIZE
    sheet = Sheet(width, height, say=say)
    frame = _frame(curve, points, width, height)
    _axes(sheet, frame, curve)
    for stretch in _stretches(points):
        _draw(sheet, frame, stretch)
    newest = frame.at(*points[-1])
    sheet.dot(newest, 4.5, ACCENT, PAPER)
    sheet.text((frame.left - 44, 14), curve.title, size=19)
    value = figure(f"{points[-1][1]:.4g} {curve.unit}".strip())
    sheet.text((frame.right, 14), value, size=19, colour=ACCENT, anchor="ra")
    return sheet.finished()


def _frame(curve: TimeSeries, points: list[tuple[float, float]], width: int, height: int) -> Frame:
    values = [value for _, value in points]
    least, most = min(values), max(values)
    alert = curve.alert_below
    if alert is not None and alert > least - max(most - least, abs(most) * 0.2):
        least, most = min(least, alert), max(most, alert)  # the line is near enough to matter
    least, most = widened(least, most)
    if curve.unit == "%":
        least, most = max(least, -2.0), min(most, 102.0)
        if most - least < 8:  # noqa: PLR2004 - a battery's hundredths are no news
            least, most = max(-2.0, most - 8), max(most, 6.0)
    from_s = min(-SHORTEST_S, points[0][0])
    return Frame(62, 52, width - 26, height - 40, from_s, least, most)


def _axes(sheet: Sheet, frame: Frame, curve: TimeSeries) -> None:
    step = nice_step(frame.high - frame.low, 5)
    for value in ticks(frame.low, frame.high, 5):
        _, y = frame.at(0, value)
        sheet.line([(frame.left, y), (frame.right, y)], RULE)
        sheet.text((frame.left - 8, y), written(value, step), size=13, colour=FAINT, anchor="rm")
    in_minutes = -frame.from_s > MINUTES_FROM_S
    unit_s = 60.0 if in_minutes else 1.0
    past = frame.from_s / unit_s
    step = nice_step(-past, 6)
    for value in ticks(past, 0.0, 6):
        x, _ = frame.at(value * unit_s, frame.low)
        sheet.line([(x, frame.bottom), (x, frame.bottom + 5)], FAINT)
        ago = _ago(written(value, step), in_minutes=in_minutes)
        words = said("now") if abs(value) < step / 2 else ago
        sheet.text((x, frame.bottom + 10), words, size=13, colour=FAINT, anchor="ma")
    sheet.line([(frame.left, frame.bottom), (frame.right, frame.bottom)], FAINT, 1.2)
    alert = curve.alert_below
    if alert is not None and frame.low < alert < frame.high:
        _, y = frame.at(0, alert)
        sheet.dashed(y, frame.left, frame.right, ALERT)
        words = said("alert below {value}", value=figure(f"{alert:.4g}"))
        sheet.text((frame.left + 4, y - 4), words, size=12, colour=ALERT, anchor="ld")


def _ago(count: str, *, in_minutes: bool) -> str:
    return said("{count} min", count=count) if in_minutes else said("{count} s", count=count)


def _stretches(points: list[tuple[float, float]]) -> list[list[tuple[float, float]]]:
    stretches = [[points[0]]]
    for point in points[1:]:
        if point[0] - stretches[-1][-1][0] > GAP_S:
            stretches.append([])
        stretches[-1].append(point)
    return stretches


def _draw(sheet: Sheet, frame: Frame, stretch: list[tuple[float, float]]) -> None:
    places = [frame.at(*point) for point in stretch]
    if len(places) == 1:
        sheet.dot(places[0], 2.5, ACCENT, PAPER)
        return
    shade = [(places[0][0], frame.bottom), *places, (places[-1][0], frame.bottom)]
    sheet.area(shade, ACCENT_SOFT)
    sheet.line([(frame.left, frame.bottom), (frame.right, frame.bottom)], INK, 1.2)
    sheet.line(places, ACCENT, 2.4)
