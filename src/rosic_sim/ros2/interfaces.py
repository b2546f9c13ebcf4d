"""What each simulated robot offers on the graph: exactly what the profiles that ship bind."""

from __future__ import annotations

import re
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

MODELS: Mapping[str, str] = MappingProxyType(
    {
        "omni": "omni",
        "kuka1": "kuka",
        "yumi": "yumi",
        "cf1": "crazyflie",
        "cf2": "crazyflie",
        "cf3": "crazyflie",
    }
)
"""Robot to the kind of machine it is."""

# omni7 is one more of the kind, for whoever needs many; the others run only when they are named.
_MORE = re.compile(r"(omni|carrier|rover)[0-9]{1,3}")
_KINDS: Mapping[str, str] = MappingProxyType({"carrier": "omni", "rover": "rover"})


def model_of(robot: str) -> str:
    """Return what kind of machine a robot is; empty for one that there is not."""
    if robot == "watch":
        return "watcher"
    more = _MORE.fullmatch(robot)
    if more:
        return _KINDS.get(more[1]) or MODELS[more[1]]
    return MODELS.get(robot, "")


ACTIONS: Mapping[str, Mapping[str, str]] = MappingProxyType(
    {
        "omni": {"move": "Move", "turn": "Turn", "goto": "GoTo", "arm": "SetPose"},
        "kuka": {
            "home": "Perform",
            "move_joint": "MoveJoint",
            "grasp": "Grasp",
            "release": "Perform",
        },
        "watcher": {"goto": "GoTo", "recalibrate": "Perform"},
        "rover": {"goto": "GoTo"},
        "yumi": {"home": "Perform", "handover": "Perform"},
        "crazyflie": {
            "takeoff": "TakeOff",
            "land": "Perform",
            "goto": "GoTo",
            "formation": "Formation",
            "follow": "Follow",
        },
    }
)
"""Skill to the action of rosic_interfaces that carries it, by kind of machine."""

INTERFACES = "rosic_interfaces"
START = "start_at"
# A goal always carries every field; for these, zero means that the robot decides.
LEFT_TO_THE_ROBOT = frozenset({"speed_m_s", "speed_rad_s"})
