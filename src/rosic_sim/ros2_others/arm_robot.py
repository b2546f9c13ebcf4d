"""An arm with ros2_control, as it looks from outside: a trajectory controller and a gripper."""

from __future__ import annotations

import itertools
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from rosic.core.time_units import SECOND_NS
from rosic_sim.ros2.endpoints import publisher
from rosic_sim.ros2_others.action_server import (
    ABORTED,
    CANCELLED,
    SUCCEEDED,
    ActionCallbacks,
    SingleGoalServer,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.ros2.endpoints import ActuationLog
    from rosic_sim.ros2.waiting_clock import WaitingClock


# ---- arm ----

# Six joints that follow a trajectory as far as their motors can, and a gripper with a part.

JOINTS = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)
FASTEST_RAD_S = (2.0, 2.0, 3.0, 3.0, 3.0, 3.0)
DECELERATION_RAD_S2 = 8.0
LAG_RAD = 0.1
GRIPPER = "finger_joint"
OPEN_M, PART_M, GRIPPER_M_S = 0.085, 0.03, 0.1


class TrajectoryPoint(NamedTuple):
    """Where the joints are to be, and after how many seconds."""

    at_s: float
    positions: tuple[float, ...]


class Arm:
    """Where the joints are, how fast they go, and what they follow.

    Attributes:
        late: It fell behind its trajectory by more than `LAG_RAD`: asked too much of the motors.
    """

    def __init__(self) -> None:
        self.positions = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
        self.speeds = [0.0] * len(JOINTS)
        self.late = False
        self._points: list[TrajectoryPoint] = []
        self._begun_s = 0.0

    def follow(self, points: Sequence[TrajectoryPoint], now_s: float) -> None:
        """Follow a trajectory from where it is."""
        self._points = [TrajectoryPoint(0.0, tuple(self.positions)), *points]
        self._begun_s, self.late = now_s, False

    def halt(self) -> None:
        """Follow nothing; come to rest as fast as the motors can."""
        self._points = []

    @property
    def arrived(self) -> bool:
        """Whether it stands at the end of what it followed."""
        return not self._points and self.at_rest

    @property
    def at_rest(self) -> bool:
        """Whether nothing moves."""
        return not any(self.speeds)

    def step(self, dt_s: float, now_s: float) -> None:
        """Advance by a moment."""
        wanted = self._wanted(now_s + dt_s)
        for index, fastest in enumerate(FASTEST_RAD_S):
            here = self.positions[index]
            if wanted is None:
                speed = self.speeds[index]
                slower = max(0.0, abs(speed) - DECELERATION_RAD_S2 * dt_s)
                self.speeds[index] = slower if speed > 0 else -slower
            else:
                speed = (wanted[index] - here) / dt_s
                self.speeds[index] = max(-fastest, min(fastest, speed))
                self.late = self.late or abs(speed) * dt_s > LAG_RAD
            self.positions[index] = here + self.speeds[index] * dt_s
        if self._points and now_s + dt_s - self._begun_s >= self._points[-1].at_s:
            goal = self._points[-1].positions
            if max(abs(g - p) for g, p in zip(goal, self.positions, strict=True)) < 1e-6:  # noqa: PLR2004 - there
                self._points, self.speeds = [], [0.0] * len(JOINTS)

    def _wanted(self, now_s: float) -> tuple[float, ...] | None:
        """Return where the joints are to be by then; a smooth step leads from point to point."""
        gone_s = now_s - self._begun_s
        for before, after in zip(self._points, self._points[1:], strict=False):
            if gone_s < after.at_s:
                share = max(0.0, gone_s - before.at_s) / max(after.at_s - before.at_s, 1e-9)
                smooth = share * share * (3 - 2 * share)
                pairs = zip(before.positions, after.positions, strict=True)
                return tuple(a + (b - a) * smooth for a, b in pairs)
        return self._points[-1].positions if self._points else None


class ArmGripper:
    """Two fingers, with a part between them until somebody takes it away.

    Attributes:
        width_m: Between the fingers.
        stalled: They push and do not move: they hold something.
    """

    def __init__(self) -> None:
        self.width_m = OPEN_M
        self.speed_m_s = 0.0
        self.stalled = False
        self.part = True
        self._goal_m: float | None = None

    def go(self, width_m: float) -> None:
        """Close or open to a width."""
        self._goal_m, self.stalled = min(max(width_m, 0.0), OPEN_M), False

    def halt(self) -> None:
        """Stay as it is."""
        self._goal_m, self.speed_m_s = None, 0.0

    @property
    def reached(self) -> bool:
        """Whether it is where it was sent."""
        return self._goal_m is not None and abs(self._goal_m - self.width_m) < 1e-6  # noqa: PLR2004 - there

    def step(self, dt_s: float) -> None:
        """Advance by a moment."""
        if self._goal_m is None or self.stalled:
            self.speed_m_s = 0.0
            return
        way = max(-GRIPPER_M_S * dt_s, min(GRIPPER_M_S * dt_s, self._goal_m - self.width_m))
        narrow = self.width_m + way
        if self.part and way < 0 and narrow < PART_M:
            narrow, self.stalled = min(self.width_m, PART_M), True
        self.speed_m_s = (narrow - self.width_m) / dt_s
        self.width_m = narrow


# ---- arm robot ----

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
