"""A differential base that follows a way: turn towards the next corner, go there, turn as asked."""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin, sqrt

from rosic_sim.ros2_others.room import Place, length, way

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
