"""The bodies of the robots that go somewhere: a mobile manipulator and drones."""

from __future__ import annotations

from math import cos, pi, sin
from types import MappingProxyType
from typing import TYPE_CHECKING

from rosic.core.robot.view import Ball, Box, Colour, Point, Tube
from rosic_sim.robots.scenery.places import ScenePlace

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.view import Solid
    from rosic_sim.robots.machines.crazyflie import Crazyflie
    from rosic_sim.robots.machines.omni import Omni

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
