"""A robot with Nav2, as it looks from outside: navigate_to_pose, a map, a place on it."""

from __future__ import annotations

from array import array
from importlib import import_module
from math import atan2, cos, sin
from typing import TYPE_CHECKING

from rosic.robots.ros2.client.rclpy_import import load_ros
from rosic_sim.ros2.endpoints import publisher, subscribe
from rosic_sim.ros2_others.action_server import (
    ABORTED,
    CANCELLED,
    SUCCEEDED,
    ActionCallbacks,
    SingleGoalServer,
)
from rosic_sim.ros2_others.base_controller import DifferentialBase
from rosic_sim.ros2_others.room import CELL_M, ROOM, Place, cells

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.ros2.actuations import ActuationLog
    from rosic_sim.ros2.waiting_clock import WaitingClock

TYPES = ("nav2_msgs/action/NavigateToPose",)
STEP_S = 0.02
TELL_EVERY_S = 0.1
FEW_EVERY_S = 0.5
# nav2_msgs gives planners the codes from 200 on; what is asked for lies in something.
NO_WAY = 208
MAP = "map"


class Nav2Robot:
    """Under its namespace: ``navigate_to_pose``, ``cmd_vel``, ``odom``, ``amcl_pose``, ``map``,
    ``plan`` and ``battery_state``. Like Nav2 it takes a new goal instead of the one before, and
    knows nothing of gateways: a goal goes on when nobody listens any more.

    Attributes:
        due_s: When it wants its next turn.
    """  # noqa: D205 - a list of names

    NODE_NAME = "bt_navigator"

    def __init__(self, node: RosObject, robot: str, clock: WaitingClock, log: ActuationLog) -> None:
        self.due_s = 0.0
        self.node = node
        self._robot = robot
        self._clock = clock
        self._log = log
        self._count = 0
        self._base = DifferentialBase()
        self._last_s = clock.now_s()
        self._told_s = self._few_s = self._begun_s = float("-inf")
        self._goal: tuple[float, float, float] | None = None
        nav, geo = import_module("nav_msgs.msg"), import_module("geometry_msgs.msg")
        self._types = {"nav": nav, "geo": geo, "sensor": import_module("sensor_msgs.msg")}
        self._odom = publisher(node, nav.Odometry, "odom")
        self._pose = publisher(node, geo.PoseWithCovarianceStamped, "amcl_pose", _kept())
        self._plan = publisher(node, nav.Path, "plan")
        self._battery = publisher(node, self._types["sensor"].BatteryState, "battery_state")
        self._map = self._publish_map()
        self._locate()
        subscribe(node, geo.Twist, "cmd_vel", self._velocity)
        action = import_module("nav2_msgs.action").NavigateToPose
        sides = ActionCallbacks(self._begin, self._began, self._base.halt)
        self._served = SingleGoalServer(node, action, "navigate_to_pose", sides)

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
            self._base.step(STEP_S, self._last_s)
            self._last_s += STEP_S
        if self._served.busy:
            self._look_at_goal(now_s)
        if now_s - self._told_s >= TELL_EVERY_S:
            self._told_s = now_s
            self._tell()
        if now_s - self._few_s >= FEW_EVERY_S:
            self._few_s = now_s
            self._tell_few()

    # ---- goals ----

    def _begin(self, request: RosObject) -> str:
        pose = request.pose
        if pose.header.frame_id != MAP:
            return f"goals are places in the frame {MAP}, not {pose.header.frame_id or 'none'}"
        turned = pose.pose.orientation
        yaw_rad = 2 * atan2(turned.z, turned.w)
        self._goal = (pose.pose.position.x, pose.pose.position.y, yaw_rad)
        return ""

    def _began(self, goal_id: str) -> None:
        self._count += 1
        self._begun_s = self._clock.now_s()
        self._log.add(self._robot, "navigate_to_pose", goal_id, self._count)
        if self._goal is None or not self._base.go(*self._goal):
            self._base.halt()
            x_m, y_m, _ = self._goal or (0.0, 0.0, 0.0)
            sentence = f"there is no way to {x_m:.2f}, {y_m:.2f}"
            self._served.end(ABORTED, error_code=NO_WAY, error_msg=sentence)
            return
        self._publish_plan([(self._base.x_m, self._base.y_m), *self._base.corners])

    def _look_at_goal(self, now_s: float) -> None:
        base = self._base
        if self._served.cancelling:
            if base.at_rest:
                self._served.end(CANCELLED)
        elif base.arrived:
            self._tell_few(
                located=True
            )  # where it is is known before anybody reads that it is there
            self._served.end(SUCCEEDED)
        elif now_s - self._told_s >= TELL_EVERY_S:
            duration = import_module("builtin_interfaces.msg").Duration
            gone_s = now_s - self._begun_s
            self._served.feedback(
                current_pose=self._stamped(),
                navigation_time=duration(sec=int(gone_s), nanosec=int(gone_s % 1 * 1e9)),
                distance_remaining=base.remaining_m,
            )

    def _velocity(self, twist: RosObject) -> None:
        if not self._served.busy:
            self._base.drive(twist.linear.x, twist.angular.z, self._clock.now_s())

    # ---- telling ----

    def _tell(self) -> None:
        base, message = self._base, self._types["nav"].Odometry(child_frame_id="base_link")
        message.header.stamp, message.header.frame_id = self._stamp(), "odom"
        _place(message.pose.pose, base)
        message.twist.twist.linear.x = base.linear_m_s
        message.twist.twist.angular.z = base.angular_rad_s
        self._odom.publish(message)

    def _tell_few(self, *, located: bool = False) -> None:
        if located or not self._base.at_rest:
            self._locate()
        battery = self._types["sensor"].BatteryState(percentage=self._base.battery, present=True)
        battery.header.stamp = self._stamp()
        self._battery.publish(battery)

    def _locate(self) -> None:
        """Say where it is on the map: as a localisation does, on the way and at its end."""
        message = self._types["geo"].PoseWithCovarianceStamped()
        message.header.stamp, message.header.frame_id = self._stamp(), MAP
        _place(message.pose.pose, self._base)
        self._pose.publish(message)

    def _publish_plan(self, places: list[Place]) -> None:
        message = self._types["nav"].Path()
        message.header.stamp, message.header.frame_id = self._stamp(), MAP
        for x_m, y_m in places:
            pose = self._types["geo"].PoseStamped()
            pose.header = message.header
            pose.pose.position.x, pose.pose.position.y = x_m, y_m
            pose.pose.orientation.w = 1.0
            message.poses.append(pose)
        self._plan.publish(message)

    def _publish_map(self) -> RosObject:
        grids = self._types["nav"]
        keeper = publisher(self.node, grids.OccupancyGrid, MAP, _kept())
        columns, rows, taken = cells()
        message = grids.OccupancyGrid(data=array("b", taken))
        message.header.stamp, message.header.frame_id = self._stamp(), MAP
        message.info.width, message.info.height = columns, rows
        message.info.resolution = CELL_M
        message.info.origin.position.x, message.info.origin.position.y = ROOM.x0, ROOM.y0
        keeper.publish(message)
        return keeper

    def _stamped(self) -> RosObject:
        message = self._types["geo"].PoseStamped()
        message.header.stamp, message.header.frame_id = self._stamp(), MAP
        _place(message.pose, self._base)
        return message

    def _stamp(self) -> RosObject:
        return self.node.get_clock().now().to_msg()


def _kept() -> RosObject:
    """Return the quality of what is kept for whoever comes later."""
    qos = load_ros().qos
    return qos.QoSProfile(
        depth=1,
        reliability=qos.ReliabilityPolicy.RELIABLE,
        durability=qos.DurabilityPolicy.TRANSIENT_LOCAL,
    )


def _place(pose: RosObject, base: DifferentialBase) -> None:
    pose.position.x, pose.position.y = base.x_m, base.y_m
    pose.orientation.z, pose.orientation.w = sin(base.yaw_rad / 2), cos(base.yaw_rad / 2)
