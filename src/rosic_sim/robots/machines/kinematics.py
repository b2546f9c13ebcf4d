"""Where tools are: forward kinematics of joint chains, and the iiwa's inverse for a tool down."""

from __future__ import annotations

from functools import lru_cache
from math import acos, atan2, cos, hypot, pi, sin
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from collections.abc import Sequence

Vector: TypeAlias = tuple[float, float, float]
Matrix: TypeAlias = tuple[Vector, Vector, Vector]

KEPT = 64
"""Postures of which the points are remembered: an arm at rest is asked again and again."""

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class KinematicLink(NamedTuple):
    """A revolute joint: where its frame sits in the one before; it turns about its z axis."""

    offset_m: Vector
    turned: Matrix


def rotation(roll: float, pitch: float, yaw: float) -> Matrix:
    """Return the matrix of fixed-axis angles, as in a robot description (URDF)."""
    cr, sr, cp, sp, cy, sy = cos(roll), sin(roll), cos(pitch), sin(pitch), cos(yaw), sin(yaw)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def product(a: Matrix, b: Matrix) -> Matrix:
    """Multiply two matrices."""
    (r, s, t), (u, v, w), (x, y, z) = b
    rows = [(i * r + j * u + k * x, i * s + j * v + k * y, i * t + j * w + k * z) for i, j, k in a]
    return (rows[0], rows[1], rows[2])


def moved(origin: Vector, turned: Matrix, offset: Vector) -> Vector:
    """Return ``origin + turned * offset``."""
    x, y, z = offset
    points = [o + i * x + j * y + k * z for o, (i, j, k) in zip(origin, turned, strict=True)]
    return (points[0], points[1], points[2])


def about_z(turned: Matrix, angle: float) -> Matrix:
    """Return ``turned`` after a further rotation about its own z axis."""
    c, s = cos(angle), sin(angle)
    rows = [(i * c + j * s, j * c - i * s, k) for i, j, k in turned]
    return (rows[0], rows[1], rows[2])


def chain(
    links: Sequence[KinematicLink], angles: Sequence[float], tool_m: float
) -> tuple[Vector, ...]:
    """Return the origins of all joints, then the tool's tip, in the base frame.

    Args:
        links: In order from the base.
        angles: One per link, rad.
        tool_m: From the last joint's origin along its z axis to the tip.
    """
    origin: Vector = (0.0, 0.0, 0.0)
    turned = IDENTITY
    points = []
    for link, angle in zip(links, angles, strict=True):
        origin = moved(origin, turned, link.offset_m)
        turned = about_z(product(turned, link.turned), angle)
        points.append(origin)
    points.append(moved(origin, turned, (0.0, 0.0, tool_m)))
    return tuple(points)


# LBR iiwa 7 R800: 340 mm to the shoulder, 400 mm to the elbow, 400 mm to the wrist, 126 mm to the
# flange (KUKA "LBR iiwa 7 R800, LBR iiwa 14 R820 Specification", working envelope).
IIWA_SHOULDER_M = 0.340
IIWA_UPPER_M = 0.400
IIWA_LOWER_M = 0.400
IIWA_FLANGE_M = 0.126
# Assumed: a parallel gripper whose finger tips are 150 mm from the flange.
IIWA_TOOL_M = IIWA_FLANGE_M + 0.150

# A2, A4 and A6 turn about y, -y and y when all angles are zero (arm straight up).
_UP_TO_Y = rotation(-pi / 2, 0.0, 0.0)
_Y_TO_UP = rotation(pi / 2, 0.0, 0.0)
_NONE: Vector = (0.0, 0.0, 0.0)
IIWA_CHAIN = (
    KinematicLink((0.0, 0.0, IIWA_SHOULDER_M), IDENTITY),
    KinematicLink(_NONE, _UP_TO_Y),
    KinematicLink((0.0, -IIWA_UPPER_M, 0.0), _Y_TO_UP),
    KinematicLink(_NONE, _Y_TO_UP),
    KinematicLink((0.0, IIWA_LOWER_M, 0.0), _UP_TO_Y),
    KinematicLink(_NONE, _UP_TO_Y),
    KinematicLink(_NONE, _Y_TO_UP),
)


@lru_cache(maxsize=KEPT)
def iiwa_points(angles: tuple[float, ...]) -> tuple[Vector, Vector, Vector]:
    """Return elbow, wrist and finger tips of the iiwa in its base frame."""
    points = chain(IIWA_CHAIN, angles, IIWA_TOOL_M)
    return points[2], points[4], points[-1]


def iiwa_tool_down(x_m: float, y_m: float, z_m: float) -> tuple[float, ...] | None:
    """Return joint angles that put the finger tips at a point, pointing down, elbow up.

    Returns:
        Seven angles, or None when the point is out of the links' reach. Ranges are not checked.
    """
    radius = hypot(x_m, y_m)
    height = z_m + IIWA_TOOL_M - IIWA_SHOULDER_M
    way = hypot(radius, height)
    if not abs(IIWA_UPPER_M - IIWA_LOWER_M) < way < IIWA_UPPER_M + IIWA_LOWER_M:
        return None
    square = way * way
    upper, lower = IIWA_UPPER_M, IIWA_LOWER_M
    at_shoulder = acos((square + upper * upper - lower * lower) / (2.0 * upper * way))
    at_elbow = pi - acos((upper * upper + lower * lower - square) / (2.0 * upper * lower))
    shoulder = atan2(radius, height) - at_shoulder
    # Leaning by A2 - A4 to the wrist; A6 adds what is missing to straight down.
    wrist = pi - shoulder - at_elbow
    return (atan2(y_m, x_m), shoulder, 0.0, -at_elbow, 0.0, wrist, 0.0)


# ABB YuMi (IRB 14000): joint frames of the public robot description that follows ABB's "Product
# specification IRB 14000", in the order of the chain, which ABB numbers 1, 2, 7, 3, 4, 5, 6.
_TURN = pi / 2
_YUMI_ARM = (
    KinematicLink((0.03, 0.0, 0.1), rotation(_TURN, 0.0, 0.0)),
    KinematicLink((-0.03, 0.17283, 0.0), rotation(-_TURN, 0.0, 0.0)),
    KinematicLink((-0.04188, 0.0, 0.07873), rotation(_TURN, -_TURN, 0.0)),
    KinematicLink((0.0405, 0.16461, 0.0), rotation(-_TURN, 0.0, 0.0)),
    KinematicLink((-0.027, 0.0, 0.10039), rotation(_TURN, 0.0, 0.0)),
    KinematicLink((0.027, 0.029, 0.0), rotation(-_TURN, 0.0, 0.0)),
)
YUMI_LEFT = (
    KinematicLink((0.05355, 0.0725, 0.41492), rotation(0.9781, -0.5716, 2.3180)),
    *_YUMI_ARM,
)
YUMI_RIGHT = (
    KinematicLink((0.05355, -0.0725, 0.41492), rotation(-0.9795, -0.5682, -2.3155)),
    *_YUMI_ARM,
)
# ABB "Product manual, grippers for IRB 14000": a servo gripper is about 0.136 m long.
YUMI_TOOL_M = 0.136


@lru_cache(maxsize=KEPT)
def yumi_points(angles: tuple[float, ...], *, left: bool) -> tuple[Vector, ...]:
    """Return joint origins and, last, the finger tips of one arm in the robot's base frame."""
    return chain(YUMI_LEFT if left else YUMI_RIGHT, angles, YUMI_TOOL_M)
