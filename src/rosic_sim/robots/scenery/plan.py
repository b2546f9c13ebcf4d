"""The room from above, as a map of what is occupied: in the omni's frame, where it drives."""

from __future__ import annotations

from functools import lru_cache
from math import cos, sin
from typing import TYPE_CHECKING

from rosic.core.robot.view import OccupancyMap, Pose
from rosic_sim.robots.scenery.places import FLOOR, TABLES, place_of

if TYPE_CHECKING:
    from rosic_sim.robots.machines.omni import Omni

CELL_M = 0.05
TAKEN = 100
FRAME = "map"


def pose_of(omni: Omni) -> Pose:
    """Return where the omni is."""
    base = omni.base
    return Pose(base.x_m, base.y_m, 0.0, base.yaw_rad, FRAME)


def plan_of(omni: Omni) -> OccupancyMap:
    """Return the map, and the omni on it."""
    x0, y0, x1, y1 = FLOOR
    room = place_of("omni")
    columns, rows = round((x1 - x0) / CELL_M), round((y1 - y0) / CELL_M)
    origin = Pose(x0 - room.x_m, y0 - room.y_m, 0.0, 0.0, FRAME)
    return OccupancyMap(columns, rows, CELL_M, origin, _cells(columns, rows), pose_of(omni))


@lru_cache(maxsize=1)
def _cells(columns: int, rows: int) -> bytes:
    x0, y0, _, _ = FLOOR
    cells = bytearray(columns * rows)
    for row in range(rows):
        for column in range(columns):
            edge = row in {0, rows - 1} or column in {0, columns - 1}
            x, y = x0 + (column + 0.5) * CELL_M, y0 + (row + 0.5) * CELL_M
            if edge or any(_under(table, x, y) for table in TABLES):
                cells[row * columns + column] = TAKEN
    return bytes(cells)


def _under(table: str, x_m: float, y_m: float) -> bool:
    place, (across, along) = place_of(table), TABLES[table]
    x, y = x_m - place.x_m, y_m - place.y_m
    c, s = cos(place.yaw_rad), sin(place.yaw_rad)
    return across[0] <= c * x + s * y <= across[1] and along[0] <= c * y - s * x <= along[1]
