"""Joints of an arm: how far and how fast each may move, and the way from where it is to a goal."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

# A move is never shorter: a controller cannot follow a point that is due at once.
SHORTEST_S = 0.5


class JointLimit(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How far and how fast one joint may move: rad and rad/s; of a linear joint m and m/s."""

    min: float
    max: float
    speed: float

    def __post_init__(self) -> None:
        if not all(map(isfinite, (self.min, self.max, self.speed))):
            raise ValueError("min, max and speed must be finite")
        if self.min >= self.max or self.speed <= 0:
            raise ValueError("min must be below max, and speed above 0")


class Joints(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The joints that a trajectory controller moves.

    Attributes:
        topic: Where the robot reports where its joints are.
        limits: Joint, called as in that report, to its limits; in the order of the poses.
    """

    topic: str
    limits: dict[str, JointLimit]
    type: str = "sensor_msgs/msg/JointState"


class JointMove(msgspec.Struct, frozen=True):
    """A move of all joints together, straight in the space of joints.

    Attributes:
        start, goal: Positions in the order of the joints.
        duration_s: So long that no joint is faster than it may be.
    """

    start: tuple[float, ...]
    goal: tuple[float, ...]
    duration_s: float

    def fraction(self, positions: Sequence[float]) -> float:
        """Return how much of the longest way is behind the arm, in [0, 1]."""
        way = max((abs(g - s) for s, g in zip(self.start, self.goal, strict=True)), default=0.0)
        if way == 0.0:
            return 1.0
        left = max(abs(g - p) for g, p in zip(self.goal, positions, strict=True))
        return min(1.0, max(0.0, 1.0 - left / way))


class OutOfReach(ValueError):
    """A joint was to go further than it may.

    Attributes:
        joint: Which.
        limit: How far it may.
    """

    def __init__(self, joint: str, limit: JointLimit) -> None:
        super().__init__(f"{joint} goes from {limit.min:g} to {limit.max:g}")
        self.joint = joint
        self.limit = limit


def plan(
    limits: Mapping[str, JointLimit], start: Sequence[float], goal: Sequence[float], share: float
) -> JointMove:
    """Return the move from one pose to another.

    The speed along it has the shape of a smooth step, so its peak is half as much again as its
    mean; the duration allows for that.

    Args:
        limits: Of every joint, in the order of both poses.
        start: Where the joints are.
        goal: Where they are to go.
        share: Of every joint's own speed, in (0, 1].

    Raises:
        OutOfReach: A joint may not go there.
    """
    longest_s = SHORTEST_S
    for (joint, limit), here, there in zip(limits.items(), start, goal, strict=True):
        if not limit.min <= there <= limit.max:
            raise OutOfReach(joint, limit)
        longest_s = max(longest_s, 1.5 * abs(there - here) / (limit.speed * share))
    return JointMove(tuple(start), tuple(goal), longest_s)
