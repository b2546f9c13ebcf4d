"""What a simulated robot lets others see: camera frames while somebody subscribes, and its map."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from importlib import import_module
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.robot.view import Scene
from rosic_sim.robots.scenery.plan import plan_of
from rosic_sim.robots.scenery.scene import robot_scene
from rosic_sim.ros2.endpoints import publisher

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.omni import Omni
    from rosic_sim.robots.machines.world import SimulatedWorld

EVERY_S = 0.25
CAMERA, MAP = "camera/compressed", "map"

DrawJpeg: TypeAlias = Callable[[Scene], bytes]
"""Makes a JPEG of a scene; called on a thread of its own."""


class SceneCamera:
    """A camera that looks at one robot: four frames a second while somebody subscribes.

    Drawing takes longer than a step of the machine, so it is left to another thread.
    """

    def __init__(self, node: RosObject, robot: str, world: SimulatedWorld, draw: DrawJpeg) -> None:
        self._type = import_module("sensor_msgs.msg").CompressedImage
        self._publisher = publisher(node, self._type, CAMERA, 1)
        self._robot = robot
        self._world = world
        self._draw = draw
        self._thread = ThreadPoolExecutor(1, f"camera of {robot}")
        self._drawn: Future[bytes] | None = None
        self._stamp: RosObject = None
        self._due_s = float("-inf")

    def turn(self, now_s: float, stamp: RosObject) -> None:
        """Send what was drawn, and have the next frame drawn if it is time."""
        if self._drawn is not None:
            if not self._drawn.done():
                return
            message = self._type(format="jpeg", data=array("B", self._drawn.result()))
            message.header.stamp, message.header.frame_id = self._stamp, f"{self._robot}/camera"
            self._drawn = None
            self._publisher.publish(message)
        if now_s >= self._due_s and self._publisher.get_subscription_count():
            self._due_s, self._stamp = now_s + EVERY_S, stamp
            scene = robot_scene(self._world, self._robot)
            self._drawn = self._thread.submit(self._draw, scene)

    def close(self) -> None:
        """Draw no more."""
        self._thread.shutdown(cancel_futures=True)


def publish_map(node: RosObject, omni: Omni, qos: RosObject) -> RosObject:
    """Publish the room once, kept for whoever comes later; return what has to be kept alive."""
    grids = import_module("nav_msgs.msg")
    latched = qos.QoSProfile(
        depth=1,
        reliability=qos.ReliabilityPolicy.RELIABLE,
        durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
    )
    keeper = publisher(node, grids.OccupancyGrid, MAP, latched)
    grid = plan_of(omni)
    message = grids.OccupancyGrid(data=array("b", grid.cells))
    message.header.stamp = node.get_clock().now().to_msg()
    # The simulated base knows where it is exactly: its odometry is its place on the map.
    message.header.frame_id = f"{omni.id}/odom"
    message.info.width, message.info.height = grid.width, grid.height
    message.info.resolution = grid.resolution_m
    message.info.origin.position.x = grid.origin.x_m
    message.info.origin.position.y = grid.origin.y_m
    keeper.publish(message)
    return keeper
