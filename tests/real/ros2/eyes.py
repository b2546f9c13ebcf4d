"""A robot's eyes for tests: plain rclpy, none of ROSIC. Ends when its standard input ends.

Each line on standard input sends one message; see `Eyes`.
"""

from __future__ import annotations

import sys
import threading
from array import array
from importlib import import_module
from typing import Any, TypeAlias

RosObject: TypeAlias = Any

rclpy: Any = import_module("rclpy")
qos: Any = import_module("rclpy.qos")
sensor: Any = import_module("sensor_msgs.msg")
nav: Any = import_module("nav_msgs.msg")
geometry: Any = import_module("geometry_msgs.msg")
LATCHED = qos.QoSProfile(
    depth=1,
    reliability=qos.ReliabilityPolicy.RELIABLE,
    durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
)


def say(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


class Eyes:
    """Under /omni: a camera in two forms, a map that is sent once, a pose and a path."""

    def __init__(self, node: RosObject) -> None:
        self.node = node
        best = qos.qos_profile_sensor_data
        self.jpeg = node.create_publisher(sensor.CompressedImage, "jpeg", best)
        self.raw = node.create_publisher(sensor.Image, "raw", best)
        self.grid = node.create_publisher(nav.OccupancyGrid, "map", LATCHED)
        self.place = node.create_publisher(geometry.PoseStamped, "pose", 10)
        self.path = node.create_publisher(nav.Path, "path", LATCHED)
        self.stamped = True
        self.content = b"\xff\xd8\xff frame"
        node.create_timer(0.1, self.frames)

    def stamp(self, message: RosObject, frame: str) -> RosObject:
        message.header.frame_id = frame
        if self.stamped:
            message.header.stamp = self.node.get_clock().now().to_msg()
        else:
            message.header.stamp.sec = 12
        return message

    def frames(self) -> None:
        """Film, whether or not anybody looks."""
        say(f"watched {self.jpeg.get_subscription_count()} {self.raw.get_subscription_count()}")
        data = array("B", self.content)
        self.jpeg.publish(self.stamp(sensor.CompressedImage(format="jpeg", data=data), "eye"))
        pixels = array("B", bytes([1, 2, 3] * 12))
        image = sensor.Image(width=4, height=3, step=12, encoding="bgr8", data=pixels)
        self.raw.publish(self.stamp(image, "eye"))

    # ---- what the test asks ----

    def unstamped(self, _rest: str) -> None:
        """Count time from when the simulation began, from now on."""
        self.stamped = False

    def shows(self, rest: str) -> None:
        """Film something else."""
        self.content = rest.encode()

    def room(self, frame: str) -> None:
        """Send a map, once."""
        message = nav.OccupancyGrid(data=array("b", [0, 100, -1, 50, 0, 0]))
        message.info.width, message.info.height, message.info.resolution = 3, 2, 0.5
        message.info.origin.position.x = -1.0
        self.grid.publish(self.stamp(message, frame))

    def stands(self, frame: str) -> None:
        """Say where it is, turned to the left."""
        message = geometry.PoseStamped()
        place, turn = message.pose.position, message.pose.orientation
        place.x, place.y, turn.z, turn.w = 0.25, 0.5, 0.7071067811865476, 0.7071067811865476
        self.place.publish(self.stamp(message, frame))

    def goes(self, frame: str) -> None:
        """Say where it means to go, once."""
        poses = [geometry.PoseStamped() for _ in range(3)]
        for index, one in enumerate(poses):
            one.pose.position.x = float(index)
        self.path.publish(self.stamp(nav.Path(poses=poses), frame))


def main() -> None:
    no_signals = import_module("rclpy.signals").SignalHandlerOptions.NO
    rclpy.init(signal_handler_options=no_signals)
    node = rclpy.create_node("eyes", namespace="/omni")
    eyes = Eyes(node)
    executor = import_module("rclpy.executors").SingleThreadedExecutor()
    executor.add_node(node)
    ended = threading.Event()

    def spin() -> None:
        while not ended.is_set():
            executor.spin_once(timeout_sec=0.05)

    thread = threading.Thread(target=spin)
    thread.start()
    say("ready")
    for line in sys.stdin:
        word, _, rest = line.strip().partition(" ")
        getattr(eyes, word)(rest)
        say(f"ok {word}")
    ended.set()
    thread.join()
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
