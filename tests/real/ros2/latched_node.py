"""A robot for tests that says what it reports once, and keeps it for whoever comes later.

Usage: latched_node.py CHARGE [often]. Under /foreign it has a battery, and with ``often`` a
velocity of joints that is said 20 times a second, like with most. Each line on standard input is a
charge that it says next; it is answered by ``ok``.
"""

from __future__ import annotations

import sys
import threading
from importlib import import_module
from typing import Any

rclpy: Any = import_module("rclpy")
qos: Any = import_module("rclpy.qos")
sensors: Any = import_module("sensor_msgs.msg")

EVERY_S = 0.05
KEPT: Any = qos.QoSProfile(depth=1, durability=qos.DurabilityPolicy.TRANSIENT_LOCAL)


def main() -> None:
    signals: Any = import_module("rclpy.signals")
    executors: Any = import_module("rclpy.executors")
    rclpy.init(signal_handler_options=signals.SignalHandlerOptions.NO)
    node = rclpy.create_node("body", namespace="/foreign")
    battery = node.create_publisher(sensors.BatteryState, "power", KEPT)
    battery.publish(sensors.BatteryState(percentage=float(sys.argv[1])))
    if "often" in sys.argv[2:]:
        joints = node.create_publisher(sensors.JointState, "joints", 10)
        node.create_timer(EVERY_S, lambda: joints.publish(sensors.JointState(velocity=[0.0])))
    executor = executors.SingleThreadedExecutor()
    executor.add_node(node)
    over = threading.Event()

    def spin() -> None:
        while not over.is_set():
            executor.spin_once(timeout_sec=0.1)

    spinning = threading.Thread(target=spin)
    spinning.start()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        battery.publish(sensors.BatteryState(percentage=float(line)))
        sys.stdout.write("ok\n")
        sys.stdout.flush()
    over.set()
    spinning.join()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
