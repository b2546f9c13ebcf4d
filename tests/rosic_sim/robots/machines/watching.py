"""Step a machine and look at it after every step: what must hold always, is checked always."""

from __future__ import annotations

from math import hypot, isfinite
from typing import TYPE_CHECKING

from rosic_sim.robots.machines.activity import ActivityState
from rosic_sim.robots.machines.flight import ACCELERATION_M_S2 as FLIGHT_M_S2
from rosic_sim.robots.machines.flight import CLIMB_M_S, CLIMB_M_S2
from rosic_sim.robots.machines.flight import SPEED_LIMIT_M_S as FLIGHT_M_S
from rosic_sim.robots.machines.mecanum import (
    BRAKING_M_S2,
    SPEED_LIMIT_M_S,
    YAW_BRAKING_RAD_S2,
    YAW_LIMIT_RAD_S,
    rim_speed_m_s,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from rosic_sim.robots.machines.crazyflie import Crazyflie
    from rosic_sim.robots.machines.joints import JointGroup
    from rosic_sim.robots.machines.omni import Omni
    from rosic_sim.robots.machines.stepped_machine import SteppedMachine

STEP_S = 0.01
SLACK = 1e-6


class JointWatch:
    """Ranges, speeds and accelerations of a group of joints, measured from its positions too."""

    def __init__(self, joints: JointGroup) -> None:
        self.joints = joints
        self.velocities: Sequence[float] = joints.velocities
        self.positions: Sequence[float] = joints.positions
        self.fastest = 0.0

    def check(self, dt_s: float) -> None:
        joints = self.joints
        for index, limit in enumerate(joints.limits):
            angle, speed = joints.positions[index], joints.velocities[index]
            assert limit.lower_rad - SLACK <= angle <= limit.upper_rad + SLACK
            assert abs(speed) <= limit.speed_rad_s + SLACK
            change = abs(speed - self.velocities[index])
            assert change <= limit.braking_rad_s2 * dt_s + SLACK
            travelled = abs(angle - self.positions[index])
            assert travelled <= limit.speed_rad_s * dt_s + SLACK
            self.fastest = max(self.fastest, abs(speed) / limit.speed_rad_s)
        self.velocities, self.positions = joints.velocities, joints.positions


class BaseWatch:
    """Speed and acceleration of the omni base, and its odometry against them."""

    def __init__(self, omni: Omni) -> None:
        self.base = omni.base
        self.velocity = omni.base.velocity
        self.pose = (omni.base.x_m, omni.base.y_m, omni.base.yaw_rad)

    def check(self, dt_s: float) -> None:
        base, before = self.base, self.velocity
        now = base.velocity
        assert rim_speed_m_s(now) <= SPEED_LIMIT_M_S + SLACK
        assert abs(now.yaw_rad_s) <= YAW_LIMIT_RAD_S + SLACK
        change = hypot(now.x_m_s - before.x_m_s, now.y_m_s - before.y_m_s)
        assert change <= BRAKING_M_S2 * dt_s + SLACK
        assert abs(now.yaw_rad_s - before.yaw_rad_s) <= YAW_BRAKING_RAD_S2 * dt_s + SLACK
        way = hypot(base.x_m - self.pose[0], base.y_m - self.pose[1])
        assert way <= SPEED_LIMIT_M_S * dt_s + SLACK
        assert abs(base.yaw_rad - self.pose[2]) <= YAW_LIMIT_RAD_S * dt_s + SLACK
        self.velocity = now
        self.pose = (base.x_m, base.y_m, base.yaw_rad)


class FlightWatch:
    """Speed and acceleration of a drone in the air."""

    def __init__(self, drone: Crazyflie) -> None:
        self.drone = drone
        self.velocity = (0.0, 0.0, 0.0)

    def check(self, dt_s: float) -> None:
        flight = self.drone.flight
        now = (flight.vx_m_s, flight.vy_m_s, flight.height.velocity)
        before, self.velocity = self.velocity, now
        assert flight.height.position >= -1e-9
        if not self.drone.airborne:
            return  # standing on the ground: touching down stops a drift
        assert hypot(now[0], now[1]) <= FLIGHT_M_S + SLACK
        assert abs(now[2]) <= CLIMB_M_S + SLACK
        change = hypot(now[0] - before[0], now[1] - before[1])
        assert change <= FLIGHT_M_S2 * dt_s + SLACK
        assert abs(now[2] - before[2]) <= CLIMB_M_S2 * dt_s + SLACK


class Watched:
    """One machine under watch.

    Attributes:
        now_s: Present time.
        stages: Every stage seen of the present activity, in order.
    """

    def __init__(
        self, machine: SteppedMachine, *watches: JointWatch | BaseWatch | FlightWatch
    ) -> None:
        self.machine = machine
        self.watches = watches
        self.now_s = 0.0
        self.stages: list[str] = []
        self.also: list[Callable[[], None]] = []
        self._seen: tuple[int, ActivityState, float] | None = None
        machine.step(0.0)

    def run(self, duration_s: float, step_s: float = STEP_S) -> None:
        """Step for a while and check after each step."""
        end_s = self.now_s + duration_s
        while self.now_s < end_s - 1e-9:
            self.step(min(step_s, end_s - self.now_s))

    def step(self, dt_s: float = STEP_S) -> None:
        """Step once and check."""
        self.now_s += dt_s
        self.machine.step(self.now_s)
        for watch in self.watches:
            watch.check(dt_s)
        for check in self.also:
            check()
        self._check_activity()

    def to_rest(self, limit_s: float = 60.0) -> None:
        """Step until nothing moves."""
        end_s = self.now_s + limit_s
        while self.machine.moving:
            assert self.now_s < end_s, "it does not come to rest"
            self.step()
        assert self.machine.at_rest()

    def to_end(self, limit_s: float = 60.0) -> None:
        """Step until the activity has ended."""
        end_s = self.now_s + limit_s
        activity = self.machine.activity
        while activity is not None and activity.running:
            assert self.now_s < end_s, "it does not end"
            self.step()

    def do(self, skill: str, **arguments: float | str) -> None:
        """Begin a skill and step until nothing moves."""
        self.stages.clear()
        self.machine.begin(skill, arguments, self.now_s)
        self.to_rest()

    def _check_activity(self) -> None:
        activity = self.machine.activity
        if activity is None:
            return
        assert 0.0 <= activity.fraction <= 1.0
        assert (activity.fraction == 1.0) == (activity.state is ActivityState.DONE)
        assert all(isfinite(value) for value in activity.facts.values())
        if self._seen is not None and self._seen[0] == activity.number:
            _, state, fraction = self._seen
            assert activity.fraction >= fraction, "a fraction fell"
            assert state is ActivityState.RUNNING or activity.state is state, (
                "a final state changed"
            )
        self._seen = (activity.number, activity.state, activity.fraction)
        if activity.stage and (not self.stages or self.stages[-1] != activity.stage):
            self.stages.append(activity.stage)
