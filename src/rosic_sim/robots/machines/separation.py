"""How a drone keeps away from the others, knowing only what they last said.

Each pair shares its gap: a drone may close in on a peer only as fast as it could brake within
half of what is left above `KEEP_M`. If both obey, they come to rest before the gap is used up.
What cannot be done straight on is done by passing on the right, or, from a corner in which that
leads nowhere, on the left. `KEEP_M` exceeds the promised `APART_M` by what reports may be late
(0.2 s) and commands may lag.
"""

from __future__ import annotations

from math import hypot, sqrt
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence

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
