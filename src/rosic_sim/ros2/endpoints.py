"""Publishers and subscriptions of a simulated robot, and who opens them."""

from __future__ import annotations

import os
import re
from types import MappingProxyType
from typing import TYPE_CHECKING, Protocol

from rosic.robots.ros2.client.qos import publisher_events, subscription_events

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.stepped_machine import SteppedMachine


# ---- interfaces ----

# What each simulated robot offers on the graph: exactly what the profiles that ship bind.

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


# ---- endpoints ----

# ---- actuations ----

# A file with one line for every time a robot began to act, for whoever counts from outside.


class ActuationLog:
    """Appends ``robot skill goal number``; a line is whole or absent, whoever else appends."""

    def __init__(self, path: Path | None) -> None:
        """Open it, unless there is none to keep.

        Raises:
            OSError: It cannot be written.
        """
        flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC
        self._file = None if path is None else os.open(path, flags, 0o600)

    def add(self, robot: str, skill: str, goal: str, number: int) -> None:
        """Write one down.

        Args:
            robot: Which acts.
            skill: What it does; ``drive`` for a stream of velocities.
            goal: Id of the goal in hexadecimal digits, ``-`` for a stream.
            number: Counts what this robot did since it was switched on, from 1.
        """
        if self._file is not None:
            os.write(self._file, f"{robot} {skill} {goal} {number}\n".encode())

    def moved(self, robot: str, wall_ns: int) -> None:
        """Write down that a robot's motors were first told to move, for one goal."""
        if self._file is not None:
            os.write(self._file, f"{robot} {wall_ns}\n".encode())

    def close(self) -> None:
        """Close it."""
        if self._file is not None:
            os.close(self._file)
            self._file = None


# ---- endpoints ----

DEPTH = 10


class SimulatedRobotNode(Protocol):
    """A node that carries one machine, as its actions and its faults see it.

    Attributes:
        id: Of the robot.
        node: The node itself, of rclpy.
        model: Which sort of robot it is.
        machine: What moves.
        linked: False while its radio is cut on purpose.
    """

    id: str
    node: RosObject
    model: str
    machine: SteppedMachine
    linked: bool

    def now_s(self) -> float:
        """Return the present on the machine's clock."""
        ...

    def start_s(self, stamp: RosObject) -> float | None:
        """Return a common start on the machine's clock; None when none was given."""
        ...

    def cut_link(self, now_s: float) -> None:
        """Cut its radio on purpose: it hears nothing and says nothing."""
        ...

    def mend_link(self, now_s: float) -> None:
        """Mend its radio."""
        ...

    def began(self, skill: str, goal: str) -> None:
        """Take down that the machine begins to act."""
        ...


def publisher(node: RosObject, kind: RosObject, topic: str, quality: object = DEPTH) -> RosObject:
    """Open a publisher; reliable unless ``quality`` says otherwise."""
    return node.create_publisher(kind, topic, quality, event_callbacks=publisher_events())


def subscribe(
    node: RosObject,
    kind: RosObject,
    topic: str,
    heard: Callable[[RosObject], None],
    quality: object = DEPTH,
) -> None:
    """Open a subscription, which the node keeps."""
    events = subscription_events()
    node.create_subscription(kind, topic, heard, quality, event_callbacks=events)
