"""The profile of the base that `base_node.py` is."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.real.ros2.simulated import profile_of

if TYPE_CHECKING:
    from rosic.core.robot.profile import Profile

WATCHDOG_S = 0.5
PARAMETERS = {
    "linear": {"unit": "m/s", "min": -0.5, "max": 0.5},
    "duration": {"unit": "s", "min": 0.1, "max": 60},
}


def base_profile(within_s: float = 1.0, name: str = "base") -> Profile:
    """Return it; what shows its rest may be so old."""
    topic = {
        "name": f"/{name}/cmd_vel",
        "type": "geometry_msgs/msg/Twist",
        "message": {"linear.x": "$linear"},
        "stream_hz": 20.0,
    }
    return profile_of(
        id=name,
        title=name.capitalize(),
        link={"kind": "ros2", "namespace": f"/{name}", "heartbeat_s": max(3.0, within_s)},
        stop={"service": f"/{name}/stop", "zero": f"/{name}/cmd_vel"},
        watchdog_s=WATCHDOG_S,
        at_rest={
            "topic": f"/{name}/odom",
            "type": "nav_msgs/msg/Odometry",
            "field": "twist.twist.linear.x",
            "below": 0.005,
            "within_s": within_s,
        },
        rest_timeout_s=2.0,
        skills={"drive": {"parameters": PARAMETERS, "topic": topic}},
        telemetry={
            "battery": {
                "topic": f"/{name}/battery",
                "type": "sensor_msgs/msg/BatteryState",
                "field": "percentage",
                "unit": "%",
            }
        },
    )
