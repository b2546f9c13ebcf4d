"""Scenes: one robot from close by, or the whole room."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.robot.view import Ball, Label, Point, Scene
from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.machines.field_robots import FireWatcher
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.world import CUBE, PART
from rosic_sim.robots.scenery.arms import drone_body, iiwa, omni_body, yumi_body
from rosic_sim.robots.scenery.places import FLOOR, place_of, table_of, walls

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.core.robot.view import Colour, Solid
    from rosic_sim.robots.machines.world import SimulatedWorld

LARGER = 2.6
ROOM_EYE: Point = (0.35, -4.85, 2.05)
ROOM_TARGET: Point = (0.02, -0.1, 0.50)
ROOM_ANGLE_RAD = 0.52
FIELD_M = 6.0
EMBER: Colour = (236, 96, 28)
EMBER_M = 0.16


def robot_scene(world: SimulatedWorld, robot: str) -> Scene:
    """Return one robot from close by, alone: whoever may see it may not see the others yet."""
    solids = tuple(_body(world, robot))
    eye, target, angle_rad = _camera(world, robot)
    if isinstance(world.machines[robot], Crazyflie | Omni):
        x, y, _ = target
        floor = (x - FIELD_M / 2, y - FIELD_M / 2, x + FIELD_M / 2, y + FIELD_M)
        return Scene(solids, eye, target, angle_rad, floor)
    return Scene(solids, eye, target, angle_rad, FLOOR, backdrop=(*walls(), *table_of(robot)))


def room_scene(world: SimulatedWorld, shown: Mapping[str, str] | None = None) -> Scene:
    """Return all robots in their room.

    Args:
        world: Where they are.
        shown: What is written over them, by robot; the drones share what is written over the
            first of them.
    """
    backdrop: list[Solid] = [*walls()]
    solids: list[Solid] = []
    labels = []
    for robot in world.machines:
        backdrop += table_of(robot)
        solids += _body(world, robot, LARGER)
        if shown and robot in shown:
            labels.append(Label(shown[robot], _above(world, robot)))
    return Scene(
        tuple(solids), ROOM_EYE, ROOM_TARGET, ROOM_ANGLE_RAD, FLOOR, tuple(labels), tuple(backdrop)
    )


def _body(world: SimulatedWorld, robot: str, larger: float = 1.0) -> list[Solid]:
    place = place_of(robot)
    machine = world.machines[robot]
    if isinstance(machine, Omni):
        burning = machine.hearths if isinstance(machine, FireWatcher) else ()
        embers = [
            Ball(place.at((hearth.x_m, hearth.y_m, EMBER_M)), EMBER_M, EMBER) for hearth in burning
        ]
        return [*omni_body(machine, place), *embers]
    if machine is world.kuka:
        return iiwa(world.kuka, world.things.get(CUBE), place)
    if machine is world.yumi:
        return yumi_body(world.yumi, world.things.get(PART), place)
    assert isinstance(machine, Crazyflie)  # noqa: S101 - there are no others
    return drone_body(machine, place, larger)


def _camera(world: SimulatedWorld, robot: str) -> tuple[Point, Point, float]:
    """Return eye, target and angle for one robot."""
    x, y, z = place_of(robot).at((0.0, 0.0, 0.0))
    machine = world.machines[robot]
    if isinstance(machine, Omni):
        x, y, _ = place_of(robot).at((machine.base.x_m, machine.base.y_m, 0.0))
        return (x + 0.75, y - 1.35, 0.95), (x, y, 0.16), 0.62
    if machine is world.kuka:
        return (x + 0.75, y - 2.35, z + 0.7), (x + 0.26, y - 0.16, z + 0.26), 0.60
    if machine is world.yumi:
        return (x + 0.55, y - 2.25, z + 0.85), (x, y - 0.2, z + 0.18), 0.56
    assert isinstance(machine, Crazyflie)  # noqa: S101 - there are no others
    flight = machine.flight
    x, y, z = place_of(robot).at((flight.x_m, flight.y_m, flight.height.position))
    return (x + 0.20, y - 0.50, z + 0.26), (x, y, z - 0.01), 0.46


def _above(world: SimulatedWorld, robot: str) -> Point:
    """Return where a robot's name stands."""
    x, y, z = place_of(robot).at((0.0, 0.0, 0.0))
    machine = world.machines[robot]
    if isinstance(machine, Omni):
        x, y, _ = place_of(robot).at((machine.base.x_m, machine.base.y_m, 0.0))
        return x, y, 0.62
    if isinstance(machine, Crazyflie):
        flight = machine.flight
        x, y, z = place_of(robot).at((flight.x_m, flight.y_m, flight.height.position))
        return x, y, z + 0.32
    return x, y, z + (0.95 if machine is world.kuka else 0.72)
