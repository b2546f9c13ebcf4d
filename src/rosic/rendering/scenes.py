"""A scene drawn without a graphics card: faces from far to near, light, and shadows."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from math import ceil, cos, floor, isfinite, pi, sin, sqrt, tan
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from PIL import Image, ImageChops, ImageDraw, ImageFilter

from rosic.core.i18n import said
from rosic.core.robot.view import Ball, Box, Colour, Point, Tube
from rosic.errors import NothingToSee
from rosic.rendering.style import FINER, INK, font, readable

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.core.robot.view import Scene, Solid


# ---- meshes ----

# Solids as flat faces: what a scene is made of when it is drawn.

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


# ---- scenes ----

MOST_SOLIDS = 600
NEAR_M = 0.05
LIGHT: Point = (0.42, -0.52, 0.744)  # towards the lamp, of length 1
LAMP, SKY, GROUND = 0.50, 0.62, 0.40
GLOSS = 0.16
HAZE_FROM_M, HAZE_TO_M = 5.0, 22.0
SKY_TOP: Colour = (214, 224, 235)
SKY_LOW: Colour = (243, 246, 249)
TILE: Colour = (232, 234, 237)
JOINT: Colour = (214, 218, 223)
TILE_M = 0.5
SHADOW = 105
SHADOW_BLUR_M = 0.02
BROAD_M = 0.3
PLATE: Colour = (255, 255, 255)


class SceneViewpoint:
    """Where one looks from."""

    def __init__(self, scene: Scene, width: int, height: int) -> None:
        numbers = (*scene.eye, *scene.target, scene.angle_rad, *scene.floor)
        if not all(map(isfinite, numbers)) or not 0.05 < scene.angle_rad < 2.5:  # noqa: PLR2004
            raise NothingToSee(said("The scene is broken: its camera is no camera."))
        self.eye = scene.eye
        self.target = scene.target
        self.ahead = unit(plus(scene.target, scene.eye, -1.0))
        self.right = unit(cross(self.ahead, (0.0, 0.0, 1.0)))
        self.up = cross(self.right, self.ahead)
        self.focal = height / 2 / tan(scene.angle_rad / 2)
        self._middle = (width / 2, height / 2)

    def depth(self, point: Point) -> float:
        """Return how far ahead a point is."""
        return dot(plus(point, self.eye, -1.0), self.ahead)

    def place(self, point: Point) -> tuple[float, float]:
        """Return where a point is on the picture; it must be ahead."""
        away = plus(point, self.eye, -1.0)
        scale = self.focal / max(dot(away, self.ahead), NEAR_M)
        (x, y) = self._middle
        return x + dot(away, self.right) * scale, y - dot(away, self.up) * scale


class _Seen(NamedTuple):
    depth: float
    corners: list[tuple[float, float]]
    colour: Colour


def scene_image(scene: Scene, width: int, height: int) -> Image.Image:
    """Draw a scene.

    Raises:
        NothingToSee: It is broken or too large.
    """
    if len(scene.solids) + len(scene.backdrop) > MOST_SOLIDS:
        raise NothingToSee(said("The scene is too large."))
    wide, high = width * FINER, height * FINER
    camera = SceneViewpoint(scene, wide, high)
    behind = [face for solid in scene.backdrop for face in faces_of(solid)]
    faces = [face for solid in scene.solids for face in faces_of(solid)]
    image = _sky(wide, high)
    _floor(image, scene, camera)
    image = _shadows(image, camera, [(_ground(scene), [*behind, *faces])])
    _paint(image, camera, behind)
    tops = [(_Top(box), faces) for box in scene.backdrop if isinstance(box, Box)]
    image = _shadows(image, camera, [pair for pair in tops if pair[0].broad])
    _paint(image, camera, faces)
    image = image.reduce(FINER)
    _labels(image, scene, SceneViewpoint(scene, width, height))
    return image


def _paint(image: Image.Image, camera: SceneViewpoint, faces: list[Face]) -> None:
    """Draw faces, the nearest last."""
    pen = ImageDraw.Draw(image)
    seen = [found for face in faces if (found := _seen(face, camera)) is not None]
    seen.sort(key=lambda one: -one.depth)
    for one in seen:
        pen.polygon(one.corners, fill=one.colour, outline=one.colour)


def _seen(face: Face, camera: SceneViewpoint) -> _Seen | None:
    """Return a face as it appears, or None when one sees its back or nothing of it."""
    corners = face.corners
    middle = _middle(corners)
    away = plus(middle, camera.eye, -1.0)
    if dot(away, face.normal) >= 0:
        return None
    if min(camera.depth(corner) for corner in corners) < NEAR_M:
        return None
    places = [camera.place(corner) for corner in corners]
    if not all(isfinite(x) and isfinite(y) for x, y in places):
        raise NothingToSee(said("The scene is broken: a place in it is no number."))
    distance = sqrt(dot(away, away))
    return _Seen(distance, places, _lit(face, unit(away), distance))


def _middle(corners: tuple[Point, ...]) -> Point:
    count = len(corners)
    return (
        sum(c[0] for c in corners) / count,
        sum(c[1] for c in corners) / count,
        sum(c[2] for c in corners) / count,
    )


def _lit(face: Face, towards: Point, distance: float) -> Colour:
    """Return a face's colour under a lamp and a bright ceiling, with some haze far away."""
    normal = face.normal
    ambient = GROUND + (SKY - GROUND) * (normal[2] + 1) / 2
    lamp = max(0.0, dot(normal, LIGHT))
    bright = ambient + LAMP * lamp
    half = unit(plus(LIGHT, towards, -1.0))
    shine = 255 * GLOSS * max(0.0, dot(normal, half)) ** 24
    haze = min(0.5, max(0.0, (distance - HAZE_FROM_M) / (HAZE_TO_M - HAZE_FROM_M)))
    mixed = [
        (1 - haze) * (part * bright + shine) + haze * far
        for part, far in zip(face.colour, SKY_LOW, strict=True)
    ]
    return min(255, round(mixed[0])), min(255, round(mixed[1])), min(255, round(mixed[2]))


