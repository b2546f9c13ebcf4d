"""What a simulated robot tells of itself: odometry, joints, battery, in the standard messages."""

from __future__ import annotations

from abc import ABC, abstractmethod
from array import array
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from importlib import import_module
from math import cos, sin
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.robot.view import Scene
from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.machines.field_robots import FireWatcher
from rosic_sim.robots.machines.kuka import Kuka
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.yumi import Yumi
from rosic_sim.robots.scenery.places import plan_of
from rosic_sim.robots.scenery.scene import robot_scene
from rosic_sim.ros2.endpoints import publisher

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.stepped_machine import SteppedMachine
    from rosic_sim.robots.machines.world import SimulatedWorld


# ---- views ----

# What a simulated robot lets others see: camera frames while somebody subscribes, and its map.

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


# ---- reports ----

MOVING_EVERY_S = 0.02
AT_REST_EVERY_S = 0.1
BATTERY_EVERY_S = 0.2


class TelemetryPublisher:
    """Publishes at 50 Hz while the machine moves and at 10 Hz at rest; batteries at 5 Hz."""

    def __init__(self, node: RosObject, machine: SteppedMachine) -> None:
        self._machine = machine
        self._parts = _parts_of(node, machine)
        self._battery = None if machine.battery is None else _Battery(node)
        self._told_s = self._battery_told_s = float("-inf")

    def due(self, now_s: float) -> bool:
        """Tell whether it is time again."""
        machine = self._machine  # one that waits for a common start does not move yet
        at_work = machine.moving and now_s >= machine.start_s
        every = MOVING_EVERY_S if at_work else AT_REST_EVERY_S
        return now_s - self._told_s >= every - 1e-3

    def publish(self, now_s: float, stamp: RosObject) -> None:
        """Tell the newest measurements."""
        self._told_s = now_s
        for part in self._parts:
            part.publish(stamp)
        battery = self._machine.battery
        if self._battery is None or battery is None:
            return
        if now_s - self._battery_told_s >= BATTERY_EVERY_S:
            self._battery_told_s = now_s
            self._battery.publish(stamp, battery.fraction)


class _Part(ABC):
    @abstractmethod
    def publish(self, stamp: RosObject) -> None:
        """Publish one message."""


class _BaseOdometry(_Part):
    """The base in the odometry frame; velocities in the base's own."""

    def __init__(self, node: RosObject, machine: Omni) -> None:
        self._base = machine.base
        self._publisher = _odometry(node)
        self._frames = (f"{machine.id}/odom", f"{machine.id}/base_link")

    def publish(self, stamp: RosObject) -> None:
        message = _new_odometry(stamp, self._frames)
        base, pose, twist = self._base, message.pose.pose, message.twist.twist
        pose.position.x, pose.position.y = base.x_m, base.y_m
        pose.orientation.z, pose.orientation.w = sin(base.yaw_rad / 2), cos(base.yaw_rad / 2)
        twist.linear.x, twist.linear.y = base.velocity.x_m_s, base.velocity.y_m_s
        twist.angular.z = base.velocity.yaw_rad_s
        self._publisher.publish(message)


class _Heat(_Part):
    """How warm the air is, as a watcher's sensor has it."""

    def __init__(self, node: RosObject, machine: FireWatcher) -> None:
        self._type = import_module("sensor_msgs.msg").Temperature
        self._publisher = publisher(node, self._type, "heat")
        self._machine = machine

    def publish(self, stamp: RosObject) -> None:
        message = self._type(temperature=self._machine.heat_c())
        message.header.stamp = stamp
        self._publisher.publish(message)


class _FlightOdometry(_Part):
    """The drone in the room; it never turns, so both frames point the same way."""

    def __init__(self, node: RosObject, machine: Crazyflie) -> None:
        self._flight = machine.flight
        self._publisher = _odometry(node)
        self._frames = ("map", f"{machine.id}/base_link")

    def publish(self, stamp: RosObject) -> None:
        message = _new_odometry(stamp, self._frames)
        flight, place = self._flight, message.pose.pose.position
        place.x, place.y, place.z = flight.x_m, flight.y_m, flight.height.position
        message.pose.pose.orientation.w = 1.0
        speed = message.twist.twist.linear
        speed.x, speed.y, speed.z = flight.vx_m_s, flight.vy_m_s, flight.height.velocity
        self._publisher.publish(message)


class _Joints(_Part):
    """Names, positions and velocities of all joints, fingers included."""

    def __init__(self, node: RosObject, machine: Omni | Kuka | Yumi) -> None:
        self._type = import_module("sensor_msgs.msg").JointState
        self._publisher = publisher(node, self._type, "joint_states")
        self._machine = machine

    def publish(self, stamp: RosObject) -> None:
        names, positions, speeds = _joints(self._machine)
        message = self._type(name=names)
        message.header.stamp = stamp
        message.position, message.velocity = list(positions), list(speeds)
        self._publisher.publish(message)


class _Battery:
    def __init__(self, node: RosObject) -> None:
        self._type = import_module("sensor_msgs.msg").BatteryState
        self._publisher = publisher(node, self._type, "battery")

    def publish(self, stamp: RosObject, fraction: float) -> None:
        message = self._type(percentage=float(fraction), present=True)
        message.header.stamp = stamp
        self._publisher.publish(message)


def _parts_of(node: RosObject, machine: SteppedMachine) -> list[_Part]:
    if isinstance(machine, FireWatcher):
        return [_BaseOdometry(node, machine), _Joints(node, machine), _Heat(node, machine)]
    if isinstance(machine, Omni):
        return [_BaseOdometry(node, machine), _Joints(node, machine)]
    if isinstance(machine, Crazyflie):
        return [_FlightOdometry(node, machine)]
    assert isinstance(machine, (Kuka, Yumi))  # noqa: S101 - there are no others
    return [_Joints(node, machine)]


def _joints(machine: Omni | Kuka | Yumi) -> tuple[list[str], Sequence[float], Sequence[float]]:
    if isinstance(machine, Yumi):
        arms = machine.arms
        count = len(arms.positions) // 2
        names = [f"{side}_joint_{i}" for side in ("left", "right") for i in range(1, count + 1)]
        grippers = {f"{side}_finger": gripper for side, gripper in machine.grippers.items()}
    else:
        arms = machine.arm
        names = [f"joint_{index}" for index, _ in enumerate(arms.positions, 1)]
        grippers = {"finger": machine.gripper} if isinstance(machine, Kuka) else {}
    return (
        [*names, *grippers],
        [*arms.positions, *(gripper.width_m for gripper in grippers.values())],
        [*arms.velocities, *(gripper.speed_m_s for gripper in grippers.values())],
    )


def _odometry(node: RosObject) -> RosObject:
    return publisher(node, import_module("nav_msgs.msg").Odometry, "odom")


def _new_odometry(stamp: RosObject, frames: tuple[str, str]) -> RosObject:
    message = import_module("nav_msgs.msg").Odometry(child_frame_id=frames[1])
    message.header.stamp, message.header.frame_id = stamp, frames[0]
    return message
