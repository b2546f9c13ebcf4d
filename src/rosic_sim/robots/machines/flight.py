"""How a drone moves through the air: a point with bounded speed and acceleration."""

from __future__ import annotations

from math import hypot

from rosic_sim.robots.machines.joints import Axis, braking_speed
from rosic_sim.robots.machines.swarm import RIGHT, Planar, SeparationBound, keep_apart

# Crazyflie firmware, platform defaults: PID_POS_VEL_X_MAX and _Z_MAX are 1.0 m/s, PID_VEL_ROLL_MAX
# is 20 degrees, which allows g tan 20 = 3.5 m/s2. Assumed: indoors less is used.
SPEED_LIMIT_M_S = 1.0
SPEED_M_S = 0.7
ACCELERATION_M_S2 = 2.0
CLIMB_M_S = 0.5
CLIMB_M_S2 = 1.0
STEADY_M_S = 0.02
NEAR_M = 0.005
# Assumed: slower than this for so long, though something else is wanted, is a corner.
STUCK_M_S = 0.1
STUCK_S = 1.5


class Flight:
    """Position and velocity of one drone.

    Horizontally it flies to ``goal``, or brakes to hover when there is none; vertically it
    follows ``height``. The change of horizontal velocity in a step is at most
    ``ACCELERATION_M_S2`` times its length, whatever is asked of it.

    Attributes:
        x_m, y_m: Measured.
        vx_m_s, vy_m_s: Measured.
        height: Vertical axis; 0 is the ground.
        goal: None means: come to rest here.
    """

    def __init__(self, x_m: float, y_m: float) -> None:
        self.x_m = x_m
        self.y_m = y_m
        self.vx_m_s = 0.0
        self.vy_m_s = 0.0
        self.height = Axis(0.0, CLIMB_M_S, CLIMB_M_S2)
        self.goal: Planar | None = None
        self._goal_velocity: Planar = (0.0, 0.0)
        self._fastest_m_s = SPEED_M_S
        self._side = RIGHT
        self._stuck_s = 0.0

    @property
    def speed_m_s(self) -> float:
        """Horizontal speed."""
        return hypot(self.vx_m_s, self.vy_m_s)

    @property
    def steady(self) -> bool:
        """True when hovering: neither drifting nor climbing."""
        return self.speed_m_s < STEADY_M_S and abs(self.height.velocity) < STEADY_M_S

    def left_m(self) -> float:
        """Horizontal way to the goal; 0 without one."""
        if self.goal is None:
            return 0.0
        return hypot(self.goal[0] - self.x_m, self.goal[1] - self.y_m)

    def rest_place(self) -> Planar:
        """Return where braking from here ends."""
        way = self.speed_m_s / (2.0 * ACCELERATION_M_S2)
        return (self.x_m + self.vx_m_s * way, self.y_m + self.vy_m_s * way)

    def fly_to(self, goal: Planar, height_m: float) -> None:
        """Fly to a place and a height from now on."""
        self.goal = goal
        self.height.aim(height_m)

    def chase(self, goal: Planar, velocity: Planar = (0.0, 0.0)) -> None:
        """Keep up with a goal that moves, as fast as can be: it may fly as fast as this one."""
        self.goal, self._goal_velocity, self._fastest_m_s = goal, velocity, SPEED_LIMIT_M_S

    def hold_place(self) -> None:
        """Come to rest here; the height is kept to."""
        self.goal, self._goal_velocity, self._fastest_m_s = None, (0.0, 0.0), SPEED_M_S

    def hover(self) -> None:
        """Come to rest here, at the height of now."""
        self.hold_place()
        self.height.aim(self.height.position)

    def touch_down(self) -> None:
        """Stand on the ground."""
        self.vx_m_s = self.vy_m_s = 0.0

    def step(self, dt_s: float, bounds: list[SeparationBound]) -> None:
        """Advance by one step, within what the peers allow."""
        self.height.step(dt_s)
        wanted = self._wanted(dt_s)
        allowed = keep_apart(wanted, bounds, self._side) if bounds else wanted
        self._follow(allowed, dt_s)
        self._look_for_a_way(wanted, dt_s)

    def _look_for_a_way(self, wanted: Planar, dt_s: float) -> None:
        """Try the other side after standing in a corner for a while; free again, the right."""
        free = hypot(*wanted) <= STUCK_M_S or self.goal is None
        if free or self.speed_m_s > STUCK_M_S:
            self._stuck_s = 0.0
            if free:
                self._side = RIGHT
            return
        self._stuck_s += dt_s
        if self._stuck_s > STUCK_S:
            self._stuck_s = 0.0
            self._side = -self._side

    def _wanted(self, dt_s: float) -> Planar:
        if self.goal is None:
            return (0.0, 0.0)
        x, y = self.goal[0] - self.x_m, self.goal[1] - self.y_m
        left = hypot(x, y)
        with_x, with_y = self._goal_velocity
        if left == 0.0:
            return (with_x, with_y)
        x, y = x / left, y / left
        towards = (self.vx_m_s - with_x) * x + (self.vy_m_s - with_y) * y
        # Half of the acceleration is for coming to rest, the rest for corrections.
        speed = braking_speed(left, towards, 0.5 * ACCELERATION_M_S2, dt_s)
        speed = min(self._fastest_m_s, speed)
        wanted = (with_x + x * speed, with_y + y * speed)
        over = hypot(*wanted) / self._fastest_m_s
        return wanted if over <= 1.0 else (wanted[0] / over, wanted[1] / over)

    def _follow(self, wanted: Planar, dt_s: float) -> None:
        x, y = wanted[0] - self.vx_m_s, wanted[1] - self.vy_m_s
        change = hypot(x, y)
        most = ACCELERATION_M_S2 * dt_s
        if change > most:
            x, y = x * most / change, y * most / change
        self.x_m += (self.vx_m_s + 0.5 * x) * dt_s
        self.y_m += (self.vy_m_s + 0.5 * y) * dt_s
        self.vx_m_s += x
        self.vy_m_s += y


def flight_time_s(way_m: float, climb_m: float) -> float:
    """Return how long an undisturbed flight takes at most."""
    across = way_m / SPEED_M_S + 2.0 * SPEED_M_S / ACCELERATION_M_S2
    up = abs(climb_m) / CLIMB_M_S + CLIMB_M_S / CLIMB_M_S2
    return across + up
