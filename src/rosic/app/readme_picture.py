"""The picture of the simulated robots in the README, drawn from a short play.

``python -m rosic.app.readme_picture`` draws it anew.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rosic.rendering.draw import portrait
from rosic_sim.robots.machines.world import SimulatedWorld, build_world
from rosic_sim.robots.scenery.scene import room_scene

if TYPE_CHECKING:
    from rosic.core.robot.view import Drawing
    from rosic_sim.robots.machines.arguments import Value

FILE = "docs/pictures/robots.png"
NAMES = {"omni": "omni", "kuka1": "KUKA iiwa", "yumi": "YuMi", "cf1": "Crazyflies"}
STEP_S = 0.02
TAKEN_S = 7.4
HEIGHTS_M = {"cf1": 1.0, "cf2": 0.8, "cf3": 0.9}
# When each begins, so that all of them are at work when the picture is taken.
PLAY: tuple[tuple[float, str, str, dict[str, Value]], ...] = (
    (0.0, "omni", "move", {"direction": "forward", "distance_m": 0.4, "speed_m_s": 0.4}),
    (3.1, "cf1", "formation", {"shape": "triangle", "spacing_m": 0.75}),
    (3.1, "cf2", "formation", {"shape": "triangle", "spacing_m": 0.75}),
    (3.1, "cf3", "formation", {"shape": "triangle", "spacing_m": 0.75}),
    (3.6, "yumi", "handover", {}),
    (3.9, "kuka1", "grasp", {"force_n": 20.0}),
    (5.6, "omni", "arm", {"pose": "carry"}),
)


def played() -> SimulatedWorld:
    """Return the world at the moment of the picture; always the same."""
    world = build_world()
    world.step(0.0)
    for drone in world.drones:
        drone.begin("takeoff", {"height_m": HEIGHTS_M[drone.id]}, 0.0)
    waiting = list(PLAY)
    for step in range(round(TAKEN_S / STEP_S) + 1):
        now_s = step * STEP_S
        world.step(now_s)
        while waiting and waiting[0][0] <= now_s:
            _, robot, skill, arguments = waiting.pop(0)
            world.machines[robot].begin(skill, arguments, now_s)
    return world


def robots() -> Drawing:
    """Draw the picture."""
    return portrait(room_scene(played(), NAMES), 1280, 640)


def main(file: Path) -> None:
    """Write the picture."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(robots().content)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else FILE))
