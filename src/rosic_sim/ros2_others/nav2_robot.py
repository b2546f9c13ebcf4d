"""A robot with Nav2, as it looks from outside: navigate_to_pose, a map, a place on it."""

from __future__ import annotations

from array import array
from importlib import import_module
from itertools import pairwise, permutations
from math import atan2, cos, hypot, pi, sin, sqrt
from typing import TYPE_CHECKING, NamedTuple

from rosic.robots.ros2.client.rclpy_import import load_ros
from rosic_sim.ros2.endpoints import publisher, subscribe
from rosic_sim.ros2_others.action_server import (
    ABORTED,
    CANCELLED,
    SUCCEEDED,
    ActionCallbacks,
    SingleGoalServer,
)

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.ros2.endpoints import ActuationLog
    from rosic_sim.ros2.waiting_clock import WaitingClock


# ---- room ----

# A room with a cupboard in it, and ways round that. Pure geometry, metres.

CELL_M = 0.1


class RoomBox(NamedTuple):
    """A rectangle along the axes."""

    x0: float
    y0: float
    x1: float
    y1: float

    def grown(self, by_m: float) -> RoomBox:
        """Return it with a margin on every side; a negative one makes it smaller."""
        return RoomBox(self.x0 - by_m, self.y0 - by_m, self.x1 + by_m, self.y1 + by_m)

    def holds(self, x_m: float, y_m: float) -> bool:
        """Tell whether a place is inside."""
        return self.x0 < x_m < self.x1 and self.y0 < y_m < self.y1


Place = tuple[float, float]

ROOM = RoomBox(-5.0, -4.0, 5.0, 4.0)
CUPBOARD = RoomBox(0.8, -1.0, 1.6, 1.0)
RADIUS_M = 0.3


def free(place: Place) -> bool:
    """Tell whether the robot can stand there."""
    return ROOM.grown(-RADIUS_M).holds(*place) and not CUPBOARD.grown(RADIUS_M).holds(*place)


def way(start: Place, goal: Place) -> list[Place] | None:
    """Return the corners of the shortest free way, the goal last; None if there is none."""
    if not free(goal):
        return None
    if clear(start, goal):
        return [goal]
    box = CUPBOARD.grown(RADIUS_M + 0.05)
    corners = [(x, y) for x in (box.x0, box.x1) for y in (box.y0, box.y1)]
    ways = [[*turns, goal] for count in (1, 2) for turns in permutations(corners, count)]
    open_ways = [w for w in ways if all(map(clear, [start, *w], w))]
    return min(open_ways, key=lambda w: length([start, *w]), default=None)


def clear(one: Place, other: Place) -> bool:
    """Tell whether the robot can go straight from one place to another."""
    box = CUPBOARD.grown(RADIUS_M)
    enter, leave = 0.0, 1.0
    for here, there, low, high in zip(one, other, box[:2], box[2:], strict=True):
        step = there - here
        if step == 0.0:
            if not low < here < high:
                return True
            continue
        near, far = sorted(((low - here) / step, (high - here) / step))
        enter, leave = max(enter, near), min(leave, far)
    return enter >= leave - 1e-9


def length(places: list[Place]) -> float:
    """Return the length of a way."""
    if len(places) < 2:  # noqa: PLR2004 - one place is no way
        return 0.0
    pairs = pairwise(places)
    return sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairs)


def cells() -> tuple[int, int, list[int]]:
    """Return columns, rows and what an occupancy grid holds: 0 free, 100 taken."""
    columns = round((ROOM.x1 - ROOM.x0) / CELL_M)
    rows = round((ROOM.y1 - ROOM.y0) / CELL_M)
    inner = ROOM.grown(-CELL_M)
    found = []
    for row in range(rows):
        for column in range(columns):
            x, y = ROOM.x0 + (column + 0.5) * CELL_M, ROOM.y0 + (row + 0.5) * CELL_M
            found.append(100 if CUPBOARD.holds(x, y) or not inner.holds(x, y) else 0)
    return columns, rows, found


# ---- nav2 robot ----

# ---- base controller ----

# A differential base that follows a way: turn towards the next corner, go there, turn as asked.

SPEED_M_S, TURN_RAD_S = 0.8, 2.0
ACCELERATION_M_S2, ACCELERATION_RAD_S2 = 1.0, 4.0
THERE_M, ALIGNED_RAD = 0.01, 0.01
# Velocities that nobody repeats do not count for longer.
WATCHDOG_S = 0.5
DRAIN_PER_M = 0.001
DRAIN_PER_S = 2e-6


