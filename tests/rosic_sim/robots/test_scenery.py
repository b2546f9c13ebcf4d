"""What simulated robots show: themselves alone, as they stand; and the picture in the README."""

from __future__ import annotations

import io
from contextlib import aclosing
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from PIL import Image, ImageChops, ImageStat

from rosic.app.readme_picture import FILE, played, robots
from rosic.config.profiles import load_profile, shipped_profiles
from rosic.core.order_gate import OrderGate
from rosic.core.robot.view import Box, OccupancyMap, Scene, Tube, View, ViewKind
from rosic.errors import NothingToSee
from rosic.rendering.draw import draw
from rosic.testing.clock import ManualClock
from rosic_sim.robots.machines.world import build_world
from rosic_sim.robots.robot import SimulatedRobot
from rosic_sim.robots.scenery.arms import CUBE, PART
from rosic_sim.robots.scenery.places import plan_of
from rosic_sim.robots.scenery.scene import robot_scene, room_scene

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

ROOT = Path(__file__).parents[3]
ROBOTS = ("omni", "kuka1", "yumi", "cf1", "cf2", "cf3")
TOLERANCE = 1.0  # of 255, on average: fonts and rounding may differ a little between versions


def simulated(name: str) -> Profile:
    return load_profile(shipped_profiles()[name], link="simulated")


async def first(robot: SimulatedRobot, sight: ViewKind) -> View:
    async with aclosing(robot.look(sight)) as views:
        return await anext(views)


@pytest.mark.parametrize("name", ROBOTS)
async def test_every_robot_can_be_looked_at(name: str) -> None:
    clock = ManualClock()
    robot = SimulatedRobot(simulated(name), OrderGate.new(name), clock)
    view = await first(robot, ViewKind.PICTURE)
    assert isinstance(view.content, Scene)
    assert view.taken_ns == clock.monotonic_ns()
    assert not view.foreign
    assert draw(view.content, low=True).media_type == "image/jpeg"


async def test_only_the_omni_has_a_map() -> None:
    clock = ManualClock()
    view = await first(
        SimulatedRobot(simulated("omni"), OrderGate.new("omni"), clock), ViewKind.MAP
    )
    assert isinstance(view.content, OccupancyMap)
    with pytest.raises(NothingToSee):
        await first(SimulatedRobot(simulated("kuka1"), OrderGate.new("kuka1"), clock), ViewKind.MAP)


def test_a_robot_is_shown_alone() -> None:
    world = build_world()
    alone = [robot_scene(world, name).solids for name in ROBOTS]
    together = room_scene(world).solids
    assert sum(map(len, alone)) == len(together)
    for mine in alone:
        assert not any(mine is not other and set(mine) & set(other) for other in alone)


def test_it_is_shown_as_it_stands() -> None:
    world = build_world()
    world.step(0.0)
    before = {name: robot_scene(world, name) for name in ROBOTS}
    world.omni.begin("move", {"direction": "forward", "distance_m": 0.2}, 0.0)
    world.step(5.0)
    assert robot_scene(world, "omni") != before["omni"]
    assert robot_scene(world, "kuka1") == before["kuka1"]


def test_what_is_held_is_shown_in_the_hand() -> None:
    world = played()
    cube = next(s for s in robot_scene(world, "kuka1").solids if s.colour == CUBE)
    assert isinstance(cube, Box)
    assert cube.centre[2] > 0.62 + 0.06  # lifted from its table
    part = next(s for s in robot_scene(world, "yumi").solids if s.colour == PART)
    assert isinstance(part, Tube)
    world.remove_thing("cube")
    assert not [s for s in robot_scene(world, "kuka1").solids if s.colour == CUBE]


def test_the_map_has_walls_and_the_robot_stands_on_it_where_it_is_free() -> None:
    omni = build_world().omni
    grid = plan_of(omni)
    assert len(grid.cells) == grid.width * grid.height
    assert set(grid.cells[: grid.width]) == {100}
    column = round((omni.base.x_m - grid.origin.x_m) / grid.resolution_m)
    row = round((omni.base.y_m - grid.origin.y_m) / grid.resolution_m)
    assert grid.cells[row * grid.width + column] == 0
    assert grid.pose is not None


def test_the_picture_in_the_readme_is_what_would_be_drawn_now() -> None:
    stored = (ROOT / FILE).read_bytes()
    assert len(stored) < 150_000
    shown = Image.open(io.BytesIO(stored)).convert("RGB")
    drawn = Image.open(io.BytesIO(robots().content)).convert("RGB")
    assert shown.size == drawn.size
    apart = ImageStat.Stat(ImageChops.difference(shown, drawn)).mean
    assert max(apart) < TOLERANCE, "run: python -m rosic.app.readme_picture"
    assert f"({FILE})" in (ROOT / "README.md").read_text("utf-8")
