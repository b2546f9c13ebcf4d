"""Tells how fast a base is by its own odometry, in a process of its own that hears nothing else.

Each line is a time of the wall clock in nanoseconds, and the speed of any axis that is greatest.

Usage: odometry_listener.py TOPIC
"""

from __future__ import annotations

import sys
import threading
import time
from importlib import import_module
from typing import Any

rclpy: Any = import_module("rclpy")
Odometry: Any = import_module("nav_msgs.msg").Odometry


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def heard(message: Any) -> None:  # noqa: ANN401
    twist = message.twist.twist
    speed = max(abs(twist.linear.x), abs(twist.linear.y), abs(twist.angular.z))
    tell(f"{time.time_ns()} {speed:.4f}")


def main() -> None:
    rclpy.init(signal_handler_options=import_module("rclpy.signals").SignalHandlerOptions.NO)
    node = rclpy.create_node("odometry_listener")
    node.create_subscription(Odometry, sys.argv[1], heard, 100)
    executor = import_module("rclpy.executors").SingleThreadedExecutor()
    executor.add_node(node)
    over = threading.Event()

    def spin() -> None:
        while not over.is_set():
            executor.spin_once(timeout_sec=0.1)

    spinning = threading.Thread(target=spin)
    spinning.start()
    tell("ready")
    sys.stdin.read()
    over.set()
    spinning.join()
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
