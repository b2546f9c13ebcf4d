"""The profile of the base that `base_node.py` is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.real.ros2.simulated import profile_of

if TYPE_CHECKING:
    from rosic.core.robot import Profile

WATCHDOG_S = 0.5
DRIVE = {
    "parameters": {
        "linear": {"unit": "m/s", "min": -0.5, "max": 0.5},
        "duration": {"unit": "s", "min": 0.1, "max": 60},
    },
    "topic": {
        "name": "/base/cmd_vel",
        "type": "geometry_msgs/msg/Twist",
        "message": {"linear.x": "$linear"},
        "stream_hz": 20.0,
    },
}


def base_profile(within_s: float = 1.0) -> Profile:
    """Return it; what shows its rest may be so old."""
    return profile_of(
        id="base",
        title="Base",
        link={"kind": "ros2", "namespace": "/base", "heartbeat_s": max(3.0, within_s)},
        stop={"service": "/base/stop", "zero": "/base/cmd_vel"},
        watchdog_s=WATCHDOG_S,
        at_rest={
            "topic": "/base/odom",
            "type": "nav_msgs/msg/Odometry",
            "field": "twist.twist.linear.x",
            "below": 0.005,
            "within_s": within_s,
        },
        rest_timeout_s=2.0,
        skills={"drive": DRIVE},
        telemetry={
            "battery": {
                "topic": "/base/battery",
                "type": "sensor_msgs/msg/BatteryState",
                "field": "percentage",
                "unit": "%",
            }
        },
    )
