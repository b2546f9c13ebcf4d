"""All or none: when one of those that are to begin together does not, the others do not go on."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Final

from rosic.core.order import NEVER_BEGUN, Ending
from rosic.features.fleet import company_messages as words
from rosic.gateway.order_execution import SHUT_DOWN

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.clock import Clock
    from rosic.core.order import Order, Outcome
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.components import Components
    from rosic.gateway.order_execution import OrderExecutor

AT_THE_END: Final = frozenset({SHUT_DOWN, NEVER_BEGUN})
ACTED: Final = frozenset({Ending.DONE, Ending.SENT})


class AllOrNothingStart:
    """The orders of one common start, of all or of none, until they have ended.

    That all are ready is seen before any is asked. One may still turn its order down, hear of it
    too late, or be stopped before the moment has come: then the others are ended like any order
    that is cut off. Whoever waits for the moment never moves; whoever has begun comes to rest.
    """

    def __init__(
        self, rooms: Components, lives: OrderExecutor, clock: Clock, orders: Sequence[Order]
    ) -> None:
        self._rooms = rooms
        self._lives = lives
        self._clock = clock
        self._open: dict[RobotId, Order] = {order.robot: order for order in orders}
        self._cutting: list[asyncio.Task[None]] = []

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Hear how one has ended, once that is on disk."""
        del self._open[order.robot]
        if not self._cutting and self._never_began(order, outcome):
            reason = words.did_not_begin(self._rooms.profiles[order.robot].shown)
            self._cutting = [
                asyncio.create_task(self._lives.cut_order(robot, other.cid, reason))
                for robot, other in self._open.items()
                if not self._rooms.board[robot].latched  # a stop sees to it, and says so better
            ]

    def _never_began(self, order: Order, outcome: Outcome) -> bool:
        """Tell whether it has not moved; once it has, how it ends is its own affair."""
        if outcome.note in AT_THE_END:
            return False  # ROSIC ends them all, and each says so itself
        if outcome.ending is Ending.REFUSED:
            return True
        early = self._clock.monotonic_ns() < (order.start_ns or 0)
        return early and outcome.ending not in ACTED
