"""One simulated robot as one ROS 2 node."""

from __future__ import annotations

import time
from importlib import import_module
from typing import TYPE_CHECKING

from rosic.core.time_units import SECOND_NS
from rosic.robots.ros2.client.rclpy_import import load_ros
from rosic_sim.robots.machines.activity import ActivityRefused
from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.swarm import SwarmReport
from rosic_sim.robots.robot import answer
from rosic_sim.ros2.endpoints import DEPTH, INTERFACES, ActuationLog, model_of, publisher, subscribe
from rosic_sim.ros2.faults import RobotFaults
from rosic_sim.ros2.goals import MachineActions
from rosic_sim.ros2.reports import DrawJpeg, SceneCamera, TelemetryPublisher, publish_map

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.world import SimulatedWorld
    from rosic_sim.ros2.waiting_clock import WaitingClock


# ---- link watchdog ----

# Whether anybody is still there who could stop the robot.

LINK_LOST_S = 1.0


class LinkWatchdog:
    """Hears the heartbeats of gateways, and says once when they cease.

    A motion that began while no gateway was heard, because somebody sends goals by hand, is not
    watched until one is.

    Args:
        lost_s: The link is lost after so long without one.
    """

    def __init__(self, lost_s: float = LINK_LOST_S) -> None:
        self._lost_s = lost_s
        self._heard_s: float | None = None
        self._watching = False

    def heard(self, sent_s: float) -> None:
        """Take in a heartbeat.

        Args:
            sent_s: When it was sent, on the machine's clock: one that was on its way for too long
                proves nothing.
        """
        self._heard_s = max(sent_s, self._heard_s or sent_s)
        self._watching = True

    def begin(self, now_s: float) -> None:
        """A motion begins from rest."""
        self._watching = self._heard_s is not None and now_s - self._heard_s <= self._lost_s

    def lost(self, now_s: float) -> bool:
        """Tell, once, that nothing was heard for too long."""
        if not self._watching or self._heard_s is None or now_s - self._heard_s <= self._lost_s:
            return False
        self._watching = False
        return True


# ---- machine node ----

# ---- the swarm's topic ----

TOPIC = "/crazyflies/state"
FLYING_EVERY_S = 0.05
ON_THE_GROUND_EVERY_S = 0.2


class SwarmTopic:
    """The topic on which one drone tells its position to its swarm and hears the others.

    It hears itself there like everybody else, and knows no more of its peers than they say.
    """

    def __init__(self, owner: MachineNode, drone: Crazyflie) -> None:
        self._owner = owner
        self._drone = drone
        self._type = import_module(f"{INTERFACES}.msg").SwarmState
        qos = import_module("rclpy.qos")
        quality = qos.QoSProfile(depth=DEPTH, reliability=qos.ReliabilityPolicy.BEST_EFFORT)
        self._publisher = publisher(owner.node, self._type, TOPIC, quality)
        subscribe(owner.node, self._type, TOPIC, self._heard, quality)
        self._told_s = float("-inf")
        self._flew = False

    def turn(self, now_s: float, stamp: RosObject) -> None:
        """Say where the drone is when it is time, and at once when it has landed."""
        drone = self._drone
        every = FLYING_EVERY_S if drone.airborne else ON_THE_GROUND_EVERY_S
        if drone.airborne == self._flew and now_s - self._told_s < every - 1e-3:
            return
        self._told_s, self._flew = now_s, drone.airborne
        if not drone.silent:
            self._publisher.publish(self._message(drone.sighting(now_s), stamp))

    def _message(self, seen: SwarmReport, stamp: RosObject) -> RosObject:
        message = self._type(id=seen.robot, flying=seen.flying, stamp=stamp)
        message.busy, message.landing, message.leader = seen.busy, seen.landing, seen.leader
        place, speed, goal = message.pose.position, message.velocity.linear, message.goal
        place.x, place.y, place.z = seen.x_m, seen.y_m, seen.z_m
        flight = self._drone.flight
        speed.x, speed.y, speed.z = flight.vx_m_s, flight.vy_m_s, flight.height.velocity
        goal.x, goal.y, goal.z = seen.goal_x_m, seen.goal_y_m, flight.height.target
        return message

    def _heard(self, message: RosObject) -> None:
        drone, place, speed = self._drone, message.pose.position, message.velocity.linear
        if message.id == drone.id or message.id not in drone.swarm.members or drone.silent:
            return
        drone.swarm.hear(
            SwarmReport(
                message.id,
                self._owner.when_s(message.stamp),
                place.x,
                place.y,
                place.z,
                (speed.x**2 + speed.y**2) ** 0.5,
                message.goal.x,
                message.goal.y,
                message.flying,
                speed.x,
                speed.y,
                message.busy,
                message.landing,
                message.leader,
            )
        )


