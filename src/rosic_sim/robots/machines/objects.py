"""Things that can be held, and what holds them."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import dist
from typing import TypeAlias

from rosic_sim.robots.machines.joints import Axis

Position: TypeAlias = tuple[float, float, float]

GRAVITY_M_S2 = 9.81
# Assumed: rubber pads on cardboard or plastic; and lifting may accelerate by this much.
FRICTION = 0.3
LIFT_M_S2 = 1.0


@dataclass(slots=True)
class SimulatedObject:
    """Something with a mass.

    Attributes:
        frame: Robot in whose base frame the position is given.
        position_m: Where its centre is, or was when it was picked up.
        width_m: Between the fingers.
        holders: Grippers that hold it now.
    """

    name: str
    frame: str
    position_m: Position
    mass_kg: float
    width_m: float
    holders: set[str] = field(default_factory=set)

    def come_to(self, position_m: Position) -> None:
        """Be at another place, where what holds it has brought it."""
        self.position_m = position_m

    @property
    def force_needed_n(self) -> float:
        """Force of two fingers below which it slips when lifted: m (g + a) / (2 mu)."""
        return self.mass_kg * (GRAVITY_M_S2 + LIFT_M_S2) / (2.0 * FRICTION)


class SimulatedObjects:
    """All things of a world, by name."""

    def __init__(self, things: tuple[SimulatedObject, ...] = ()) -> None:
        self._things = {thing.name: thing for thing in things}

    def get(self, name: str) -> SimulatedObject | None:
        """Return a thing, or None when there is none of this name."""
        return self._things.get(name)

    def add(self, thing: SimulatedObject) -> None:
        """Put a thing into the world; one of the same name is replaced."""
        self._things[thing.name] = thing

    def remove(self, name: str) -> None:
        """Take a thing out of the world, out of any hand; unknown names are ignored."""
        self._things.pop(name, None)

    def near(self, frame: str, position_m: Position, within_m: float) -> SimulatedObject | None:
        """Return the nearest thing within reach of a place, or None."""
        found = [
            (dist(thing.position_m, position_m), name)
            for name, thing in self._things.items()
            if thing.frame == frame
        ]
        reachable = [entry for entry in found if entry[0] <= within_m]
        return self._things[min(reachable)[1]] if reachable else None

    def held_by(self, gripper: str) -> SimulatedObject | None:
        """Return what a gripper holds, or None."""
        for thing in self._things.values():
            if gripper in thing.holders:
                return thing
        return None


class Gripper:
    """A parallel gripper with two fingers.

    Attributes:
        name: As it appears in `SimulatedObject.holders`.
        force_n: Set while closed on something, else 0.
    """

    def __init__(
        self, name: str, opening_m: float, speed_m_s: float, things: SimulatedObjects
    ) -> None:
        self.name = name
        self.opening_m = opening_m
        self.force_n = 0.0
        self._things = things
        # Assumed: the fingers reach their speed in 20 ms.
        self._axis = Axis(opening_m, speed_m_s, speed_m_s / 0.02)
        self._closing_on: SimulatedObject | None = None
        self._closing_n = 0.0

    @property
    def width_m(self) -> float:
        """Measured distance between the fingers."""
        return self._axis.position

    @property
    def speed_m_s(self) -> float:
        """Measured; negative while closing."""
        return self._axis.velocity

    @property
    def still(self) -> bool:
        """True when the fingers are where they were told to be."""
        return self._axis.arrived

    @property
    def held(self) -> SimulatedObject | None:
        """What it holds."""
        return self._things.held_by(self.name)

    def take(self, thing: SimulatedObject, force_n: float) -> None:
        """Hold a thing from the start: for building a world, not a motion."""
        self._axis.place(thing.width_m)
        self.force_n = force_n
        thing.holders.add(self.name)

    def close(self, force_n: float, between: SimulatedObject | None) -> None:
        """Close with a force on what is between the fingers, or until they meet."""
        self._closing_on = between
        self._closing_n = force_n
        self._axis.aim(between.width_m if between is not None else 0.0)

    def open(self) -> None:
        """Let go of everything, at once, and open."""
        held = self.held
        if held is not None:
            held.holders.discard(self.name)
        self._closing_on = None
        self.force_n = 0.0
        self._axis.aim(self.opening_m)

    def lose(self) -> None:
        """Let what is held slip away; the fingers go on closing and meet."""
        held = self.held
        if held is not None:
            held.holders.discard(self.name)
        self._closing_on = None
        self.force_n = 0.0
        self._axis.aim(0.0)

    def stop(self) -> None:
        """Stay as it is: fingers in motion stop, what is held stays held."""
        if self.still:
            return
        self._closing_on = None
        self._axis.freeze()

    def step(self, dt_s: float) -> None:
        """Advance by one step; contact makes it a holder."""
        if self._axis.arrived:
            return
        self._axis.step(dt_s)
        thing = self._closing_on
        if thing is not None and self._axis.arrived:
            self._closing_on = None
            if self._things.get(thing.name) is thing:
                thing.holders.add(self.name)
                self.force_n = self._closing_n
