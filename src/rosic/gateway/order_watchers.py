"""Who hears what becomes of orders: when a robot begins one, its steps, how it ended."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, Protocol

from rosic.core.signal import Signal
from rosic.errors import StillMoves

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.order import Order, Outcome, StageReport
    from rosic.core.robot.profile import RobotId

FOLLOWS_NOT: Final = "somebody who follows orders failed; the order goes on"

log = logging.getLogger("rosic.pipeline")


class OrderWatcher(Protocol):
    """Whoever follows what robots do. What a method raises is logged; orders go on without it."""

    def began(self, order: Order) -> None:
        """Hear that an order is handed to its robot now."""

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Hear that it is over, and how."""


class OrderObserver(Protocol):
    """Whoever shows orders step by step. What a method raises is logged; orders go on."""

    def accepted(self, order: Order) -> None:
        """Hear that an order is on disk, and waits for its robot."""

    def reported(self, order: Order, report: StageReport) -> None:
        """Hear of a step of it; what a robot says is inert text."""

    def ended(self, order: Order, outcome: Outcome) -> None:
        """Hear that it is over, and how; also of one that never began."""


class OrderWatcherRegistry:
    """Everybody who hears of orders. One who fails keeps nobody else from hearing.

    Attributes:
        watchers: Who follows what robots do.
        observers: Who shows orders step by step.
        still_moves: An order is over, and its robot was not brought to rest.
    """

    def __init__(self) -> None:
        self.watchers: tuple[OrderWatcher, ...] = ()
        self.observers: tuple[OrderObserver, ...] = ()
        self.still_moves: Signal[[Order]] = Signal()
        self._hear_ends: tuple[Callable[[RobotId], None], ...] = ()

    def watch_orders(self, watcher: OrderWatcher, *, wanted: bool = True) -> None:
        """Let somebody hear when a robot begins an order and when it has ended, each time once.

        Not wanted: no more.
        """
        others = tuple(other for other in self.watchers if other is not watcher)
        self.watchers = (*others, watcher) if wanted else others

    def observe(self, observer: OrderObserver, *, wanted: bool = True) -> None:
        """Let somebody hear of every step of every order from now on; not wanted: no more."""
        others = tuple(other for other in self.observers if other is not observer)
        self.observers = (*others, observer) if wanted else others

    def hear_ends(self, hear: Callable[[RobotId], None], *, wanted: bool) -> None:
        """Call somebody with the robot whenever an order has ended; not wanted: no more."""
        others = tuple(other for other in self._hear_ends if other != hear)
        self._hear_ends = (*others, hear) if wanted else others

    def accepted(self, order: Order) -> None:
        """Tell observers that an order is on disk, and waits for its robot."""
        for observer in self.observers:
            try:
                observer.accepted(order)
            except Exception:
                log.exception(FOLLOWS_NOT)

    def reported(self, order: Order, report: StageReport) -> None:
        """Tell observers of a step of an order."""
        for observer in self.observers:
            try:
                observer.reported(order, report)
            except Exception:
                log.exception(FOLLOWS_NOT)

    def concluded(self, order: Order, outcome: Outcome) -> None:
        """Tell observers how an order ended, in the words that its author reads."""
        for observer in self.observers:
            try:
                observer.ended(order, outcome)
            except Exception:
                log.exception(FOLLOWS_NOT)

    def ended(self, order: Order, outcome: Outcome, *, begun: bool) -> None:
        """Tell whoever follows robots that an order is over.

        Args:
            order: Which.
            outcome: How it ended.
            begun: It was handed to its robot.
        """
        for hear in self._hear_ends:
            try:
                hear(order.robot)
            except Exception:
                log.exception(FOLLOWS_NOT)
        if not begun:
            return
        for watcher in self.watchers:
            try:
                watcher.ended(order, outcome)
            except Exception:
                log.exception(FOLLOWS_NOT)
        if outcome.code == StillMoves.code:
            try:
                self.still_moves.emit(order)
            except Exception:
                log.exception(FOLLOWS_NOT)
