"""What the drones of one swarm know of each other."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

Place: TypeAlias = tuple[float, float]


class SwarmReport(NamedTuple):
    """What a drone says of itself, 20 times a second while it flies, and when it has landed.

    Attributes:
        time_s: When it was said, on the clock of whoever hears it.
        goal_x_m, goal_y_m: Where it is going, or stays.
        flying: Motors on.
        vx_m_s, vy_m_s: Where it is heading.
        busy: It carries out an order, or is led by streamed positions.
        landing: It comes down, by an order, a stop or of its own accord.
        leader: Whom it follows; empty for nobody.
    """

    robot: str
    time_s: float
    x_m: float
    y_m: float
    z_m: float
    speed_m_s: float
    goal_x_m: float
    goal_y_m: float
    flying: bool
    vx_m_s: float = 0.0
    vy_m_s: float = 0.0
    busy: bool = False
    landing: bool = False
    leader: str = ""


class Swarm:
    """Last reported pose and time of every member, as one drone sees it.

    In process one object serves all. With a process for each drone, each has its own, and `hear`
    is fed from a topic. A drone never sees more of a peer than what is in here.

    Attributes:
        members: Ids in the order of their slots.
        centre: Of every formation; where the drones stand at the start, in the middle.
    """

    def __init__(self, members: Sequence[str], centre: Place = (0.0, 0.0)) -> None:
        self.members = tuple(members)
        self.centre = centre
        self._seen: dict[str, SwarmReport] = {}

    def hear(self, sighting: SwarmReport) -> None:
        """Take in what a drone says of itself; older news than known is ignored."""
        known = self._seen.get(sighting.robot)
        if known is None or sighting.time_s >= known.time_s:
            self._seen[sighting.robot] = sighting

    def last(self, robot: str) -> SwarmReport | None:
        """Return the last sighting of a drone, or None."""
        return self._seen.get(robot)

    def peers(self, robot: str) -> Iterator[SwarmReport]:
        """Yield the last sightings of all others."""
        for name, sighting in self._seen.items():
            if name != robot:
                yield sighting


def slots(shape: str, spacing_m: float, count: int, centre: Place) -> tuple[Place, ...]:
    """Return places around a centre, at least ``spacing_m`` from each other.

    Args:
        shape: ``line`` side by side along y, ``column`` one behind the other along x, first in
            front, ``triangle`` on a regular polygon, first in front.
        spacing_m: Between neighbours.
        count: Drones.
        centre: Middle of the shape.
    """
    x, y = centre
    middle = 0.5 * (count - 1)
    if shape == "line":
        return tuple((x, y + (middle - i) * spacing_m) for i in range(count))
    if shape == "column":
        return tuple((x + (middle - i) * spacing_m, y) for i in range(count))
    if shape != "triangle" or count != 3:  # noqa: PLR2004  a triangle has three corners
        raise ValueError("shapes are line, column, and for three a triangle")
    height = spacing_m * sqrt(0.75)
    return (
        (x + height * 2.0 / 3.0, y),
        (x - height / 3.0, y + 0.5 * spacing_m),
        (x - height / 3.0, y - 0.5 * spacing_m),
    )
