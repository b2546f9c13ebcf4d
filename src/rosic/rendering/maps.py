"""A map, north up as its frame has it, with the robot and its path on it."""

from __future__ import annotations

from math import ceil, cos, isfinite, sin
from typing import TYPE_CHECKING

from PIL import Image

from rosic.core.i18n import joined, said
from rosic.errors import NothingToSee
from rosic.rendering.charts import nice_step, written
from rosic.rendering.paths import nose
from rosic.rendering.style import ACCENT, ALERT, FAINT, INK, PAPER, Sheet

if TYPE_CHECKING:
    from rosic.core.robot.view import OccupancyMap
    from rosic.rendering.style import Say

LARGEST, LOW_LARGEST = 900, 420
SMALLEST = 320
MOST_CELLS = 16_000_000
MOST_POINTS = 5_000
FREE, TAKEN, UNKNOWN = 250, 45, 205
FULL = 100
FOOT = 34


def grid_map(grid: OccupancyMap, *, low: bool, say: Say = str) -> Image.Image:
    """Draw a map.

    Raises:
        NothingToSee: It has no cells, too many, or not as many as it says.
    """
    _check(grid)
    image = _cells(grid)
    largest = LOW_LARGEST if low else LARGEST
    scale = min(largest / max(image.size), 24.0)
    if scale < 1:
        image = image.resize(
            (max(1, round(image.width * scale)), max(1, round(image.height * scale))),
            Image.Resampling.BOX,
        )
    width, height = (max(1, round(scale * n)) for n in (grid.width, grid.height))
    left, top = max(0, (SMALLEST - width) // 2), 0
    sheet = Sheet(max(width, SMALLEST), height + FOOT, say=say)
    sheet.paste(image, (left, top, left + width, top + height))
    place = _Place(grid, scale, left, height)
    _path(sheet, grid, place)
    if grid.pose is not None:
        robot = place.of(grid.pose.x_m, grid.pose.y_m)
        if robot is not None:
            yaw = grid.pose.yaw_rad
            nose(sheet, robot, None if yaw is None else yaw - place.yaw, 13.0)
    _foot(sheet, grid, scale / grid.resolution_m)
    return sheet.finished()


class _Place:
    """Where points of the map's frame are on the sheet."""

    def __init__(self, grid: OccupancyMap, scale: float, left: int, height: int) -> None:
        self._origin = (grid.origin.x_m, grid.origin.y_m)
        self.yaw = grid.origin.yaw_rad or 0.0
        self._per_m = scale / grid.resolution_m
        self._left = left
        self._height = height

    def of(self, x_m: float, y_m: float) -> tuple[float, float] | None:
        if not (isfinite(x_m) and isfinite(y_m)):
            return None
        x, y = x_m - self._origin[0], y_m - self._origin[1]
        c, s = cos(self.yaw), sin(self.yaw)
        across, up = c * x + s * y, c * y - s * x
        return self._left + across * self._per_m, self._height - up * self._per_m


def _check(grid: OccupancyMap) -> None:
    count = grid.width * grid.height
    if grid.width < 1 or grid.height < 1 or not grid.cells:
        raise NothingToSee(said("The map is empty."))
    if count > MOST_CELLS:
        raise NothingToSee(
            said(
                "The map is too large: {count} cells, at most {most}.",
                count=f"{count:,}",
                most=f"{MOST_CELLS:,}",
            )
        )
    if len(grid.cells) != count:
        raise NothingToSee(
            said(
                "The map is broken: {found} cells where {wanted} should be.",
                found=f"{len(grid.cells):,}",
                wanted=f"{count:,}",
            )
        )
    where = (grid.resolution_m, grid.origin.x_m, grid.origin.y_m, grid.origin.yaw_rad or 0.0)
    if not all(map(isfinite, where)) or grid.resolution_m <= 0:
        raise NothingToSee(said("The map is broken: its scale or its origin is no number."))


def _cells(grid: OccupancyMap) -> Image.Image:
    shades = bytearray([UNKNOWN]) * 256
    for percent in range(FULL + 1):
        shades[percent] = round(FREE + (TAKEN - FREE) * percent / FULL)
    image = Image.frombytes("L", (grid.width, grid.height), grid.cells.translate(bytes(shades)))
    return image.transpose(Image.Transpose.FLIP_TOP_BOTTOM).convert("RGB")


def _path(sheet: Sheet, grid: OccupancyMap, place: _Place) -> None:
    every = max(1, ceil(len(grid.path) / MOST_POINTS))
    chosen = (*grid.path[::every], *grid.path[-1:])
    points = [point for x, y in chosen if (point := place.of(x, y)) is not None]
    sheet.line(points, ALERT, 2.5)
    if points:
        sheet.dot(points[-1], 6.0, ALERT, PAPER)


def _foot(sheet: Sheet, grid: OccupancyMap, per_m: float) -> None:
    """Write the scale below the map, and what is missing on it."""
    top = sheet.height - FOOT
    sheet.area(
        [(0, top), (sheet.width, top), (sheet.width, sheet.height), (0, sheet.height)], PAPER
    )
    sheet.line([(0, top), (sheet.width, top)], FAINT)
    step = nice_step(sheet.width / per_m, 5)
    length = step * per_m
    y = top + FOOT / 2
    sheet.line([(12, y - 5), (12, y + 5)], INK, 1.5)
    sheet.line([(12, y), (12 + length, y)], INK, 2)
    sheet.line([(12 + length, y - 5), (12 + length, y + 5)], INK, 1.5)
    sheet.text((20 + length, y), joined(" ", (written(step, step), "m")), size=13, anchor="lm")
    if grid.note:
        sheet.text((sheet.width - 10, y), grid.note, size=12, colour=FAINT, anchor="rm")
    elif grid.path:
        right = sheet.width - 10.0
        right -= sheet.text((right, y), said("path"), size=13, colour=ALERT, anchor="rm")
        sheet.text((right - 10, y), said("robot"), size=13, colour=ACCENT, anchor="rm")
