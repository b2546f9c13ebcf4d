"""A base for tests whose odometry and whose stop are not what they should be: plain rclpy.

Usage: doubtful_node.py [NAME] [WORD=VALUE...]. The words may come later, too, as lines on standard
input, each answered by ``ok``; ``velocities`` is answered by how many came that were not zero.

    twist    true, zero (never filled), nan
    pose     true, fixed (never filled)
    stamp    live, none, old (the last message is repeated as it was)
    joints   full, empty (no velocities)
    stop     true, false (the service says so, and the base drives on), hangs (it never answers, and
             the base drives on)
    zero     true, false (a velocity of zero is not obeyed either, and there is no watchdog), or a
             number: only from so many zeros in a row on it is obeyed
    hz       how often odometry comes
    battery  what it says of its charge
    by_hand  a velocity that nobody sent
"""

from __future__ import annotations

import sys
import threading
import time
from importlib import import_module
from typing import Any, TypeAlias

RosObject: TypeAlias = Any

rclpy: Any = import_module("rclpy")
Twist: Any = import_module("geometry_msgs.msg").Twist
Odometry: Any = import_module("nav_msgs.msg").Odometry
sensors: Any = import_module("sensor_msgs.msg")
Trigger: Any = import_module("std_srvs.srv").Trigger

STEP_S = 0.02
WATCHDOG_S = 0.5


class Base:
    """Under /base: cmd_vel, odom, joints, battery, stop."""

    def __init__(self, node: RosObject, stopping: RosObject) -> None:
        self.says = {
            "twist": "true",
            "pose": "true",
            "stamp": "live",
            "joints": "full",
            "stop": "true",
            "zero": "true",
            "hz": "20",
            "by_hand": "0",
            "battery": "0.8",
        }
        self.velocities = self._zeros = 0
        self._node = node
        self._x_m = self._speed_m_s = 0.0
        self._told_s = self._said_s = float("-inf")
        self._last = Odometry()
        self._odometry = node.create_publisher(Odometry, "odom", 10)
        self._joints = node.create_publisher(sensors.JointState, "joints", 10)
        self._battery = node.create_publisher(sensors.BatteryState, "battery", 10)
        node.create_subscription(Twist, "cmd_vel", self._take, 10)
        stopping.create_service(Trigger, "stop", self._stop)
        node.create_timer(STEP_S, self._step)

    def take(self, words: list[str]) -> None:
        """Behave as it says from now on."""
        for word in words:
            name, given, value = word.partition("=")
            if given:
                self.says[name] = value

    def _take(self, twist: RosObject) -> None:
        self._told_s = time.monotonic()
        self.velocities += twist.linear.x != 0.0
        self._zeros = 0 if twist.linear.x else self._zeros + 1
        zero = self.says["zero"]
        obeyed = zero == "true" or (zero.isdigit() and self._zeros >= int(zero))
        if twist.linear.x or obeyed:
            self._speed_m_s = twist.linear.x

    def _stop(self, _request: RosObject, response: RosObject) -> RosObject:
        while self.says["stop"] == "hangs":
            time.sleep(STEP_S)
        response.success = self.says["stop"] == "true"
        if response.success:
            self._speed_m_s = 0.0
        else:
            response.message = "brake circuit open"
        return response

    def _step(self) -> None:
        now_s = time.monotonic()
        if now_s - self._told_s > WATCHDOG_S and self.says["zero"] == "true":
            self._speed_m_s = 0.0
        speed_m_s = float(self.says["by_hand"]) or self._speed_m_s
        self._x_m += speed_m_s * STEP_S
        if now_s - self._said_s < 1.0 / float(self.says["hz"]) - STEP_S / 2:
            return
        self._said_s = now_s
        self._tell(speed_m_s)

    def _tell(self, speed_m_s: float) -> None:
        if self.says["stamp"] != "old":
            self._last = Odometry()
            if self.says["stamp"] == "live":
                self._last.header.stamp = self._node.get_clock().now().to_msg()
            if self.says["pose"] == "true":
                self._last.pose.pose.position.x = self._x_m
            told = {"true": speed_m_s, "zero": 0.0, "nan": float("nan")}
            self._last.twist.twist.linear.x = told[self.says["twist"]]
        self._odometry.publish(self._last)
        full = self.says["joints"] == "full"
        joints = sensors.JointState(name=["wheel"], velocity=[speed_m_s] if full else [])
        self._joints.publish(joints)
        self._battery.publish(sensors.BatteryState(percentage=float(self.says["battery"])))


def main() -> None:
    names = [word for word in sys.argv[1:] if "=" not in word]
    signals: Any = import_module("rclpy.signals")
    rclpy.init(args=[], signal_handler_options=signals.SignalHandlerOptions.NO)
    name = names[0] if names else "base"
    node = rclpy.create_node(name, namespace="/base")
    stopping = rclpy.create_node(f"{name}_stop", namespace="/base")
    base = Base(node, stopping)
    base.take(sys.argv[1:])
    over = threading.Event()

    def spin(spun: RosObject) -> None:
        executors: Any = import_module("rclpy.executors")
        executor = executors.SingleThreadedExecutor()
        executor.add_node(spun)
        while not over.is_set():
            executor.spin_once(timeout_sec=0.1)

    # A stop that hangs keeps nothing else from going on.
    threads = [threading.Thread(target=spin, args=(spun,)) for spun in (node, stopping)]
    for spinning in threads:
        spinning.start()
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    for line in sys.stdin:
        base.take(line.split())
        sys.stdout.write(f"ok {base.velocities}\n")
        sys.stdout.flush()
    over.set()
    base.take(["stop=true"])
    for spinning in threads:
        spinning.join()
    node.destroy_node()
    stopping.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
