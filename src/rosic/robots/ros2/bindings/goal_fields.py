"""What is sent with a goal, made from an order and the fields that a profile names."""

from __future__ import annotations

from collections.abc import Callable
from math import cos, isfinite, sin
from typing import TYPE_CHECKING, NamedTuple, Protocol, TypeAlias

from rosic.errors import RosicError
from rosic.robots.ros2.bindings.answers import check_fields
from rosic.robots.ros2.bindings.binding_call import filled
from rosic.robots.ros2.messages.decode import compile_path
from rosic.robots.ros2.messages.encode import type_of

if TYPE_CHECKING:
    from rosic.core.order import Outcome
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.profile import ActionBinding

QUATERNION = "geometry_msgs/msg/Quaternion"

Fraction: TypeAlias = Callable[["RosObject"], float | None]
"""A feedback message to how far the robot is, in [0, 1]; None when it does not say."""


class MadeGoal(NamedTuple):
    """A goal that can be sent.

    Attributes:
        values: Its fields.
        fraction: Reads feedback about this goal.
    """

    values: dict[str, object]
    fraction: Fraction


class GoalMaker(Protocol):
    """Makes the goals of one skill."""

    def types(self) -> set[str]:
        """Return the types of message that it takes besides the action's."""
        ...

    async def open(self, runtime: RosRuntime, action: RosObject) -> None:
        """Check every field that the profile names, and open what it needs.

        Raises:
            BadName: A field does not exist.
        """
        ...

    async def close(self) -> None:
        """Close it."""
        ...

    def make(self, call: BindingCall) -> MadeGoal | Outcome:
        """Return the goal, or why there is none: then nothing was sent.

        Raises:
            RobotOffline: What has to be known of the robot is not known now.
        """
        ...


class GoalFields:
    """Fills fields with an order's arguments. A number given for an orientation turns about z."""

    def __init__(self, binding: ActionBinding) -> None:
        self._binding = binding
        self._turned: frozenset[str] = frozenset()

    def types(self) -> set[str]:
        """Return that it takes no more types."""
        return set()

    async def open(self, runtime: RosRuntime, action: RosObject) -> None:  # noqa: ARG002 - a contract
        """Check the fields of goal and feedback."""
        goal = self._binding.goal
        check_fields(action.Goal, goal)
        if self._binding.remaining:
            compile_path(action.Feedback, self._binding.remaining)
        made = action.Goal()
        self._turned = frozenset(field for field in goal if _is_orientation(made, field))

    async def close(self) -> None:
        """Do nothing: nothing was opened."""

    def make(self, call: BindingCall) -> MadeGoal:
        """Return the goal."""
        binding = self._binding
        values = filled(binding.goal, call.order)
        for field in self._turned:
            values[field] = _turn(values[field])
        if binding.remaining:
            return MadeGoal(values, RemainingFraction(binding.remaining))
        return MadeGoal(values, lambda message: number_at(message, binding.fraction))


class RemainingFraction:
    """Tells a fraction from what is left, measured against the most that ever was."""

    def __init__(self, path: str) -> None:
        self._path = path
        self._most = 0.0

    def __call__(self, message: RosObject) -> float | None:
        """Return how much of it is done; None until there was anything to do."""
        left = number_at(message, self._path)
        if left is None or left < 0:
            return None
        self._most = max(self._most, left)
        return 1.0 - left / self._most if self._most else None


def number_at(message: RosObject, path: str) -> float | None:
    """Return the finite number at a place of a message, if there is one."""
    try:
        found = compile_path(type(message), path)(message) if path else None
    except RosicError:
        return None
    if isinstance(found, bool) or not isinstance(found, (int, float)) or not isfinite(found):
        return None
    return float(found)


def _is_orientation(message: RosObject, path: str) -> bool:
    here = message
    for step in path.split("."):
        here = getattr(here, step, None)
    return hasattr(here, "SLOT_TYPES") and type_of(type(here)) == QUATERNION


def _turn(angle_rad: object) -> object:
    """Return the orientation of something that stands upright and looks that way."""
    if isinstance(angle_rad, bool) or not isinstance(angle_rad, (int, float)):
        return angle_rad  # not an angle: the check of the message says what is wrong
    return {"z": sin(angle_rad / 2), "w": cos(angle_rad / 2)}
