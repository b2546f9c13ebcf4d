"""Orders as a gateway would give them, for suites that begin at the robot."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING

from rosic.core.identity import command_id
from rosic.core.order import Order, Permit

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Argument

LIFETIME_NS = 5_000_000_000


class OrderBook:
    """Numbers the orders of one robot."""

    def __init__(self, profile: Profile, clock: Clock) -> None:
        self._profile = profile
        self._clock = clock
        self._n = count(1)

    def order(
        self,
        skill: str,
        arguments: dict[str, Argument] | None = None,
        *,
        n: int | None = None,
        fence: int = 1,
        stop_generation: int = 0,
        late_s: float = 0.0,
    ) -> Order:
        """Return an order that is good unless an argument makes it bad.

        Args:
            skill: A skill of the profile.
            arguments: SI.
            n: Instead of the next number.
            fence: The lease it is given under.
            stop_generation: The robot's when it was admitted.
            late_s: How long ago it expired; 0 for one that is fresh.
        """
        number = next(self._n) if n is None else n
        left_ns = -int(late_s * 1e9) if late_s else LIFETIME_NS
        permit = Permit(
            "p1", "k1", self._profile.id, skill, fence, False, stop_generation, 1
        )  # fmt: skip
        return Order(
            command_id("test", self._profile.id, str(number), str(fence)),
            self._profile.id,
            self._profile.skills[skill],
            dict(arguments or {}),
            number,
            self._clock.monotonic_ns() + left_ns,
            self._clock.wall_ns() + left_ns,
            permit,
        )
