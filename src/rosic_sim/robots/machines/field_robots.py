"""Machines that work outside the room: one that feels heat, one that may get stuck."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rosic.core.i18n import said
from rosic_sim.robots.machines.activity import ActivityState
from rosic_sim.robots.machines.omni import Omni

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic_sim.robots.machines.arguments import MachineArguments
    from rosic_sim.robots.machines.stepped_machine import Recipe

AIR_C = 21.0
RECALIBRATING_S = 1.5
SINKS_IN_M = 0.15


class Fire(NamedTuple):
    """Something that burns.

    Attributes:
        heat_c: By how much the air is warmer right beside it; half of that 1 m away.
    """

    x_m: float
    y_m: float
    heat_c: float


class FireWatcher(Omni):
    """An omni that measures how warm the air is, by a sensor that drifts. See `Omni`.

    Besides its skills: ``recalibrate``, which takes the drift away.

    Attributes:
        drift_c: What the sensor adds to the truth.
        hearths: What burns around it.
    """

    def __init__(self, robot: str) -> None:
        super().__init__(robot)
        self.drift_c = 0.0
        self.hearths: list[Fire] = []
        self._plans["recalibrate"] = self._plan_recalibrate

    def drift_by(self, off_c: float) -> None:
        """Let the sensor add this much to the truth from now on."""
        self.drift_c = off_c

    def kindle(self, fire: Fire) -> None:
        """Let something burn, unless it burns already."""
        if fire not in self.hearths:
            self.hearths.append(fire)

    def put_out(self) -> None:
        """Let nothing burn any more."""
        self.hearths.clear()

    def _plan_recalibrate(self, _asked: MachineArguments) -> Recipe:
        return self._recipe_recalibrate()

    def _recipe_recalibrate(self) -> Recipe:
        self._stage(said("comparing with the reference"))
        end_s = self._time_s + RECALIBRATING_S
        while self._time_s < end_s:
            self._advance(1.0 - (end_s - self._time_s) / RECALIBRATING_S)
            yield
        off_c, self.drift_c = self.drift_c, 0.0
        return said("recalibrated; the sensor was {off_c:.1f} °C off", off_c=off_c)

    def heat_c(self) -> float:
        """Return how warm the air is, as its sensor has it."""
        base = self.base
        heat_c = AIR_C + self.drift_c
        for hearth in self.hearths:
            square = (hearth.x_m - base.x_m) ** 2 + (hearth.y_m - base.y_m) ** 2
            heat_c += hearth.heat_c / (1.0 + square)
        return heat_c

    def telemetry(self) -> Mapping[str, float | str]:
        """As an omni's, and the heat."""
        return {**super().telemetry(), "heat_c": self.heat_c()}


class Rover(Omni):
    """An omni on soft ground. See `Omni`.

    Attributes:
        mud: The ground gives way: whatever it begins ends after some centimetres, without success.
    """

    def __init__(self, robot: str, pose: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        super().__init__(robot, pose)
        self.mud = False

    def enter_mud(self) -> None:
        """Have soft ground under it from now on."""
        self.mud = True

    def leave_mud(self) -> None:
        """Have firm ground under it again."""
        self.mud = False

    def _watch(self) -> None:
        super()._watch()
        if self.mud and self._recipe is not None and self._measured()["distance_m"] > SINKS_IN_M:
            self._end(ActivityState.FAILED, said("stuck: the wheels turn, and nothing moves"))
            self._brake()
