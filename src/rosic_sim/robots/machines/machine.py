"""What every simulated machine promises."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic_sim.robots.machines.activity import Activity
    from rosic_sim.robots.machines.arguments import Value


# ---- battery ----

# A battery as a fraction of full.


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

    def charge_to(self, fraction: float) -> None:
        """Hold this much of a full charge from now on: more than before, or less."""
        self.fraction = fraction

    @property
    def percent(self) -> int:
        """Whole per cent, rounded down: 19.9 % is never shown as 20 %."""
        return int(self.fraction * 100.0 + 1e-9)


# ---- machine ----


class Machine(Protocol):
    """One simulated robot.

    Times are seconds on any one monotonic scale; the first call sets its zero. An earlier time
    than the last one changes nothing. Values are SI, axes follow REP 103.

    Attributes:
        id: As in the robot's profile.
        activity: The present or last activity; None before the first.
        note: What the machine last did of its own accord, as a sentence; empty if nothing.
    """

    id: str
    activity: Activity | None
    note: str

    @property
    def moving(self) -> bool:
        """True while `step` has something to do; a hovering drone moves."""
        ...

    @property
    def holding(self) -> bool | None:
        """Whether it keeps its place without being at rest; None: it only ever does so at rest."""
        ...

    def begin(
        self,
        skill: str,
        arguments: Mapping[str, Value],
        now_s: float,
        start_s: float | None = None,
    ) -> Activity:
        """Begin a skill.

        Args:
            skill: A key of the machine's skills.
            arguments: SI values; what is missing takes the machine's default.
            now_s: The present.
            start_s: Motion begins at exactly this time (a common start): at most 60 s ahead, or
                0.1 s past, and then at once. Until then the activity runs with the stage "waiting".

        Returns:
            The activity, running (or done, when there is nothing to do).

        Raises:
            ActivityRefused: Unknown skill, bad argument, busy, not at rest after a stop, battery
                too low, out of reach, not flying, too late for the common start. The machine has
                not moved and will not.
        """
        ...

    def step(self, now_s: float) -> None:
        """Integrate from the last step to ``now_s`` in substeps of at most 10 ms."""
        ...

    def halt(self, now_s: float) -> None:
        """Come to rest within the machine's limits; a drone lands where it is.

        A running activity is cancelled at once; its facts are completed when rest is reached.
        Grippers keep what they hold. Always obeyed, any number of times.
        """
        ...

    def link_lost(self, now_s: float) -> None:
        """Do what the machine does by itself without a link: hold, or land."""
        ...

    def at_rest(self) -> bool:
        """Tell, from measured speeds, whether nothing moves; a drone: on the ground, motors off."""
        ...

    def telemetry(self) -> Mapping[str, float | str]:
        """Return the newest measurements; the keys of one machine never change."""
        ...
