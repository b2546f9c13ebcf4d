"""The last check before a robot acts: expiry, order number, fence, stop generation (I2-I5).

Every robot adapter owns one gate per robot and asks it immediately before acting. It is a value
machine, so that the simulation of histories in the tests drives the very same code.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Self

from rosic.core.i18n import said
from rosic.core.synchronised_start import misses_start
from rosic.errors import OrderVoid

if TYPE_CHECKING:
    from rosic.core.order import Order, Stop
    from rosic.core.robot.profile import RobotId


class OrderGate:
    """What one robot's side has seen. Its numbers never decrease (I13).

    Attributes:
        n: Highest order number that acted.
        fence: Highest fence seen.
        generation: Stop generation applied.
        latched: Stopped, until resumed.
    """

    __slots__ = ("fence", "generation", "latched", "n", "robot")

    def __init__(
        self,
        robot: RobotId,
        *,
        n: int,
        fence: int,
        generation: int,
        latched: bool,
    ) -> None:
        self.robot = robot
        self.n = n
        self.fence = fence
        self.generation = generation
        self.latched = latched

    @classmethod
    def new(cls, robot: RobotId) -> Self:
        """Return the gate of a robot that never had an order; for tests and trials."""
        return cls(robot, n=0, fence=0, generation=0, latched=False)

    def pass_order(
        self, order: Order, now_ns: int, wall_ns: int, *, together: bool = False
    ) -> None:
        """Let one order through, once, and remember its numbers.

        Args:
            order: Any order; one for another robot is void here.
            now_ns: Monotonic clock, the one ``order.deadline_ns`` was taken from.
            wall_ns: Wall clock, the one ``order.expires_ns`` was taken from.
            together: Whether this robot keeps a common start; most ways to a robot have no place
                for one, and what goes by them begins at once.

        Raises:
            OrderVoid: The robot must not act on it; nothing was remembered but a higher fence.
        """
        if order.robot != self.robot:
            raise OrderVoid(said("This order is for {robot}. Nothing was done.", robot=order.robot))
        permit = order.permit
        if permit.fence != self.fence:
            self.fence = max(self.fence, permit.fence)
        if order.skill.actuates:
            if self.latched or permit.stop_generation < self.generation:
                raise OrderVoid(
                    said("{robot} was stopped before this could begin.", robot=order.robot)
                )
            if permit.fence < self.fence:
                raise OrderVoid(
                    said("Somebody else has {robot} now. Nothing was done.", robot=order.robot)
                )
        if order.n <= self.n:
            raise OrderVoid(
                said("{robot} has already acted on a later command.", robot=order.robot)
            )
        late = now_ns > order.deadline_ns or wall_ns > order.expires_ns
        if late or (together and misses_start(order, now_ns, wall_ns)):
            raise too_late(order) if late else _misses_the_others(order)
        self.n = order.n

    def still_allows(self, order: Order) -> bool:
        """Whether an order that passed may go on: no stop has come (I5)."""
        if not order.skill.actuates:
            return True
        return not self.latched and order.permit.stop_generation >= self.generation

    def apply_stop(self, stop: Stop) -> None:
        """Latch. Applying the same stop again, or an older one, changes nothing."""
        if stop.generation > self.generation:
            self.generation = stop.generation
            self.latched = True

    def resume(self, generation: int) -> None:
        """Unlatch, if no later stop has come meanwhile."""
        if generation >= self.generation:
            self.latched = False


def _misses_the_others(order: Order) -> OrderVoid:
    return OrderVoid(
        said(
            "This reached {robot} too late to begin with the others. Nothing was done.",
            robot=order.robot,
        )
    )


def too_late(order: Order) -> OrderVoid:
    """Return the refusal of an order that has expired."""
    return OrderVoid(said("This reached {robot} too late. Nothing was done.", robot=order.robot))
