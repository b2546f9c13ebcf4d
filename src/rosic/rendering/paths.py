"""Where a robot went: from above, and its height beside it where that matters."""

from __future__ import annotations

from itertools import pairwise
from math import cos, hypot, isfinite, sin
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.errors import NothingToSee
from rosic.rendering.charts import nice_step, ticks, widened, written
from rosic.rendering.style import ACCENT, FAINT, GOOD, INK, PAPER, RULE, SEVERAL, Sheet

if TYPE_CHECKING:
    from PIL import Image

    from rosic.core.robot.view import Colour, PathsView, PathView, Pose
    from rosic.rendering.style import Say

SIZE, LOW_SIZE = (640, 640), (400, 400)
LEAST_M = 0.2
MARGIN = 62
MOST_POINTS = 2_000
HEIGHT_SHARE = 0.28


class Plot:
    """A square piece of the plane on a sheet; both axes to the same scale."""

    def __init__(
        self,
        sheet: Sheet,
        area: tuple[float, float, float, float],
        across: tuple[float, float],
        up: tuple[float, float],
        *,
        equal: bool = True,
    ) -> None:
        self.sheet = sheet
        self.left, self.top, self.right, self.bottom = area
        self._x, self._y = across, up
        if equal:
            wide, high = self.right - self.left, self.bottom - self.top
            scale = max((across[1] - across[0]) / wide, (up[1] - up[0]) / high)
            self._x, self._y = _around(across, scale * wide), _around(up, scale * high)

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Return where a point is on the sheet; y goes up."""
        (x0, x1), (y0, y1) = self._x, self._y
        return (
            self.left + (x - x0) / (x1 - x0) * (self.right - self.left),
            self.bottom - (y - y0) / (y1 - y0) * (self.bottom - self.top),
        )

    def rule(self, across: str, up: str, about: int = 6) -> None:
        """Draw the lines of round numbers, and write them."""
        sheet, (x0, x1), (y0, y1) = self.sheet, self._x, self._y
        step = nice_step(x1 - x0, about)
        for value in ticks(x0, x1, about) if across else ():
            x, _ = self.at(value, y0)
            sheet.line([(x, self.top), (x, self.bottom)], RULE)
            place = (x, self.bottom + 7)
            sheet.text(place, written(value, step), size=12, colour=FAINT, anchor="ma")
        step = nice_step(y1 - y0, about)
        for value in ticks(y0, y1, about):
            _, y = self.at(x0, value)
            sheet.line([(self.left, y), (self.right, y)], RULE)
            place = (self.left - 7, y)
            sheet.text(place, written(value, step), size=12, colour=FAINT, anchor="rm")
        frame = [(self.left, self.top), (self.right, self.top), (self.right, self.bottom)]
        frame += [(self.left, self.bottom), (self.left, self.top)]
        sheet.line(frame, FAINT)
        sheet.text((self.right, self.bottom + 24), across, size=12, colour=FAINT, anchor="ra")
        sheet.text((self.left, self.top - 7), up, size=12, colour=FAINT, anchor="ld")


def way(ways: PathView, *, low: bool, say: Say = str) -> Image.Image:
    """Draw a way with its beginning, its end, and where the robot looked then."""
    poses = [pose for pose in ways.points[-MOST_POINTS:] if _finite(pose)]
    if not poses:
        raise NothingToSee(said("There is nothing to draw yet."))
    width, height = LOW_SIZE if low else SIZE
    sheet = Sheet(width, height, say=say)
    sheet.text((18, 14), ways.title, size=17)
    below = round(height * HEIGHT_SHARE) if ways.vertical else 0
    xs, ys = [p.x_m for p in poses], [p.y_m for p in poses]
    plot = Plot(
        sheet,
        (MARGIN, 62, width - 24, height - 42 - below),
        widened(min(xs), max(xs), LEAST_M),
        widened(min(ys), max(ys), LEAST_M),
    )
    plot.rule("x, m", "y, m")
    _draw(plot, [(p.x_m, p.y_m) for p in poses])
    nose(sheet, plot.at(poses[-1].x_m, poses[-1].y_m), poses[-1].yaw_rad)
    if ways.vertical:
        _height(sheet, poses, (MARGIN, height - below + 22, width - 24, height - 22))
    return sheet.finished()


def ways_together(together: PathsView, *, low: bool, say: Say = str) -> Image.Image:
    """Draw where several robots went, each in a colour of its own with its name at the end."""
    drawn = [
        (way_.title, poses)
        for way_ in together.ways
        if (poses := [pose for pose in way_.points[-MOST_POINTS:] if _finite(pose)])
    ]
    if not drawn:
        raise NothingToSee(said("There is nothing to draw yet."))
    width, height = LOW_SIZE if low else SIZE
    sheet = Sheet(width, height, say=say)
    sheet.text((18, 14), together.title, size=17)
    xs = [pose.x_m for _, poses in drawn for pose in poses]
    ys = [pose.y_m for _, poses in drawn for pose in poses]
    plot = Plot(
        sheet,
        (MARGIN, 62, width - 24, height - 42),
        widened(min(xs), max(xs), LEAST_M),
        widened(min(ys), max(ys), LEAST_M),
    )
    plot.rule("x, m", "y, m")
    for number, (name, poses) in enumerate(drawn):
        colour = SEVERAL[number % len(SEVERAL)]
        places = [plot.at(pose.x_m, pose.y_m) for pose in poses]
        sheet.line(places, colour, 3.0)
        sheet.dot(places[0], 5.0, PAPER, colour)
        nose(sheet, places[-1], poses[-1].yaw_rad, colour=colour)
        _named(sheet, name, places[-1], colour)
    return sheet.finished()


def _named(sheet: Sheet, name: str, at: tuple[float, float], colour: Colour) -> None:
    """Write a name beside a point, on the side where there is room for it."""
    x, y = at
    left = x > sheet.width / 2
    sheet.text(
        (x - 14 if left else x + 14, y - 12),
        name,
        size=13,
        colour=colour,
        anchor="rs" if left else "ls",
    )


def nose(
    sheet: Sheet,
    at: tuple[float, float],
    yaw_rad: float | None,
    size: float = 11.0,
    colour: Colour = ACCENT,
) -> None:
    """Draw the robot: an arrow head that looks where it looks, or a dot."""
    if yaw_rad is None or not isfinite(yaw_rad):
        sheet.dot(at, size * 0.6, colour, PAPER)
        return
    x, y = at
    c, s = cos(yaw_rad), sin(yaw_rad)
    corners = [(1.25, 0.0), (-0.85, 0.8), (-0.45, 0.0), (-0.85, -0.8)]
    outline = [(x + size * (a * c - b * s), y - size * (a * s + b * c)) for a, b in corners]
    sheet.area(outline, colour, PAPER)


def _height(sheet: Sheet, poses: list[Pose], area: tuple[float, float, float, float]) -> None:
    """Draw the height over the length of the way."""
    gone = [0.0]
    for one, other in pairwise(poses):
        here, there = (one.x_m, one.y_m, one.z_m), (other.x_m, other.y_m, other.z_m)
        gone.append(gone[-1] + hypot(*(b - a for a, b in zip(here, there, strict=True))))
    heights = [pose.z_m for pose in poses]
    plot = Plot(
        sheet,
        area,
        (0.0, max(gone[-1], LEAST_M)),
        widened(min(0.0, *heights), max(heights), LEAST_M),
        equal=False,
    )
    plot.rule("", said("height, m"), about=3)
    _draw(plot, list(zip(gone, heights, strict=True)))


def _draw(plot: Plot, points: list[tuple[float, float]]) -> None:
    places = [plot.at(*point) for point in points]
    plot.sheet.line(places, ACCENT, 3.0)
    plot.sheet.dot(places[0], 6.0, GOOD, PAPER)
    plot.sheet.dot(places[-1], 6.0, INK, PAPER)


def _around(bounds: tuple[float, float], span: float) -> tuple[float, float]:
    middle = (bounds[0] + bounds[1]) / 2
    return middle - span / 2, middle + span / 2


def _finite(pose: Pose) -> bool:
    return all(map(isfinite, (pose.x_m, pose.y_m, pose.z_m)))
