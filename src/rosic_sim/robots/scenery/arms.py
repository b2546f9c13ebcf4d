"""The bodies of the two robots on tables: an LBR iiwa and a YuMi."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin, sqrt
from types import MappingProxyType
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
from rosic_sim.robots.scenery.places import ScenePlace

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.view import Solid
    from rosic_sim.robots.machines.crazyflie import Crazyflie
    from rosic_sim.robots.machines.kuka import Kuka
    from rosic_sim.robots.machines.objects import SimulatedObject
    from rosic_sim.robots.machines.omni import Omni
    from rosic_sim.robots.machines.yumi import Yumi


# ---- movers ----

# The bodies of the robots that go somewhere: a mobile manipulator and drones.

CHASSIS: Colour = (62, 68, 77)
DECK: Colour = (243, 128, 36)
TYRE: Colour = (38, 41, 46)
HUB: Colour = (170, 176, 184)
LIMB: Colour = (247, 140, 46)
JOINT: Colour = (66, 71, 79)
BOARD: Colour = (34, 38, 44)
MOTOR: Colour = (120, 126, 134)
BLADE: Colour = (184, 192, 202)
LAMPS: Mapping[str, Colour] = MappingProxyType(
    {"cf1": (214, 62, 62), "cf2": (40, 160, 96), "cf3": (46, 108, 220)}
)
LAMP: Colour = (230, 170, 40)
# KUKA youBot: 580 x 380 mm, wheels of 100 mm; the arm's links, and where it stands.
WHEELS = tuple((x, y) for x in (0.235, -0.235) for y in (0.165, -0.165))
LINKS_M = (0.155, 0.135, 0.19)
MAST: Point = (0.14, 0.0, 0.14)


def omni_body(omni: Omni, room: ScenePlace) -> list[Solid]:
    """Return the base on its four wheels, and the arm on top."""
    x, y, _ = room.at((omni.base.x_m, omni.base.y_m, 0.0))
    place = ScenePlace(x, y, 0.0, room.yaw_rad + omni.base.yaw_rad)
    solids: list[Solid] = []
    for wheel_x, wheel_y in WHEELS:
        side = 1.0 if wheel_y > 0 else -1.0
        inner, outer = wheel_y - side * 0.03, wheel_y + side * 0.03
        ends = place.at((wheel_x, inner, 0.05)), place.at((wheel_x, outer, 0.05))
        solids.append(Tube(*ends, 0.05, TYRE))
        hub = place.at((wheel_x, outer + side * 0.004, 0.05))
        solids.append(Tube(ends[1], hub, 0.028, HUB))
    deck = Box(place.at((0.0, 0.0, 0.09)), (0.56, 0.27, 0.10), CHASSIS, place.yaw_rad, DECK)
    solids.append(deck)
    # A nose, so that one sees which way is forward.
    solids.append(Box(place.at((0.285, 0.0, 0.085)), (0.016, 0.18, 0.04), DECK, place.yaw_rad))
    return solids + _arm(omni.arm.positions, place)


def _arm(angles: tuple[float, ...], place: ScenePlace) -> list[Solid]:
    turned, *leans = angles[:4]
    x, y, z = MAST
    here = (x, y, z + 0.12)
    solids: list[Solid] = [
        Tube(place.at(MAST), place.at(here), 0.052, JOINT, 0.044),
        Ball(place.at(here), 0.046, DECK),
    ]
    lean = 0.0
    for index, (length, angle) in enumerate(zip(LINKS_M, leans, strict=True)):
        lean += angle
        reach, rise = sin(lean) * length, cos(lean) * length
        there = (here[0] + reach * cos(turned), here[1] + reach * sin(turned), here[2] + rise)
        radius = 0.034 - 0.006 * index
        solids.append(Tube(place.at(here), place.at(there), radius, LIMB, radius * 0.85))
        if index < len(LINKS_M) - 1:
            solids.append(Ball(place.at(there), radius * 1.15, JOINT))
        here = there
    solids.append(Ball(place.at(here), 0.018, JOINT))
    return solids


def drone_body(drone: Crazyflie, room: ScenePlace, larger: float = 1.0) -> list[Solid]:
    """Return a drone; in a whole room it is drawn larger than life, or nobody would find it."""
    flight = drone.flight
    x, y, z = room.at((flight.x_m, flight.y_m, flight.height.position))
    place = ScenePlace(x, y, z, room.yaw_rad)
    flying = not drone.at_rest()

    def at(ahead: float, left: float, up: float) -> Point:
        return place.at((ahead * larger, left * larger, up * larger))

    lamp = LAMPS.get(drone.id, LAMP)
    solids: list[Solid] = [
        Box(at(0, 0, 0.014), (0.034 * larger, 0.03 * larger, 0.012 * larger), BOARD, place.yaw_rad),
        Box(at(0, 0, 0.024), (0.026 * larger, 0.02 * larger, 0.008 * larger), HUB, place.yaw_rad),
        Ball(at(0.02, 0, 0.018), 0.006 * larger, lamp),
    ]
    for index in range(4):
        angle = pi / 4 + index * pi / 2
        x, y = 0.046 * cos(angle), 0.046 * sin(angle)
        solids += [
            Tube(at(0, 0, 0.014), at(x, y, 0.014), 0.004 * larger, lamp),
            Tube(at(x, y, 0.0), at(x, y, 0.026), 0.005 * larger, MOTOR),
        ]
        if flying:
            solids.append(Tube(at(x, y, 0.027), at(x, y, 0.029), 0.0235 * larger, BLADE))
        else:
            c, s = 0.022 * cos(angle + 1), 0.022 * sin(angle + 1)
            solids.append(
                Tube(at(x - c, y - s, 0.028), at(x + c, y + s, 0.028), 0.003 * larger, BLADE)
            )
    return solids


# ---- arms ----

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
