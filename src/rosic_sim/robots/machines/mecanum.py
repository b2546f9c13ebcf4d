"""A base on four mecanum wheels: velocities in, odometry out."""

from __future__ import annotations

from math import cos, hypot, sin
from typing import NamedTuple

# KUKA youBot: highest platform speed 0.8 m/s (KUKA youBot User Manual, "Technical data").
SPEED_LIMIT_M_S = 0.8
# KUKA youBot User Manual, drawings: wheel base 0.471 m, track 0.300 m; half of their sum is the
# lever between turning and the speed of a wheel's rim.
LEVER_M = 0.5 * (0.471 + 0.300)
# Assumed: not in the manual.
YAW_LIMIT_RAD_S = 1.5
ACCELERATION_M_S2 = 0.7
YAW_ACCELERATION_RAD_S2 = 2.0
BRAKING_M_S2 = 2.0
YAW_BRAKING_RAD_S2 = 5.0
STILL_M_S = 0.001
STILL_RAD_S = 0.001


class Velocity(NamedTuple):
    """In the base's own frame: x forward, y to the left, yaw counter-clockwise."""

    x_m_s: float
    y_m_s: float
    yaw_rad_s: float


REST = Velocity(0.0, 0.0, 0.0)


def rim_speed_m_s(velocity: Velocity) -> float:
    """Return the speed of the fastest wheel's rim, which is what the motors limit."""
    return abs(velocity.x_m_s) + abs(velocity.y_m_s) + LEVER_M * abs(velocity.yaw_rad_s)


def within_limits(velocity: Velocity) -> Velocity:
    """Scale a velocity down, keeping its direction, to what the wheels can do."""
    rim = rim_speed_m_s(velocity)
    yaw = abs(velocity.yaw_rad_s)
    scale = 1.0
    if rim > SPEED_LIMIT_M_S:
        scale = SPEED_LIMIT_M_S / rim
    if yaw * scale > YAW_LIMIT_RAD_S:
        scale = YAW_LIMIT_RAD_S / yaw
    return Velocity(velocity.x_m_s * scale, velocity.y_m_s * scale, velocity.yaw_rad_s * scale)


class MecanumBase:
    """The drive of the base.

    Follows a wanted velocity with bounded acceleration, in a straight line through velocity
    space: as the set that the wheels allow is convex, every velocity on the way is allowed too.
    The pose is integrated from the velocity actually reached.

    Attributes:
        x_m, y_m, yaw_rad: Odometry; yaw counts turns, it does not wrap.
        velocity: Reached.
        distance_m: Way of the centre since the beginning, never falling.
    """

    def __init__(self, x_m: float, y_m: float, yaw_rad: float) -> None:
        self.x_m = x_m
        self.y_m = y_m
        self.yaw_rad = yaw_rad
        self.velocity = REST
        self.distance_m = 0.0

    @property
    def still(self) -> bool:
        """True when the wheels stand."""
        return self.velocity == REST

    def at_rest(self) -> bool:
        """True when slower than 1 mm/s and 1 mrad/s."""
        x, y, yaw = self.velocity
        return hypot(x, y) < STILL_M_S and abs(yaw) < STILL_RAD_S

    def step(self, wanted: Velocity, dt_s: float, *, braking: bool = False) -> None:
        """Advance by one step towards a wanted velocity."""
        before = self.velocity
        linear, angular = ACCELERATION_M_S2, YAW_ACCELERATION_RAD_S2
        if braking:
            wanted, linear, angular = REST, BRAKING_M_S2, YAW_BRAKING_RAD_S2
        goal = within_limits(wanted)
        change = (goal[0] - before[0], goal[1] - before[1], goal[2] - before[2])
        share = 1.0
        way = hypot(change[0], change[1])
        if way > linear * dt_s:
            share = linear * dt_s / way
        turn = abs(change[2])
        if turn * share > angular * dt_s:
            share = angular * dt_s / turn
        after = goal
        if share < 1.0:
            after = Velocity(
                before[0] + share * change[0],
                before[1] + share * change[1],
                before[2] + share * change[2],
            )
        self.velocity = after
        self._integrate(before, after, dt_s)

    def _integrate(self, before: Velocity, after: Velocity, dt_s: float) -> None:
        x = 0.5 * (before.x_m_s + after.x_m_s) * dt_s
        y = 0.5 * (before.y_m_s + after.y_m_s) * dt_s
        turn = 0.5 * (before.yaw_rad_s + after.yaw_rad_s) * dt_s
        heading = self.yaw_rad + 0.5 * turn
        self.x_m += x * cos(heading) - y * sin(heading)
        self.y_m += x * sin(heading) + y * cos(heading)
        self.yaw_rad += turn
        self.distance_m += hypot(x, y)
