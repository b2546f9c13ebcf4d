"""What robots report, in the units that a profile shows it in."""

from __future__ import annotations

import logging
from math import pi
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from collections.abc import Mapping

_log = logging.getLogger(__name__)

PERCENT: Final = "%"
FULL: Final = 1.1
"""No share is larger: a battery may say 102 %."""
# Robots report SI, and a battery as a fraction (REP 103, sensor_msgs/BatteryState).
FACTORS: Final[Mapping[str, float]] = MappingProxyType(
    {
        PERCENT: 100.0,
        "deg": 180.0 / pi,
        "deg/s": 180.0 / pi,
        "cm": 100.0,
        "cm/s": 100.0,
        "mm": 1000.0,
        "mm/s": 1000.0,
        "km": 0.001,
        "km/h": 3.6,
    }
)


class UnitScale:
    """Turns one reported value into the profile's unit.

    Many a battery says its charge in per cent, against the definition of its message: one that has
    once said more than a fraction can be is read so for good, also when it is nearly empty. Before
    that it is known only where the profile says so.

    Attributes:
        guessed: It was taken for per cent though the profile says nothing of it.
    """

    def __init__(self, unit: str, what: str, full: float = 1.0) -> None:
        """Make it.

        Args:
            unit: As the profile shows it.
            what: Whose value, for the log.
            full: What a whole share is reported as.
        """
        self.guessed = False
        self._unit = unit
        self._what = what
        self._factor = FACTORS.get(unit, 1.0) / (full if unit == PERCENT else 1.0)
        self._guesses = unit == PERCENT and full == 1.0

    def __call__(self, value: float) -> float:
        """Return a finite value in the unit."""
        if self._guesses and not self.guessed and abs(value) > FULL:
            self._factor, self.guessed = 1.0, True
            _log.warning(
                "%s is %g, and no fraction of 1 as ROS defines it: taken for per cent from now on "
                "(its profile can say full: 100)",
                self._what,
                value,
            )
        return value * self._factor
