"""A battery as a fraction of full."""

from __future__ import annotations


class Battery:
    """Drains linearly with time under load.

    Attributes:
        fraction: In [0, 1].
    """

    __slots__ = ("fraction",)

    def __init__(self, fraction: float = 1.0) -> None:
        self.fraction = fraction

    def drain(self, dt_s: float, full_lasts_s: float) -> None:
        """Use what a load takes in ``dt_s`` that would empty a full battery in ``full_lasts_s``."""
        self.fraction = max(0.0, self.fraction - dt_s / full_lasts_s)

    @property
    def percent(self) -> int:
        """Whole per cent, rounded down: 19.9 % is never shown as 20 %."""
        return int(self.fraction * 100.0 + 1e-9)
