"""What carries out goals with the base of `base_node.py`: plain rclpy, the action /base/go.

Usage: navigator_node.py INTERFACES NAME. A goal is driven with feedback until it is called off.
The next goal after the line ``early SECONDS`` is said to be done at once, and driven for so long.
"""

from __future__ import annotations

import sys
import threading
import time
from importlib import import_module
from typing import Any, TypeAlias

RosObject: TypeAlias = Any

STEP_S = 0.05
SPEED_M_S = 0.2


def tell(line: str) -> None:
    sys.stdout.write(f"{line}\n")
    sys.stdout.flush()


class Navigator:
    """One node: publishes /base/cmd_vel while it has a goal."""

    def __init__(self, node: RosObject) -> None:
        actions: Any = import_module("rclpy.action")
        self.early_s = 0.0
        self._twist: Any = import_module("geometry_msgs.msg").Twist
        self._move: Any = import_module("rosic_interfaces.action").Move
        self._velocities = node.create_publisher(self._twist, "cmd_vel", 5)
        self._server = actions.ActionServer(
            node,
            self._move,
            "go",
            self._go,
            cancel_callback=lambda _goal: actions.CancelResponse.ACCEPT,
            callback_group=import_module("rclpy.callback_groups").ReentrantCallbackGroup(),
        )

    def _drive(self, speed_m_s: float) -> None:
        twist = self._twist()
        twist.linear.x = speed_m_s
        self._velocities.publish(twist)

    def _on(self, seconds: float) -> None:
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            self._drive(SPEED_M_S)
            time.sleep(STEP_S)
        self._drive(0.0)

    def _go(self, goal: RosObject) -> RosObject:
        tell("goal")
        while not self._velocities.get_subscription_count():
            time.sleep(STEP_S)
        if self.early_s:
            self._drive(SPEED_M_S)
            time.sleep(0.3)
            threading.Thread(target=self._on, args=(self.early_s,), daemon=True).start()
            self.early_s = 0.0
            goal.succeed()
            return self._move.Result(success=True, message="there")
        share = 0.0
        while not goal.is_cancel_requested:
            self._drive(SPEED_M_S)
            goal.publish_feedback(self._move.Feedback(fraction=share, stage="rolling"))
            share = min(0.9, share + 0.01)
            time.sleep(STEP_S)
        self._drive(0.0)
        goal.canceled()
        tell("called off")
        return self._move.Result(message="called off")


def main() -> None:
    sys.path.insert(0, sys.argv[1])
    rclpy: Any = import_module("rclpy")
    executors: Any = import_module("rclpy.executors")
    rclpy.init(signal_handler_options=import_module("rclpy.signals").SignalHandlerOptions.NO)
    node = rclpy.create_node(sys.argv[2], namespace="/base")
    navigator = Navigator(node)
    executor = executors.MultiThreadedExecutor(num_threads=4)
    executor.add_node(node)

    def spin() -> None:
        try:
            executor.spin()
        except executors.ExternalShutdownException:
            return

    spinning = threading.Thread(target=spin)
    spinning.start()
    tell("ready")
    for line in sys.stdin:
        navigator.early_s = float(line.split()[1])
        tell(f"ok {line.strip()}")
    executor.shutdown(timeout_sec=1)
    spinning.join()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
