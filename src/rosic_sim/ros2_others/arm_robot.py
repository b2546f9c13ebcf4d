"""An arm with ros2_control, as it looks from outside: a trajectory controller and a gripper."""

from __future__ import annotations

import itertools
from importlib import import_module
from typing import TYPE_CHECKING

from rosic.core.time_units import SECOND_NS
from rosic_sim.ros2.endpoints import publisher
from rosic_sim.ros2_others.action_server import (
    ABORTED,
    CANCELLED,
    SUCCEEDED,
    ActionCallbacks,
    SingleGoalServer,
)
from rosic_sim.ros2_others.arm import GRIPPER, JOINTS, Arm, ArmGripper, TrajectoryPoint

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.ros2.actuations import ActuationLog
    from rosic_sim.ros2.waiting_clock import WaitingClock

TYPES = ("control_msgs/action/FollowJointTrajectory", "control_msgs/action/GripperCommand")
CONTROLLER, GRIPPER_CONTROLLER = "joint_trajectory_controller", "gripper_controller"
STEP_S = 0.02
TELL_EVERY_S = 0.05
PATH_TOLERANCE_VIOLATED = -4


class ArmRobot:
    """Under its namespace: ``joint_trajectory_controller/follow_joint_trajectory``,
    ``gripper_controller/gripper_cmd`` and ``joint_states``. A goal that is called off holds the
    arm where it comes to rest.

    Attributes:
        due_s: When it wants its next turn.
    """  # noqa: D205 - a list of names

    NODE_NAME = CONTROLLER

    def __init__(self, node: RosObject, robot: str, clock: WaitingClock, log: ActuationLog) -> None:
        self.due_s = 0.0
        self.node = node
        self._robot = robot
        self._clock = clock
        self._log = log
        self._count = 0
        self._arm, self._gripper = Arm(), ArmGripper()
        self._points: list[TrajectoryPoint] = []
        self._width_m = self._start_s = 0.0
        self._last_s = clock.now_s()
        self._told_s = float("-inf")
        node.declare_parameter("joints", list(JOINTS))
        self._state = import_module("sensor_msgs.msg").JointState
        self._states = publisher(node, self._state, "joint_states")
        actions = import_module("control_msgs.action")
        self._follow = SingleGoalServer(
            node,
            actions.FollowJointTrajectory,
            f"{CONTROLLER}/follow_joint_trajectory",
            ActionCallbacks(self._asked, self._followed, self._arm.halt),
        )
        self._grip = SingleGoalServer(
            node,
            actions.GripperCommand,
            f"{GRIPPER_CONTROLLER}/gripper_cmd",
            ActionCallbacks(self._asked_to_grip, self._gripped, self._gripper.halt),
        )

    def close(self) -> None:
        """Leave the graph."""
        self.node.destroy_node()

    def turn(self) -> None:
        """Move for as long as it was since the last turn, and tell what there is to tell."""
        now_s = self._clock.now_s()
        if now_s < self.due_s:
            return
        self.due_s = now_s + STEP_S
        while self._last_s < now_s:
            self._arm.step(STEP_S, self._last_s)
            self._gripper.step(STEP_S)
            self._last_s += STEP_S
        telling = now_s - self._told_s >= TELL_EVERY_S
        if self._follow.busy:
            self._look_at_trajectory(telling=telling)
        if self._grip.busy:
            self._look_at_grip()
        if telling:
            self._told_s = now_s
            self._tell()

    # ---- trajectories ----

    def _asked(self, request: RosObject) -> str:
        trajectory = request.trajectory
        if list(trajectory.joint_names) != list(JOINTS):
            return "the joints of the goal are not those of the controller"
        points = [
            TrajectoryPoint(_seconds(p.time_from_start), tuple(p.positions))
            for p in trajectory.points
        ]
        times = [0.0, *(point.at_s for point in points)]
        if not points or any(b <= a for a, b in itertools.pairwise(times)):
            return "the points of the goal are not one after another"
        self._points, stamp = points, trajectory.header.stamp
        stamp_ns = stamp.sec * SECOND_NS + stamp.nanosec
        self._start_s = self._clock.coming_s(stamp_ns) if stamp_ns else self._last_s
        return ""

    def _followed(self, goal_id: str) -> None:
        self._begin("follow_joint_trajectory", goal_id)
        self._arm.follow(self._points, self._start_s)

    def _look_at_trajectory(self, *, telling: bool) -> None:
        arm = self._arm
        if arm.late and not self._follow.cancelling:
            arm.halt()
            sentence = "the joints could not keep up with the trajectory"
            self._follow.end(ABORTED, error_code=PATH_TOLERANCE_VIOLATED, error_string=sentence)
        elif self._follow.cancelling:
            if arm.at_rest:
                self._follow.end(CANCELLED)
        elif arm.arrived:
            self._follow.end(SUCCEEDED, error_string="goal reached")
        elif telling:
            point = import_module("trajectory_msgs.msg").JointTrajectoryPoint
            actual = point(positions=list(arm.positions), velocities=list(arm.speeds))
            self._follow.feedback(joint_names=list(JOINTS), actual=actual)

    # ---- gripper ----

    def _asked_to_grip(self, request: RosObject) -> str:
        self._width_m = request.command.position
        return ""

    def _gripped(self, goal_id: str) -> None:
        self._begin("gripper_cmd", goal_id)
        self._gripper.go(self._width_m)

    def _look_at_grip(self) -> None:
        gripper = self._gripper
        facts = {
            "position": gripper.width_m,
            "stalled": gripper.stalled,
            "reached_goal": gripper.reached,
        }
        if self._grip.cancelling:
            self._grip.end(CANCELLED, **facts)
        elif gripper.stalled or gripper.reached:
            self._grip.end(SUCCEEDED, **facts)

    # ---- both ----

    def _begin(self, action: str, goal_id: str) -> None:
        self._count += 1
        self._log.add(self._robot, action, goal_id, self._count)

    def _tell(self) -> None:
        message = self._state(name=[*JOINTS, GRIPPER])
        message.header.stamp = self.node.get_clock().now().to_msg()
        message.position = [*self._arm.positions, self._gripper.width_m]
        message.velocity = [*self._arm.speeds, self._gripper.speed_m_s]
        self._states.publish(message)


def _seconds(duration: RosObject) -> float:
    return float(duration.sec) + float(duration.nanosec) / SECOND_NS
