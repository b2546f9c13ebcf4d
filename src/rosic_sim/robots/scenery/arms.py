"""The bodies of the two robots on tables: an LBR iiwa and a YuMi."""

from __future__ import annotations

from itertools import pairwise
from math import sqrt
from typing import TYPE_CHECKING

from rosic.core.robot.view import Ball, Box, Colour, Point, Tube
from rosic_sim.robots.machines.kinematics import (
    IIWA_CHAIN,
    IIWA_FLANGE_M,
    IIWA_TOOL_M,
    YUMI_TOOL_M,
    chain,
    yumi_points,
)
from rosic_sim.robots.machines.yumi import JOINTS

if TYPE_CHECKING:
    from rosic.core.robot.view import Solid
    from rosic_sim.robots.machines.kuka import Kuka
    from rosic_sim.robots.machines.objects import SimulatedObject
    from rosic_sim.robots.machines.yumi import Yumi
    from rosic_sim.robots.scenery.places import ScenePlace

SILVER: Colour = (216, 219, 223)
ORANGE: Colour = (240, 122, 32)
DARK: Colour = (58, 63, 70)
FINGER: Colour = (92, 99, 108)
WHITE: Colour = (240, 241, 243)
PALE: Colour = (206, 211, 217)
CUBE: Colour = (205, 58, 62)
PART: Colour = (28, 148, 150)


def iiwa(kuka: Kuka, cube: SimulatedObject | None, place: ScenePlace) -> list[Solid]:
    """Return the arm, its gripper, and the cube where it is."""
    points = [place.at(p) for p in chain(IIWA_CHAIN, kuka.arm.positions, IIWA_TOOL_M)]
    base, shoulder, elbow, wrist, tip = (
        place.at((0.0, 0.0, 0.0)),
        points[1],
        points[2],
        points[4],
        points[7],
    )
    down = _direction(wrist, tip)
    flange = _along(wrist, down, IIWA_FLANGE_M)
    body: list[Solid] = [
        Tube(base, _along(base, (0.0, 0.0, 1.0), 0.05), 0.11, DARK),
        Tube(_along(base, (0.0, 0.0, 1.0), 0.05), shoulder, 0.092, SILVER, 0.075),
        Ball(shoulder, 0.088, ORANGE),
        *_bone(shoulder, elbow, 0.072, SILVER),
        Ball(elbow, 0.08, ORANGE),
        *_bone(elbow, wrist, 0.064, SILVER),
        Ball(wrist, 0.068, ORANGE),
        Tube(wrist, flange, 0.052, SILVER, 0.046),
    ]
    body += _gripper(flange, tip, kuka.gripper.width_m, 0.042)
    if cube is not None:
        held = kuka.gripper.name in cube.holders
        at = tip if held else place.at(cube.position_m)
        edge = cube.width_m
        body.append(Box(at, (edge, edge, edge), CUBE, place.yaw_rad))
    return body


def yumi_body(yumi: Yumi, part: SimulatedObject | None, place: ScenePlace) -> list[Solid]:
    """Return the trunk, both arms, and the part in whichever hand has it."""
    solids: list[Solid] = [
        Box(place.at((-0.06, 0.0, 0.02)), (0.26, 0.36, 0.04), DARK, place.yaw_rad),
        Tube(place.at((-0.06, 0.0, 0.04)), place.at((-0.03, 0.0, 0.30)), 0.125, WHITE, 0.135),
        Tube(place.at((-0.03, 0.0, 0.30)), place.at((0.01, 0.0, 0.45)), 0.135, WHITE, 0.085),
        Ball(place.at((0.01, 0.0, 0.445)), 0.084, PALE),
    ]
    tips: list[Point] = []
    for side in ("left", "right"):
        left = side == "left"
        angles = yumi.arms.positions[:JOINTS] if left else yumi.arms.positions[JOINTS:]
        points = [place.at(p) for p in yumi_points(angles, left=left)]
        solids += _yumi_arm(points, yumi.grippers["left" if left else "right"].width_m)
        holder = yumi.grippers["left" if left else "right"].name
        if part is not None and holder in part.holders:
            tips.append(points[-1])
    if tips:
        count = len(tips)
        x, y, z = (sum(tip[i] for tip in tips) / count for i in range(3))
        solids.append(Tube((x, y, z - 0.05), (x, y, z + 0.05), 0.016, PART))
    return solids


def _yumi_arm(points: list[Point], opening_m: float) -> list[Solid]:
    solids: list[Solid] = []
    bones = list(pairwise(points[:-1]))
    for index, (one, other) in enumerate(bones):
        radius = 0.058 - 0.004 * index
        solids += [Ball(one, radius * 1.08, WHITE if index % 2 else PALE)]
        solids += _bone(one, other, radius, WHITE)
    wrist, tip = points[-2], points[-1]
    solids.append(Ball(wrist, 0.038, PALE))
    return solids + _gripper(wrist, tip, opening_m, 0.028, YUMI_TOOL_M * 0.3)


def _bone(start: Point, end: Point, radius: float, colour: Colour) -> list[Solid]:
    return [Tube(start, end, radius, colour, radius * 0.93)]


def _gripper(
    flange: Point, tip: Point, opening_m: float, radius: float, gap_m: float = 0.0
) -> list[Solid]:
    """Return a hand between a flange and finger tips, and two fingers so far apart."""
    ahead = _direction(flange, tip)
    length = _distance(flange, tip)
    palm = _along(flange, ahead, gap_m + (length - gap_m) * 0.45)
    aside = _aside(ahead)
    solids: list[Solid] = [Tube(flange, palm, radius, DARK)]
    for sign in (1.0, -1.0):
        off = sign * (opening_m / 2 + radius * 0.28)
        start, end = _along(palm, aside, off), _along(tip, aside, off)
        solids.append(Tube(start, end, radius * 0.28, FINGER, radius * 0.2))
    return solids


def _aside(ahead: Point) -> Point:
    """Return a level direction across another one."""
    x, y, _ = ahead
    level = sqrt(x * x + y * y)
    return (1.0, 0.0, 0.0) if level < 1e-6 else (-y / level, x / level, 0.0)  # noqa: PLR2004


def _direction(start: Point, end: Point) -> Point:
    length = _distance(start, end) or 1.0
    x, y, z = ((b - a) / length for a, b in zip(start, end, strict=True))
    return x, y, z


def _distance(start: Point, end: Point) -> float:
    return sqrt(sum((b - a) ** 2 for a, b in zip(start, end, strict=True)))


def _along(start: Point, direction: Point, length: float) -> Point:
    x, y, z = (a + length * d for a, d in zip(start, direction, strict=True))
    return x, y, z
