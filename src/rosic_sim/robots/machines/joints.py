"""A group of joints that start and arrive together."""

from __future__ import annotations

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- motion ----

# One axis that moves under limits on speed and acceleration.

NEGLIGIBLE = 1e-9


def braking_speed(distance: float, speed: float, deceleration: float, dt_s: float) -> float:
    """Return the highest speed after ``dt_s`` from which rest is still reached in ``distance``.

    The step is integrated with the mean of the old and the new speed, so an axis that follows
    this law arrives without overshoot for any pattern of steps: after each step the way left is
    at least speed^2 / (2 deceleration).

    Args:
        distance: Way left, not negative.
        speed: Present speed towards the goal; negative when moving away.
        deceleration: Greater than 0.
        dt_s: Length of the step.
    """
    room = distance - 0.5 * speed * dt_s
    if room <= 0.0:
        return 0.0
    half = 0.5 * deceleration * dt_s
    return sqrt(half * half + 2.0 * deceleration * room) - half


def approach(value: float, goal: float, most: float) -> float:
    """Move ``value`` towards ``goal`` by at most ``most``."""
    if goal > value:
        return min(goal, value + most)
    return max(goal, value - most)


class Axis:
    """A coordinate that follows trapezoidal speed profiles to a target.

    Guarantees after every `step`: the speed has changed by at most ``acceleration * dt_s``; it
    exceeds ``speed_limit`` only while it comes down from an earlier, higher limit; a target that
    does not change while the axis rests or moves towards it is met exactly and without overshoot.
    """

    __slots__ = ("acceleration", "position", "speed_limit", "target", "velocity")

    def __init__(self, position: float, speed_limit: float, acceleration: float) -> None:
        self.position = position
        self.velocity = 0.0
        self.target = position
        self.speed_limit = speed_limit
        self.acceleration = acceleration

    @property
    def arrived(self) -> bool:
        """True when at the target and at rest."""
        return self.velocity == 0.0 and self.position == self.target

    def aim(self, target: float) -> None:
        """Move to a target from now on."""
        self.target = target

    def place(self, position: float) -> None:
        """Be somewhere from the start: for building a world, not a motion."""
        self.position = self.target = position

    def freeze(self) -> None:
        """Be at rest here, at once."""
        self.velocity = 0.0
        self.target = self.position

    def step(self, dt_s: float) -> None:
        """Advance by one step."""
        error = self.target - self.position
        sign = 1.0 if error > 0.0 or (error == 0.0 and self.velocity > 0.0) else -1.0
        speed = self.velocity * sign
        most = self.acceleration * dt_s
        wanted = min(self.speed_limit, braking_speed(abs(error), speed, self.acceleration, dt_s))
        if abs(speed) <= most and (wanted == 0.0 or abs(error) < NEGLIGIBLE):
            # The last step of a braking: less than one step's way is left, or only rounding.
            self.position = self.target
            self.velocity = 0.0
            return
        new = approach(speed, wanted, most)
        self.position += 0.5 * (speed + new) * sign * dt_s
        self.velocity = new * sign

    def brake(self, dt_s: float, deceleration: float) -> None:
        """Advance by one step towards rest; at rest, here becomes the target."""
        new = approach(self.velocity, 0.0, deceleration * dt_s)
        self.position += 0.5 * (self.velocity + new) * dt_s
        self.velocity = new
        if new == 0.0:
            self.target = self.position


# ---- joints ----

STILL_RAD_S = 0.001
NEGLIGIBLE_RAD = 1e-6


class MachineJointLimit(NamedTuple):
    """What one joint can do.

    Attributes:
        lower_rad, upper_rad: Range.
        speed_rad_s: Highest speed.
        acceleration_rad_s2: In ordinary motion.
        braking_rad_s2: When stopped.
    """

    lower_rad: float
    upper_rad: float
    speed_rad_s: float
    acceleration_rad_s2: float
    braking_rad_s2: float


class JointGroup:
    """Joints moved point to point along a straight line in joint space.

    One phase drives them all, so they start, arrive, and also brake together and on their line.
    As the range is convex and both ends lie in it, no joint leaves its range at any time.

    Attributes:
        positions, velocities: Measured, rad and rad/s; replaced, never changed in place.
    """

    def __init__(self, limits: Sequence[MachineJointLimit], positions: Sequence[float]) -> None:
        self.limits = tuple(limits)
        self.positions = tuple(positions)
        self.velocities = (0.0,) * len(self.limits)
        self._origin = self.positions
        self._delta = self.velocities
        self._phase = Axis(0.0, 1.0, 1.0)
        self._braking = 0.0
        self._halted = False
        self._still = True

    @property
    def at_rest(self) -> bool:
        """True when every joint is slower than ``STILL_RAD_S``."""
        return self._still or all(abs(v) < STILL_RAD_S for v in self.velocities)

    @property
    def still(self) -> bool:
        """True when nothing will change without a new target."""
        return self._still

    @property
    def progress(self) -> float:
        """Part of the present line that is done, in [0, 1]."""
        return 1.0 if self._still and not self._halted else self._phase.position

    def outside(self, targets: Sequence[float]) -> int | None:
        """Return the index of the first target that is out of its joint's range, or None."""
        for index, (target, limit) in enumerate(zip(targets, self.limits, strict=True)):
            if not limit.lower_rad <= target <= limit.upper_rad:
                return index
        return None

    def go(self, targets: Sequence[float], share: float) -> None:
        """Set out for ``targets``; only when still.

        Args:
            targets: One per joint, in range.
            share: Part of the speed limits to use, in (0, 1].

        Raises:
            ValueError: Out of range, or a motion is under way. Nothing has changed.
        """
        if not self._still or self.outside(targets) is not None:
            raise ValueError("the joints are in motion, or a target is out of range")
        self._origin = self.positions
        self._delta = tuple(t - p for t, p in zip(targets, self.positions, strict=True))
        ways = [
            (abs(delta), limit)
            for delta, limit in zip(self._delta, self.limits, strict=True)
            if abs(delta) > NEGLIGIBLE_RAD
        ]
        self._halted = False
        if not ways:
            self.positions = tuple(targets)
            return
        speed = share * min(limit.speed_rad_s / way for way, limit in ways)
        acceleration = min(limit.acceleration_rad_s2 / way for way, limit in ways)
        self._phase = Axis(0.0, speed, acceleration)
        self._phase.aim(1.0)
        self._braking = min(limit.braking_rad_s2 / way for way, limit in ways)
        self._still = False

    def brake(self) -> None:
        """Come to rest along the line, as fast as the limits allow."""
        if not self._still:
            self._halted = True

    def step(self, dt_s: float) -> None:
        """Advance by one step."""
        if self._still:
            return
        phase = self._phase
        if self._halted:
            phase.brake(dt_s, self._braking)
            self._still = phase.velocity == 0.0
        else:
            phase.step(dt_s)
            self._still = phase.arrived
        # Braking from near the end may pass it by less than one step's way: stay on the line.
        part = min(phase.position, 1.0)
        rate = phase.velocity
        self.positions = tuple(o + part * d for o, d in zip(self._origin, self._delta, strict=True))
        self.velocities = tuple([rate * d for d in self._delta])
