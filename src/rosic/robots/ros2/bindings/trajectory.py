"""Goals of a trajectory controller: from where the joints are to where they are to go."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.core.order import OrderEnding, Outcome
from rosic.core.time_units import SECOND_NS
from rosic.errors import ConfigurationError, RobotOffline
from rosic.robots.ros2.bindings.answers import check_fields
from rosic.robots.ros2.bindings.goal_fields import MadeGoal
from rosic.robots.ros2.errors import BadValue
from rosic.robots.ros2.joints import JointMove, Joints, OutOfReach, plan

if TYPE_CHECKING:
    from rosic.core.order import Order
    from rosic.robots.ros2.bindings.binding_call import BindingCall
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic.robots.ros2.client.runtime import RosRuntime
    from rosic.robots.ros2.client.topics import LatestMessage
    from rosic.robots.ros2.profile import Trajectory

OUT_OF_REACH = "out-of-bounds"
# An arm may have been moved by hand since; a report that is older does not say where it is.
FRESH_S = 1.0


class TrajectoryGoal:
    """Makes moves of all joints that end together, none faster than the profile allows.

    Whether the way is free nobody here knows: a robot that could meet something needs a planner.
    """

    def __init__(self, trajectory: Trajectory, joints: Joints | None) -> None:
        """Make it.

        Raises:
            ConfigurationError: The profile does not say which joints there are.
        """
        if joints is None:
            raise ConfigurationError("A skill with a trajectory needs the profile's joints.")
        self._trajectory = trajectory
        self._joints = joints
        self._names = tuple(joints.limits)
        self._state: LatestMessage | None = None

    def types(self) -> set[str]:
        """Return the type of the report about joints."""
        return {self._joints.type}

    async def open(self, runtime: RosRuntime, action: RosObject) -> None:
        """Subscribe to where the joints are, and see that the action takes a trajectory."""
        check_fields(action.Goal, {"trajectory.joint_names": (), "trajectory.points": ()})
        check_fields(action.Feedback, {"joint_names": (), "actual.positions": ()})
        cls = runtime.types.message(self._joints.type)
        check_fields(cls, {"name": (), "position": ()})
        self._state = await runtime.latest(self._joints.topic, self._joints.type)

    async def close(self) -> None:
        """Subscribe no more."""
        state, self._state = self._state, None
        if state is not None:
            await state.close()

    def make(self, call: BindingCall) -> MadeGoal | Outcome:
        """Return the goal; nothing of it depends on how fast somebody else drove the arm before."""
        order = call.order
        start = self._where(call)
        try:
            move = plan(self._joints.limits, start, self._goal(order, start), self._share(order))
        except OutOfReach as far:
            sentence = said(
                "{joint} goes from {low:.2f} to {high:.2f} rad only. Nothing was done.",
                joint=far.joint,
                low=far.limit.min,
                high=far.limit.max,
            )
            return Outcome(OrderEnding.REFUSED, sentence, code=OUT_OF_REACH)
        return MadeGoal(self._values(move), lambda feedback: self._fraction(move, feedback))

    def _where(self, call: BindingCall) -> tuple[float, ...]:
        state = self._state
        age_s = None if state is None else state.age_s
        message = None if state is None or age_s is None or age_s > FRESH_S else state.message()
        found = self._in_order(list(message.name), list(message.position)) if message else None
        if found is None:
            raise RobotOffline(
                said(
                    "{shown} does not say where its joints are. Nothing was sent.",
                    shown=call.side.shown,
                )
            )
        return found

    def _in_order(self, names: list[str], positions: list[float]) -> tuple[float, ...] | None:
        there = dict(zip(names, positions, strict=False))
        if not there.keys() >= set(self._names):
            return None
        return tuple(float(there[name]) for name in self._names)

    def _goal(self, order: Order, start: tuple[float, ...]) -> tuple[float, ...]:
        to = order.skill.filled(self._trajectory.to, order.arguments)
        if not self._trajectory.joint:
            if not isinstance(to, tuple) or len(to) != len(start):
                raise BadValue(f"A pose of this arm has {len(start)} joints.")
            return to
        joint = order.skill.filled(self._trajectory.joint, order.arguments)
        if joint not in self._names or not isinstance(to, (int, float)):
            raise BadValue(f"{joint} is no joint of this arm.")
        pairs = zip(self._names, start, strict=True)
        return tuple(float(to) if name == joint else here for name, here in pairs)

    def _share(self, order: Order) -> float:
        share = order.skill.filled(self._trajectory.speed, order.arguments)
        if isinstance(share, (int, float)) and 0 < share <= 1:
            return float(share)
        raise BadValue("A speed is a share of the joints' own, above 0 and at most 1.")

    def _values(self, move: JointMove) -> dict[str, object]:
        duration_ns = round(move.duration_s * SECOND_NS)
        point = {
            "positions": list(move.goal),
            "velocities": [0.0] * len(move.goal),
            "time_from_start": {
                "sec": duration_ns // SECOND_NS,
                "nanosec": duration_ns % SECOND_NS,
            },
        }
        return {"trajectory.joint_names": list(self._names), "trajectory.points": [point]}

    def _fraction(self, move: JointMove, feedback: RosObject) -> float | None:
        positions = self._in_order(list(feedback.joint_names), list(feedback.actual.positions))
        return None if positions is None else move.fraction(positions)
