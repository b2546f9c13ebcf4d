"""From a place on Earth to a place in a robot's frame.

On the WGS 84 ellipsoid: geodetic to geocentric coordinates (National Imagery and Mapping Agency,
TR8350.2, World Geodetic System 1984), then into the plane that touches the
Earth at the frame's origin. Nothing is approximated; a phone errs by metres all the same.
"""

from __future__ import annotations

from math import cos, hypot, isfinite, radians, sin, sqrt
from typing import Final

import msgspec

FARTHEST_M: Final = 10_000.0
POLAR_DEG: Final = 85.0
_RADIUS_M: Final = 6_378_137.0
_FLATTENING: Final = 1 / 298.257223563
_E2: Final = _FLATTENING * (2 - _FLATTENING)
HALF_TURN_DEG: Final = 180.0


class OutsidePlane(ValueError):
    """A place is too far from the frame's origin for both to lie in one plane."""


class GeographicFrame(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the origin of the robot's frame is on Earth, and where its x axis points.

    Attributes:
        latitude, longitude: Of the origin, degrees, WGS 84.
        heading_deg: Of the x axis, clockwise from true north; 90 is east. y is to its left.
    """

    latitude: float
    longitude: float
    heading_deg: float = 0.0

    def __post_init__(self) -> None:
        for value, most in (
            (self.latitude, POLAR_DEG),
            (self.longitude, HALF_TURN_DEG),
            (self.heading_deg, 2 * HALF_TURN_DEG),
        ):
            if not isfinite(value) or abs(value) > most:
                raise ValueError("a frame lies between 85 degrees south and north, as numbers")


def local_m(frame: GeographicFrame, latitude: float, longitude: float) -> tuple[float, float]:
    """Return x and y of a place in a robot's frame, in metres (REP 103: x ahead, y to the left).

    Raises:
        OutsidePlane: It is no place, or more than 10 km away.
    """
    if not (isfinite(latitude) and isfinite(longitude)):
        raise OutsidePlane
    x0, y0, z0 = _geocentric_m(frame.latitude, frame.longitude)
    x, y, z = _geocentric_m(latitude, longitude)
    dx, dy, dz = x - x0, y - y0, z - z0
    phi, lam = radians(frame.latitude), radians(frame.longitude)
    outward = dx * cos(lam) + dy * sin(lam)
    east = dy * cos(lam) - dx * sin(lam)
    north = dz * cos(phi) - outward * sin(phi)
    up = dz * sin(phi) + outward * cos(phi)
    if hypot(north, east, up) > FARTHEST_M:
        raise OutsidePlane
    heading = radians(frame.heading_deg)
    return (
        north * cos(heading) + east * sin(heading),
        north * sin(heading) - east * cos(heading),
    )


def _geocentric_m(latitude: float, longitude: float) -> tuple[float, float, float]:
    phi, lam = radians(latitude), radians(longitude)
    normal = _RADIUS_M / sqrt(1 - _E2 * sin(phi) ** 2)
    return (
        normal * cos(phi) * cos(lam),
        normal * cos(phi) * sin(lam),
        normal * (1 - _E2) * sin(phi),
    )
