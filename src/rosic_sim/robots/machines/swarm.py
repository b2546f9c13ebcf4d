"""What the drones of one swarm know of each other."""

from __future__ import annotations

from math import hypot, sqrt
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence


# ---- separation ----

# How a drone keeps away from the others, knowing only what they last said.
#
# Each pair shares its gap: a drone may close in on a peer only as fast as it could brake within
# half of what is left above `KEEP_M`. If both obey, they come to rest before the gap is used up.
# What cannot be done straight on is done by passing on the right, or, from a corner in which that
# leads nowhere, on the left. `KEEP_M` exceeds the promised `APART_M` by what reports may be late
# (0.2 s) and commands may lag.

APART_M = 0.30
"""Promised: centre to centre, horizontally, at every moment."""
KEEP_M = 0.50
"""Aimed at by every drone."""
BRAKING_M_S2 = 1.0
"""Counted on for separation; the drones can do twice that."""
RETREAT_M_S = 0.3
STANDING_M_S = 0.05
RIGHT, LEFT = 1.0, -1.0
_SLACK = 1e-9

Planar: TypeAlias = tuple[float, float]


class SeparationBound(NamedTuple):
    """A peer as a limit: the velocity along (x, y) may be at most ``most_m_s``."""

    x: float
    y: float
    most_m_s: float

    def excess(self, velocity: Planar) -> float:
        """Return by how much a velocity breaks the bound; negative when it does not."""
        return velocity[0] * self.x + velocity[1] * self.y - self.most_m_s


def bound(here: Planar, peer: Planar, reserve_m: float) -> SeparationBound:
    """Return the limit that a peer sets.

    Args:
        here: Own position.
        peer: Its last reported position.
        reserve_m: How far it may have moved since.
    """
    x, y = peer[0] - here[0], peer[1] - here[1]
    distance = hypot(x, y)
    if distance < _SLACK:
        return SeparationBound(1.0, 0.0, -RETREAT_M_S)
    gap = distance - KEEP_M - reserve_m
    if gap > 0.0:
        return SeparationBound(x / distance, y / distance, sqrt(BRAKING_M_S2 * gap))
    return SeparationBound(x / distance, y / distance, max(-RETREAT_M_S, 2.0 * gap))


def keep_apart(wanted: Planar, bounds: Sequence[SeparationBound], side: float = RIGHT) -> Planar:
    """Return the velocity to fly instead of the wanted one: allowed by all bounds.

    Prefers the wanted velocity; then the fastest way of passing one of those in the way on
    ``side``; then what is left of the wanted one; then standing or retreating.
    """
    in_the_way = [limit for limit in bounds if limit.excess(wanted) > _SLACK]
    if not in_the_way:
        return wanted
    passing = [_fit(_passing(wanted, limit, side), bounds) for limit in in_the_way]
    found = max((v for v in passing if v is not None), key=_speed, default=None)
    if found is not None and _speed(found) > STANDING_M_S:
        return found
    worst = max(in_the_way, key=lambda limit: limit.excess(wanted))
    for candidate in (_trimmed(wanted, worst), (0.0, 0.0)):
        fitted = _fit(candidate, bounds)
        if fitted is not None:
            return fitted
    return _retreat(bounds)


def _speed(velocity: Planar) -> float:
    return hypot(velocity[0], velocity[1])


def _passing(wanted: Planar, peer: SeparationBound, side: float) -> Planar:
    speed = hypot(*wanted)
    towards = min(peer.most_m_s, speed)
    aside = side * sqrt(max(0.0, speed * speed - towards * towards))
    return (peer.x * towards + peer.y * aside, peer.y * towards - peer.x * aside)


def _trimmed(wanted: Planar, peer: SeparationBound) -> Planar:
    excess = peer.excess(wanted)
    return (wanted[0] - excess * peer.x, wanted[1] - excess * peer.y)


def _fit(velocity: Planar, bounds: Sequence[SeparationBound]) -> Planar | None:
    """Trim a velocity by every bound in turn; None when that does not satisfy them all."""
    for _ in range(2):
        for limit in bounds:
            if limit.excess(velocity) > 0.0:
                velocity = _trimmed(velocity, limit)
    if all(limit.excess(velocity) <= 1e-6 for limit in bounds):  # noqa: PLR2004
        return velocity
    return None


def _retreat(bounds: Sequence[SeparationBound]) -> Planar:
    """Move away from all that are too near."""
    x = sum(b.x * b.most_m_s for b in bounds if b.most_m_s < 0.0)
    y = sum(b.y * b.most_m_s for b in bounds if b.most_m_s < 0.0)
    speed = hypot(x, y)
    if speed <= RETREAT_M_S:
        return (x, y)
    return (x * RETREAT_M_S / speed, y * RETREAT_M_S / speed)


# ---- swarm ----

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
