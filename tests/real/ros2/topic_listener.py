"""Hears texts on a topic, in a process of its own: "heard" at the first, at the end "all" of them.

What is said before the two have found each other reaches nobody; "hello" may be said until then.
The text "last" ends it.

Usage: topic_listener.py TOPIC DEPTH
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

rclpy: Any = import_module("rclpy")
qos: Any = import_module("rclpy.qos")
String: Any = import_module("std_msgs.msg").String


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> None:
    topic, depth = sys.argv[1], int(sys.argv[2])
    heard: list[str] = []
    rclpy.init()
    node = rclpy.create_node("topic_listener")
    node.create_subscription(
        String, topic, lambda message: heard.append(message.data), qos.QoSProfile(depth=depth)
    )
    while not heard:
        rclpy.spin_once(node)
    tell("heard")
    while heard[-1] != "last":
        rclpy.spin_once(node)
    tell(" ".join(("all", *(text for text in heard if text != "hello"))))


main()