# ---- the node ----

NODE_NAME = "machine"
STEP_S = 0.02
AT_REST_STEP_S = 0.1


class MachineNode:
    """A machine, and what it offers under ``/<robot>``: actions, a stop, topics, faults.

    The node has no will of its own: every rule, from limits to landing when a peer is lost, is
    the machine's. All of it runs on one thread, so nothing here is locked.

    Attributes:
        linked: False while its radio is cut on purpose: it hears nothing and says nothing.
    """

    def __init__(  # noqa: PLR0913 - what a process of robots has, each robot is given
        self,
        ros_node: RosObject,
        robot: str,
        world: SimulatedWorld,
        clock: WaitingClock,
        log: ActuationLog,
        *,
        starts: ActuationLog,
        watch: LinkWatchdog,
    ) -> None:
        """Make it.

        Args:
            ros_node: Speaks for it.
            robot: Its id.
            world: Where its machine is.
            clock: When it wants its next turn.
            log: Takes down what is asked of it.
            starts: Takes down when it begins to move.
            watch: Whether anybody is still there who could stop it.
        """
        self.id = robot
        self.node = ros_node
        self.model = model_of(robot)
        self.machine = world.machines[robot]
        self.linked = True
        self._starts = starts
        self._clock = clock
        self._log = log
        self._count = 0
        self._due_s = 0.0
        self._waits = False
        self._stepped: tuple[float, RosObject] | None = None
        self._noted = ""
        self._watch = watch
        self._goals = MachineActions(self)
        self._reports = TelemetryPublisher(ros_node, self.machine)
        self._faults = RobotFaults(self, world)
        drone = self.machine if isinstance(self.machine, Crazyflie) else None
        self._swarm = None if drone is None else SwarmTopic(self, drone)
        self._trigger = import_module("std_srvs.srv").Trigger
        ros_node.create_service(self._trigger, "stop", self._stop)
        header = import_module("std_msgs.msg").Header
        subscribe(ros_node, header, "link", self._heard)
        self._map: RosObject = None
        self._camera: SceneCamera | None = None
        if isinstance(self.machine, Omni):
            self._offer(self.machine)

    def _offer(self, omni: Omni) -> None:
        """Open what an omni offers besides."""
        text = import_module("std_msgs.msg").String
        self._voice = publisher(self.node, text, "among/say")
        subscribe(self.node, text, "among/hear", self._told)
        self._map = publish_map(self.node, omni, load_ros().qos)
        twist = import_module("geometry_msgs.msg").Twist
        subscribe(self.node, twist, "cmd_vel", self._velocity)

    def show(self, world: SimulatedWorld, draw: DrawJpeg) -> None:
        """Let others look at it from now on."""
        self._camera = SceneCamera(self.node, self.id, world, draw)

    def close(self) -> None:
        """Leave the graph."""
        if self._camera is not None:
            self._camera.close()
        self.node.destroy_node()

    # ---- time ----

    def now_s(self) -> float:
        """Return the present on the machine's clock."""
        return self._clock.now_s()

    def when_s(self, stamp: RosObject) -> float:
        """Return when something stamped was said, on the machine's clock."""
        return self._clock.past_s(_ns(stamp))

    def start_s(self, stamp: RosObject) -> float | None:
        """Return a common start on the machine's clock; None when none was given."""
        return self._clock.coming_s(_ns(stamp)) if _ns(stamp) else None

    @property
    def due_s(self) -> float:
        """When it wants its next turn, on the machine's clock."""
        return self._due_s

    def step(self) -> None:
        """Step the machine, if it is time; what there is to tell is told at its next `turn`.

        Telling takes longer than stepping. Robots of one process that begin together are all
        stepped before any of them speaks.
        """
        now_s = self.now_s()
        if now_s < self._due_s or self._stepped is not None:
            return
        at_work = self.machine.moving and now_s >= self.machine.start_s
        self._due_s = now_s + (STEP_S if at_work else AT_REST_STEP_S)
        if now_s < self.machine.start_s < self._due_s:
            self._due_s = self.machine.start_s  # a common start is for all at once
        self.machine.step(now_s)
        if self._waits and now_s >= self.machine.start_s:
            self._waits = False
            self._starts.moved(self.id, time.time_ns())
        self._stepped = now_s, self.node.get_clock().now()

    def turn(self) -> None:
        """Step the machine if it is time, and tell what there is to tell."""
        self.step()
        if self._stepped is None:
            return
        (now_s, stepped), self._stepped = self._stepped, None
        stamp = stepped.to_msg()
        if self.machine.moving and self._watch.lost(now_s):
            self.machine.link_lost(now_s)
        self._tell_note()
        if not self.linked:
            return
        self._goals.turn(now_s)
        if self._swarm is not None:
            self._swarm.turn(now_s, stamp)
        if self._reports.due(now_s):
            self._reports.publish(now_s, stamp)
        if self._camera is not None:
            self._camera.turn(now_s, stamp)

    def cut_link(self, now_s: float) -> None:
        """Cut its radio; the machine holds or lands by itself."""
        if self.linked:
            self.machine.cut_link(now_s)
            self.linked = False

    def mend_link(self, now_s: float) -> None:
        """Mend its radio."""
        if not self.linked:
            self.machine.mend_link(now_s)
            self.linked = True

    def began(self, skill: str, goal: str) -> None:
        """Take down that the machine begins to act."""
        self._count += 1
        self._waits = True
        self._watch.begin(self.now_s())
        self._log.add(self.id, skill, goal, self._count)
        self._due_s = 0.0

    def _tell_note(self) -> None:
        """Log what the machine did of its own accord: landed because a peer was lost."""
        note = self.machine.note
        if note != self._noted:
            self._noted = note
            if note:
                self.node.get_logger().warning(note)

    # ---- what rclpy calls ----

    def _heard(self, header: RosObject) -> None:
        if self.linked:
            self._watch.heard(self.when_s(header.stamp))

    def _told(self, words: RosObject) -> None:
        """Take on a strategy, and say so: what the robot's own node does among other robots."""
        said = answer(self.machine, words.data.encode()) if self.linked else None
        if said is not None:
            self._voice.publish(type(words)(data=said.decode()))

    def _stop(self, _request: RosObject, response: RosObject) -> RosObject:
        response.success = self.linked
        response.message = "coming to rest" if self.linked else "no link"
        if self.linked:
            self.machine.halt(self.now_s())
            self._due_s = 0.0
        return response

    def _velocity(self, twist: RosObject) -> None:
        if not self.linked or not isinstance(self.machine, Omni):
            return
        moved = self.machine.moving
        velocity = twist.linear.x, twist.linear.y, twist.angular.z
        try:
            self.machine.set_velocity(*velocity, self.now_s())
        except ActivityRefused as cannot:
            self.node.get_logger().warning(cannot.reason, throttle_duration_sec=1.0)
            return
        if not moved and self.machine.moving:
            self.began("drive", "-")


def _ns(stamp: RosObject) -> int:
    return int(stamp.sec) * SECOND_NS + int(stamp.nanosec)
