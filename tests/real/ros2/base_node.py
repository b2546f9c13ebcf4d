"""A wheeled base for tests: plain rclpy, driven by velocities, with a watchdog of half a second.

Usage: base_node.py FILE NAME [standby]. Every velocity that is not zero is appended to FILE as two
times of the wall clock in ns, when it was sent and when it was taken here, and itself; a stop
service is there, too. Lines on standard input: ``odometry off`` and ``odometry on``, ``stuck``
(zero does not stop it any more), ``jump`` (it says that it is somewhere else), ``forgetful`` (after
a break what was sent meanwhile is lost, the stop service does nothing, and it says that it rests,
then goes on) and ``mindful``, and ``speed``, which it answers. On standby it is a node alone until
``begin``.
"""

from __future__ import annotations

import sys
import threading
import time
from importlib import import_module
from pathlib import Path
from typing import Any, TypeAlias

RosObject: TypeAlias = Any

rclpy: Any = import_module("rclpy")
Twist: Any = import_module("geometry_msgs.msg").Twist
Odometry: Any = import_module("nav_msgs.msg").Odometry
BatteryState: Any = import_module("sensor_msgs.msg").BatteryState
Trigger: Any = import_module("std_srvs.srv").Trigger

STEP_S = 0.05
WATCHDOG_S = 0.5
JUMP_M = 5.0
BREAK_S = 0.8
PAUSE_S = 0.6


class Base:
    """Under /NAME: cmd_vel, odom, battery, stop."""

    def __init__(self, node: RosObject, velocities: Path) -> None:
        self.tells = True
        self.stuck = self.forgetful = False
        self._stepped_s, self._woke_ns = time.monotonic(), 0
        self._goes_on_s: float | None = None
        self._before_m_s = 0.0
        self._node = node
        self._file = velocities.open("a", buffering=1)
        self._x_m = self._speed_m_s = 0.0
        self._told_s = float("-inf")
        self._odometry = node.create_publisher(Odometry, "odom", 10)
        self._battery = node.create_publisher(BatteryState, "battery", 10)
        node.create_subscription(Twist, "cmd_vel", self._take, 10)
        node.create_service(Trigger, "stop", self._stop)
        node.create_timer(STEP_S, self._step)

    def obey(self, line: str) -> None:
        """Do what stands on a line."""
        if line == "stuck":
            self.stuck = True
        elif line == "jump":
            self._x_m += JUMP_M
        elif line in {"forgetful", "mindful"}:
            self.forgetful, self._goes_on_s = line == "forgetful", None
        elif line == "speed":
            tell(f"speed {self._speed_m_s}")
        else:
            self.tells = line != "odometry off"

    def _wake(self) -> None:
        """Lose what was sent in a break that is over now, and go on with what was before."""
        now_s, before_s = time.monotonic(), self._stepped_s
        self._stepped_s = now_s
        if self.forgetful and now_s - before_s > BREAK_S:
            self._woke_ns, self._goes_on_s = time.time_ns(), now_s + PAUSE_S
            self._before_m_s, self._speed_m_s = self._speed_m_s, 0.0

    def _take(self, twist: RosObject, about: RosObject) -> None:
        self._wake()
        if about["source_timestamp"] < self._woke_ns:
            return
        self._goes_on_s = None
        self._told_s = time.monotonic()
        if twist.linear.x or not self.stuck:
            self._speed_m_s = twist.linear.x
        if twist.linear.x:
            self._file.write(f"{about['source_timestamp']} {time.time_ns()} {twist.linear.x}\n")

    def _stop(self, _request: RosObject, response: RosObject) -> RosObject:
        self._wake()
        self._speed_m_s = self._speed_m_s if self.stuck or self.forgetful else 0.0
        response.success = True
        return response

    def _step(self) -> None:
        self._wake()
        if self._goes_on_s is not None and time.monotonic() > self._goes_on_s:
            self._speed_m_s = self._before_m_s
        elif time.monotonic() - self._told_s > WATCHDOG_S and not self.stuck:
            self._speed_m_s = 0.0
        self._x_m += self._speed_m_s * STEP_S
        if self.tells:
            odometry = Odometry()
            odometry.pose.pose.position.x = self._x_m
            odometry.twist.twist.linear.x = self._speed_m_s
            self._odometry.publish(odometry)
        self._battery.publish(BatteryState(percentage=0.8))


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


def main() -> None:
    signals: Any = import_module("rclpy.signals")
    rclpy.init(signal_handler_options=signals.SignalHandlerOptions.NO)
    node = rclpy.create_node("base", namespace=f"/{sys.argv[2]}")
    if sys.argv[3:]:
        tell("ready")
        sys.stdin.readline()
    base = Base(node, Path(sys.argv[1]))

    def spin() -> None:
        executors: Any = import_module("rclpy.executors")
        executor = executors.SingleThreadedExecutor()
        executor.add_node(node)
        while not over.is_set():
            executor.spin_once(timeout_sec=0.1)

    over = threading.Event()
    spinning = threading.Thread(target=spin)
    spinning.start()
    tell("begun" if sys.argv[3:] else "ready")
    for line in sys.stdin:
        base.obey(line.strip())
        tell(f"ok {line.strip()}")
    over.set()
    spinning.join()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