class DifferentialBase:
    """Where it is, how fast it goes, and where it means to go.

    Attributes:
        corners: Still ahead; empty when it goes nowhere.
        battery: Fraction of its charge.
    """

    def __init__(self) -> None:
        self.x_m = self.y_m = self.yaw_rad = 0.0
        self.linear_m_s = self.angular_rad_s = 0.0
        self.corners: list[Place] = []
        self.battery = 0.9
        self._yaw_rad: float | None = None
        self._driven: tuple[float, float] = (0.0, 0.0)
        self._driven_until_s = float("-inf")

    def go(self, x_m: float, y_m: float, yaw_rad: float) -> bool:
        """Set out for a place; False if no way leads there, and then nothing has changed."""
        found = way((self.x_m, self.y_m), (x_m, y_m))
        if found is None:
            return False
        self.corners, self._yaw_rad = found, yaw_rad
        return True

    def halt(self) -> None:
        """Give up the way; what moves comes to rest as fast as it may."""
        self.corners, self._yaw_rad = [], None
        self._driven_until_s = float("-inf")

    def drive(self, linear_m_s: float, angular_rad_s: float, now_s: float) -> None:
        """Take a velocity from outside, while it follows no way."""
        self._driven, self._driven_until_s = (linear_m_s, angular_rad_s), now_s + WATCHDOG_S

    @property
    def arrived(self) -> bool:
        """Whether nothing is left of its way, and it stands."""
        return not self.corners and self._yaw_rad is None and self.at_rest

    @property
    def at_rest(self) -> bool:
        """Whether it stands still."""
        return self.linear_m_s == 0.0 and self.angular_rad_s == 0.0

    @property
    def remaining_m(self) -> float:
        """How far it still has to go."""
        return length([(self.x_m, self.y_m), *self.corners])

    def step(self, dt_s: float, now_s: float) -> None:
        """Advance by a moment."""
        linear, angular = self._wanted(now_s)
        self.linear_m_s = _towards(self.linear_m_s, linear, ACCELERATION_M_S2 * dt_s)
        self.angular_rad_s = _towards(self.angular_rad_s, angular, ACCELERATION_RAD_S2 * dt_s)
        self.yaw_rad = _wrapped(self.yaw_rad + self.angular_rad_s * dt_s)
        way_m = self.linear_m_s * dt_s
        self.x_m += way_m * cos(self.yaw_rad)
        self.y_m += way_m * sin(self.yaw_rad)
        self.battery = max(0.0, self.battery - abs(way_m) * DRAIN_PER_M - dt_s * DRAIN_PER_S)

    def _wanted(self, now_s: float) -> tuple[float, float]:
        if self.corners:
            return self._along()
        if self._yaw_rad is not None:
            left = _wrapped(self._yaw_rad - self.yaw_rad)
            if abs(left) <= ALIGNED_RAD:
                self._yaw_rad = None
                return 0.0, 0.0
            return 0.0, _braking(left, TURN_RAD_S, ACCELERATION_RAD_S2)
        return self._driven if now_s < self._driven_until_s else (0.0, 0.0)

    def _along(self) -> tuple[float, float]:
        dx, dy = self.corners[0][0] - self.x_m, self.corners[0][1] - self.y_m
        left_m = hypot(dx, dy)
        if left_m <= THERE_M:
            del self.corners[0]
            return 0.0, 0.0
        off = _wrapped(atan2(dy, dx) - self.yaw_rad)
        turn = _braking(off, TURN_RAD_S, ACCELERATION_RAD_S2)
        # It turns on the spot before it goes, and near a corner it is content to stop.
        if abs(off) > (0.05 if left_m > 5 * THERE_M else pi / 2):
            return 0.0, turn
        return _braking(left_m, SPEED_M_S, ACCELERATION_M_S2), turn if left_m > 5 * THERE_M else 0.0


def _braking(left: float, fastest: float, deceleration: float) -> float:
    """Return the speed from which it can still come to rest where it should."""
    speed = min(fastest, sqrt(2 * deceleration * abs(left)) * 0.8)
    return speed if left > 0 else -speed


def _towards(value: float, wanted: float, most: float) -> float:
    return wanted if abs(wanted - value) <= most else value + (most if wanted > value else -most)


def _wrapped(angle_rad: float) -> float:
    return (angle_rad + pi) % (2 * pi) - pi


# ---- nav2 robot ----

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