def _sky(wide: int, high: int) -> Image.Image:
    column = Image.new("RGB", (1, 64))
    for row in range(64):
        part = row / 63
        mixed = [round(a + (b - a) * part) for a, b in zip(SKY_TOP, SKY_LOW, strict=True)]
        column.putpixel((0, row), (mixed[0], mixed[1], mixed[2]))
    return column.resize((wide, high), Image.Resampling.BILINEAR)


def _floor(image: Image.Image, scene: Scene, camera: SceneViewpoint) -> None:
    pen = ImageDraw.Draw(image)
    x0, y0, x1, y1 = scene.floor
    columns = range(floor(x0 / TILE_M), ceil(x1 / TILE_M))
    rows = range(floor(y0 / TILE_M), ceil(y1 / TILE_M))
    if len(columns) * len(rows) > 4_000:  # noqa: PLR2004 - a hall of 30 m a side
        raise NothingToSee(said("The scene is too large."))
    for i in columns:
        for j in rows:
            x, y = i * TILE_M, j * TILE_M
            corners: list[Point] = [
                (x, y, 0.0),
                (x + TILE_M, y, 0.0),
                (x + TILE_M, y + TILE_M, 0.0),
                (x, y + TILE_M, 0.0),
            ]
            if min(camera.depth(corner) for corner in corners) < NEAR_M:
                continue
            face = Face(tuple(corners), (0.0, 0.0, 1.0), TILE)
            away = plus(_middle(face.corners), camera.eye, -1.0)
            colour = _lit(face, unit(away), sqrt(dot(away, away)))
            edge = _lit(face._replace(colour=JOINT), unit(away), sqrt(dot(away, away)))
            pen.polygon([camera.place(c) for c in corners], fill=colour, outline=edge, width=FINER)


class _Top:
    """A level surface on which shadows fall."""

    def __init__(self, box: Box) -> None:
        self._box = box
        self._turn = (cos(box.yaw_rad), sin(box.yaw_rad))
        self.height = box.centre[2] + box.size_m[2] / 2
        self.broad = min(box.size_m[:2]) >= BROAD_M

    def holds(self, point: Point) -> bool:
        """Whether a point of its plane lies on it."""
        (c, s), box = self._turn, self._box
        x, y = point[0] - box.centre[0], point[1] - box.centre[1]
        across, up = c * x + s * y, c * y - s * x
        return abs(across) <= box.size_m[0] / 2 and abs(up) <= box.size_m[1] / 2


def _ground(scene: Scene) -> _Top:
    x0, y0, x1, y1 = scene.floor
    return _Top(Box(((x0 + x1) / 2, (y0 + y1) / 2, 0.0), (x1 - x0, y1 - y0, 0.0), TILE))


def _shadows(
    image: Image.Image, camera: SceneViewpoint, falls: list[tuple[_Top, list[Face]]]
) -> Image.Image:
    """Darken surfaces where the lamp does not reach them."""
    if not falls:
        return image
    mask = Image.new("L", image.size, 0)
    pen = ImageDraw.Draw(mask)
    for top, faces in falls:
        for face in faces:
            if dot(face.normal, LIGHT) <= 0:
                continue
            fallen = [_fallen(corner, top.height) for corner in face.corners]
            near = min(camera.depth(corner) for corner in fallen) < NEAR_M
            if not near and all(map(top.holds, fallen)):
                places = [camera.place(corner) for corner in fallen]
                pen.polygon(places, fill=SHADOW, outline=SHADOW)
    distance = max(1.0, camera.depth(camera.target))
    blur = max(1.0, SHADOW_BLUR_M * camera.focal / distance)
    mask = mask.filter(ImageFilter.GaussianBlur(blur))
    dark = ImageChops.multiply(image, Image.new("RGB", image.size, (70, 78, 92)))
    return Image.composite(dark, image, mask)


def _fallen(point: Point, height: float) -> Point:
    """Return where the shadow of a point falls on a level plane; one below casts none of note."""
    x, y, _ = plus(point, LIGHT, -max(0.0, point[2] - height) / LIGHT[2])
    return x, y, height


def _labels(image: Image.Image, scene: Scene, camera: SceneViewpoint) -> None:
    pen = ImageDraw.Draw(image, "RGBA")
    size = max(12, image.height // 38)
    for label in scene.labels[:MOST_SOLIDS]:
        if camera.depth(label.at) < NEAR_M:
            continue
        (x, y), words = camera.place(label.at), readable(label.text)
        face = font(words, size)
        left, top, right, bottom = pen.textbbox((x, y), words, font=face, anchor="mm")
        room = size * 0.45
        box = (left - room * 1.4, top - room, right + room * 1.4, bottom + room)
        pen.rounded_rectangle(box, radius=room * 1.4, fill=(*PLATE, 225))
        pen.text((x, y), words, fill=INK, font=face, anchor="mm")
