"""A room with a cupboard in it, and ways round that. Pure geometry, metres."""

from __future__ import annotations

from itertools import pairwise, permutations
from math import hypot
from typing import NamedTuple

CELL_M = 0.1


class RoomBox(NamedTuple):
    """A rectangle along the axes."""

    x0: float
    y0: float
    x1: float
    y1: float

    def grown(self, by_m: float) -> RoomBox:
        """Return it with a margin on every side; a negative one makes it smaller."""
        return RoomBox(self.x0 - by_m, self.y0 - by_m, self.x1 + by_m, self.y1 + by_m)

    def holds(self, x_m: float, y_m: float) -> bool:
        """Tell whether a place is inside."""
        return self.x0 < x_m < self.x1 and self.y0 < y_m < self.y1


Place = tuple[float, float]

ROOM = RoomBox(-5.0, -4.0, 5.0, 4.0)
CUPBOARD = RoomBox(0.8, -1.0, 1.6, 1.0)
RADIUS_M = 0.3


def free(place: Place) -> bool:
    """Tell whether the robot can stand there."""
    return ROOM.grown(-RADIUS_M).holds(*place) and not CUPBOARD.grown(RADIUS_M).holds(*place)


def way(start: Place, goal: Place) -> list[Place] | None:
    """Return the corners of the shortest free way, the goal last; None if there is none."""
    if not free(goal):
        return None
    if clear(start, goal):
        return [goal]
    box = CUPBOARD.grown(RADIUS_M + 0.05)
    corners = [(x, y) for x in (box.x0, box.x1) for y in (box.y0, box.y1)]
    ways = [[*turns, goal] for count in (1, 2) for turns in permutations(corners, count)]
    open_ways = [w for w in ways if all(map(clear, [start, *w], w))]
    return min(open_ways, key=lambda w: length([start, *w]), default=None)


def clear(one: Place, other: Place) -> bool:
    """Tell whether the robot can go straight from one place to another."""
    box = CUPBOARD.grown(RADIUS_M)
    enter, leave = 0.0, 1.0
    for here, there, low, high in zip(one, other, box[:2], box[2:], strict=True):
        step = there - here
        if step == 0.0:
            if not low < here < high:
                return True
            continue
        near, far = sorted(((low - here) / step, (high - here) / step))
        enter, leave = max(enter, near), min(leave, far)
    return enter >= leave - 1e-9


def length(places: list[Place]) -> float:
    """Return the length of a way."""
    if len(places) < 2:  # noqa: PLR2004 - one place is no way
        return 0.0
    pairs = pairwise(places)
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairs)


def cells() -> tuple[int, int, list[int]]:
    """Return columns, rows and what an occupancy grid holds: 0 free, 100 taken."""
    columns = round((ROOM.x1 - ROOM.x0) / CELL_M)
    rows = round((ROOM.y1 - ROOM.y0) / CELL_M)
    inner = ROOM.grown(-CELL_M)
    found = []
    for row in range(rows):
        for column in range(columns):
            x, y = ROOM.x0 + (column + 0.5) * CELL_M, ROOM.y0 + (row + 0.5) * CELL_M
            found.append(100 if CUPBOARD.holds(x, y) or not inner.holds(x, y) else 0)
    return columns, rows, found
