"""One axis that moves under limits on speed and acceleration."""

from __future__ import annotations

from math import sqrt

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
