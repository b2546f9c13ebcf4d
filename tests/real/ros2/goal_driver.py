"""A gateway's side in a process of its own, to be frozen: moves the peer's /omni by goals.

Lines on standard input as for `stream_driver`, with metres for seconds: ``drive METRES``.
"""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING

from tests.real.ros2.simulated import profile_of
from tests.real.ros2.stream_driver import obey

if TYPE_CHECKING:
    from rosic.core.order import Order
    from rosic.core.robot.profile import Profile
    from tests.real.ros2.simulated import TriedRobot

WATCHDOG_S = 0.5
MOVE = {
    "parameters": {"distance": {"unit": "m", "min": 0.1, "max": 5}},
    "action": {
        "name": "/omni/move",
        "type": "rosic_interfaces/action/Move",
        "goal": {"direction": "forward", "distance_m": "$distance"},
        "stage": "stage",
        "timeout_s": 600.0,
    },
}


def omni() -> Profile:
    """Return the profile of a robot that does what it was told until somebody calls it off."""
    return profile_of(
        id="omni",
        title="Omni",
        link={"kind": "ros2", "namespace": "/omni"},
        stop={"service": "/omni/stop"},
        watchdog_s=WATCHDOG_S,
        skills={"move": MOVE},
    )


def for_metres(robot: TriedRobot, metres: float) -> Order:
    return robot.order("move", {"distance": metres})


if __name__ == "__main__":
    asyncio.run(obey(omni(), for_metres))
