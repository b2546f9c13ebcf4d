"""Where everything stands in the room that people see.

The machines know nothing of it: each counts in a frame of its own. Here every frame gets a place.
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, pi, sin
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.robot.view import Box, Colour, OccupancyMap, Point, Pose

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.view import Solid
    from rosic_sim.robots.machines.omni import Omni

TABLE_TOP: Colour = (216, 196, 166)
STEEL: Colour = (128, 136, 146)
WALL: Colour = (247, 248, 250)
THICK_M = 0.04
LEG_M = 0.06


class ScenePlace(NamedTuple):
    """A frame in the room: where its origin is, and how it is turned about z."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float

    def at(self, point: Point) -> Point:
        """Return where a point of the frame is in the room."""
        x, y, z = point
        c, s = cos(self.yaw_rad), sin(self.yaw_rad)
        return self.x_m + c * x - s * y, self.y_m + s * x + c * y, self.z_m + z


class SceneTable(NamedTuple):
    """A table in a robot's frame, its top at height 0 there."""

    x_m: tuple[float, float]
    y_m: tuple[float, float]


FLOOR = (-3.0, -2.5, 3.0, 2.0)
_TOWARDS_US = -pi / 2
HIGH_M = 0.62
PLACES: Mapping[str, ScenePlace] = MappingProxyType(
    {
        "omni": ScenePlace(-0.55, -1.15, 0.0, 0.0),
        "kuka1": ScenePlace(-1.95, 0.70, HIGH_M, -0.62),
        "yumi": ScenePlace(0.35, 1.0, HIGH_M, _TOWARDS_US - 0.12),
        "drones": ScenePlace(1.42, -0.35, 0.0, 0.5),
    }
)
TABLES: Mapping[str, SceneTable] = MappingProxyType(
    {
        "kuka1": SceneTable((-0.25, 0.75), (-0.45, 0.45)),
        "yumi": SceneTable((-0.25, 0.70), (-0.65, 0.65)),
    }
)


def place_of(robot: str) -> ScenePlace:
    """Return a robot's frame; the drones share one."""
    return PLACES.get(robot, PLACES["drones"])


def table_of(robot: str) -> tuple[Solid, ...]:
    """Return the table under a robot; nothing for one that stands on the floor."""
    table = TABLES.get(robot)
    if table is None:
        return ()
    place = place_of(robot)
    (x0, x1), (y0, y1) = table
    middle, size = ((x0 + x1) / 2, (y0 + y1) / 2), (x1 - x0, y1 - y0)
    top = Box(place.at((*middle, -THICK_M / 2)), (*size, THICK_M), TABLE_TOP, place.yaw_rad)
    legs = [
        Box(
            place.at((x, y, -(place.z_m + THICK_M) / 2)),
            (LEG_M, LEG_M, place.z_m - THICK_M),
            STEEL,
            place.yaw_rad,
        )
        for x in (x0 + LEG_M, x1 - LEG_M)
        for y in (y0 + LEG_M, y1 - LEG_M)
    ]
    return (top, *legs)


def walls() -> tuple[Solid, ...]:
    """Return the walls behind everything."""
    x0, y0, x1, y1 = FLOOR
    high, thick = 1.7, 0.06
    return (
        Box(((x0 + x1) / 2, y1 + thick / 2, high / 2), (x1 - x0, thick, high), WALL),
        Box((x0 - thick / 2, (y0 + y1) / 2, high / 2), (thick, y1 - y0, high), WALL),
    )


# ---- plan ----

# The room from above, as a map of what is occupied: in the omni's frame, where it drives.

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
