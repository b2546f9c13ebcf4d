"""What drones of one swarm tell each other, whichever processes they run in."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from rosic_sim.robots.machines.swarm import Sighting
from rosic_sim.ros2.ends import DEPTH, publisher, subscribe
from rosic_sim.ros2.offers import INTERFACES

if TYPE_CHECKING:
    from rosic.robots.ros2.client.rclpy_import import RosObject
    from rosic_sim.robots.machines.crazyflie import Crazyflie
    from rosic_sim.ros2.machine_node import MachineNode

TOPIC = "/crazyflies/state"
FLYING_EVERY_S = 0.05
ON_THE_GROUND_EVERY_S = 0.2


class SwarmTopic:
    """One drone's voice in the swarm, and its ears.

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

    def _message(self, seen: Sighting, stamp: RosObject) -> RosObject:
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
            Sighting(
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
