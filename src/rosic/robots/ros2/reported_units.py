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


class Scale:
    """Turns one reported value into the profile's unit.

    Many a battery says its charge in per cent, against the definition of its message: one that has
    once said more than a fraction can be is read so for good, also when it is nearly empty.
    """

    def __init__(self, unit: str, what: str) -> None:
        """Make it.

        Args:
            unit: As the profile shows it.
            what: Whose value, for the log.
        """
        self._unit = unit
        self._what = what
        self._factor = FACTORS.get(unit, 1.0)

    def __call__(self, value: float) -> float:
        """Return a finite value in the unit."""
        if self._unit == PERCENT and self._factor != 1.0 and abs(value) > FULL:
            self._factor = 1.0
            _log.warning(
                "%s is %g, and no fraction of 1 as ROS defines it: taken for per cent from now on",
                self._what,
                value,
            )
        return value * self._factor
