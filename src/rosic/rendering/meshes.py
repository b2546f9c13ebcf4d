"""Solids as flat faces: what a scene is made of when it is drawn."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from math import ceil, cos, pi, sin, sqrt
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from rosic.core.robot.view import Ball, Box, Colour, Point, Tube

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.robot.view import Solid

Corners: TypeAlias = tuple[Point, ...]

# Large faces are cut up, so that what stands before what can be told face by face.
PATCH_M = 0.14
SMALL_M = 0.07
MOST_PATCHES = 9
ROUND = 26
BALL_ROWS = 9
TINY = 1e-9


class Face(NamedTuple):
    """A flat face.

    Attributes:
        corners: In order around it.
        normal: Outwards, of length 1.
    """

    corners: Corners
    normal: Point
    colour: Colour


def faces_of(solid: Solid) -> Iterator[Face]:
    """Yield the faces of a solid."""
    if isinstance(solid, Tube):
        yield from _tube(solid)
    elif isinstance(solid, Ball):
        yield from _ball(solid)
    else:
        yield from _box(solid)


def plus(a: Point, b: Point, scale: float = 1.0) -> Point:
    """Return ``a + scale * b``."""
    return a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]


def dot(a: Point, b: Point) -> float:
    """Return the inner product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Point, b: Point) -> Point:
    """Return the outer product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit(a: Point) -> Point:
    """Return a vector of length 1; straight up for one without length."""
    length = sqrt(dot(a, a))
    return (a[0] / length, a[1] / length, a[2] / length) if length > TINY else (0.0, 0.0, 1.0)


def _tube(tube: Tube) -> Iterator[Face]:
    axis = plus(tube.end, tube.start, -1.0)
    length = sqrt(dot(axis, axis))
    along = unit(axis)
    aside = unit(cross(along, (0.0, 0.0, 1.0) if abs(along[2]) < 0.9 else (1.0, 0.0, 0.0)))  # noqa: PLR2004
    across = cross(along, aside)
    wide = tube.radius_m if tube.end_radius_m is None else tube.end_radius_m
    slope = (tube.radius_m - wide) / length if length > TINY else 0.0
    spokes = [plus(_scaled(aside, c), across, s) for c, s in _circle()]
    cuts = min(MOST_PATCHES, max(1, ceil(length / PATCH_M)))
    rings: list[list[Point]] = []
    for cut in range(cuts + 1):
        part = cut / cuts
        centre = plus(tube.start, axis, part)
        radius = tube.radius_m + (wide - tube.radius_m) * part
        rings.append([plus(centre, spoke, radius) for spoke in spokes])
    middles = [unit(plus(plus(a, b), along, 2 * slope)) for a, b in _neighbours(spokes)]
    for ring, other in pairwise(rings):
        for index, normal in enumerate(middles):
            after = (index + 1) % ROUND
            yield Face((ring[index], ring[after], other[after], other[index]), normal, tube.colour)
    yield Face(tuple(rings[0]), _scaled(along, -1.0), tube.colour)
    yield Face(tuple(rings[-1]), along, tube.colour)


def _ball(ball: Ball) -> Iterator[Face]:
    rows: list[list[Point]] = []
    for row in range(BALL_ROWS + 1):
        up = pi * row / BALL_ROWS
        rows.append([(c * sin(up), s * sin(up), cos(up)) for c, s in _circle()])
    for upper, lower in pairwise(rows):
        for index in range(ROUND):
            after = (index + 1) % ROUND
            around = (upper[index], upper[after], lower[after], lower[index])
            normal = unit(plus(plus(around[0], around[1]), plus(around[2], around[3])))
            corners = tuple(plus(ball.centre, spoke, ball.radius_m) for spoke in around)
            yield Face(corners, normal, ball.colour)


def _box(box: Box) -> Iterator[Face]:
    c, s = cos(box.yaw_rad), sin(box.yaw_rad)
    axes: tuple[Point, Point, Point] = ((c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0))
    for index in range(3):
        first, second = (index + 1) % 3, (index + 2) % 3
        for sign in (1.0, -1.0):
            normal = _scaled(axes[index], sign)
            centre = plus(box.centre, normal, box.size_m[index] / 2)
            one = _scaled(axes[first], box.size_m[first])
            other = _scaled(axes[second], box.size_m[second])
            upper = index == 2 and sign > 0  # noqa: PLR2004 - the third axis
            colour = box.top if upper and box.top is not None else box.colour
            for corners in _patches(centre, one, other):
                yield Face(corners, normal, colour)


def _patches(centre: Point, one: Point, other: Point) -> Iterator[Corners]:
    rows, columns = _cuts(one), _cuts(other)
    corner = plus(plus(centre, one, -0.5), other, -0.5)
    grid = [
        [plus(plus(corner, one, i / rows), other, j / columns) for j in range(columns + 1)]
        for i in range(rows + 1)
    ]
    for above, below in pairwise(grid):
        for j in range(columns):
            yield above[j], above[j + 1], below[j + 1], below[j]


def _cuts(edge: Point) -> int:
    return min(MOST_PATCHES, max(1, ceil(sqrt(dot(edge, edge)) / SMALL_M)))


def _scaled(a: Point, scale: float) -> Point:
    return a[0] * scale, a[1] * scale, a[2] * scale


def _neighbours(spokes: list[Point]) -> Iterator[tuple[Point, Point]]:
    return pairwise([*spokes, spokes[0]])


@lru_cache(maxsize=1)
def _circle() -> tuple[tuple[float, float], ...]:
    return tuple((cos(2 * pi * i / ROUND), sin(2 * pi * i / ROUND)) for i in range(ROUND))
