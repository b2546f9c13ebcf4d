"""The picture at the end of a play: where its robots went, or the robot that stayed in place."""

from __future__ import annotations

from math import dist
from typing import TYPE_CHECKING, Final

from rosic.core.message import Attachment
from rosic.core.robot.view import PathsView, PathView, Pose
from rosic_sim.robots.scenery.scene import robot_scene

if TYPE_CHECKING:
    from rosic.app.gateway import Gateway
    from rosic.contracts.renderer import Renderer
    from rosic.core.robot.view import Subject
    from rosic_sim.robots.theatre import SimulationLoop

LEAST_M: Final = 0.02
"""Shorter steps are not kept: a way of a minute has some hundred points then."""
WENT_M: Final = 0.05
"""Who stayed within so much of their beginning went nowhere."""


class RobotPaths:
    """Follows the robots of a play while the world is stepped.

    Args:
        gateway: Whose robots they are.
        theatre: Of the world that they move in.
    """

    def __init__(self, gateway: Gateway, theatre: SimulationLoop) -> None:
        self._gateway = gateway
        self._theatre = theatre
        self._points: dict[str, list[Pose]] = {}
        theatre.watch(self._look)

    def close(self) -> None:
        """Follow them no more."""
        self._theatre.forget(self._look)

    def _look(self) -> None:
        for robot, profile in self._gateway.rooms.profiles.items():
            if profile.pose is None:
                continue
            pose = self._gateway.rooms.linker.presence(robot).pose
            points = self._points.setdefault(robot, [])
            if pose is not None and (not points or _apart_m(points[-1], pose) >= LEAST_M):
                points.append(pose)

    def subject(self, title: str) -> Subject:
        """Return what there is to draw: the ways, or the first robot where none went anywhere."""
        profiles = self._gateway.rooms.profiles
        ways = tuple(
            PathView(profiles[robot].shown, tuple(points))
            for robot, points in self._points.items()
            if max((_apart_m(points[0], pose) for pose in points), default=0.0) > WENT_M
        )
        return (
            PathsView(title, ways)
            if ways
            else robot_scene(self._theatre.world, next(iter(profiles)))
        )

    def picture(self, title: str, name: str, draw: Renderer) -> Attachment:
        """Return the picture as a file.

        Args:
            title: What stands over it.
            name: Of the file, without its ending.
            draw: Who draws it.
        """
        drawing = draw(self.subject(title))
        ending = drawing.media_type.rpartition("/")[2].replace("jpeg", "jpg")
        return Attachment(f"{name}.{ending}", drawing.media_type, drawing.content)


def _apart_m(one: Pose, other: Pose) -> float:
    return dist((one.x_m, one.y_m, one.z_m), (other.x_m, other.y_m, other.z_m))
