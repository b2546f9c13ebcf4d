"""Whose time a robot is: slots, queues, wishes, and what happens when a turn begins or ends."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.policy.scope import FLEET
from rosic.features.booking.commands import register_commands
from rosic.features.booking.context import BookingContext, BookingQueries
from rosic.features.booking.scheduler import BookingScheduler
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.feature import Kernel
    from rosic.gateway.order_execution import OrderExecutor
    from rosic.organiser.wait_queue import WaitingList

__all__ = ["BookingFeature", "setup"]


class BookingFeature(Feature):
    """Follows the calendar and the queues.

    Attributes:
        scheduler: Begins and ends turns.
    """

    def __init__(
        self, scheduler: BookingScheduler, waiting: WaitingList, executor: OrderExecutor
    ) -> None:
        self.scheduler = scheduler
        self._waiting = waiting
        self._executor = executor
        self.watch_ends()

    async def run(self) -> None:
        """Follow until cancelled."""
        await self.scheduler.run()

    async def close(self) -> None:
        """Begin and end no turn any more."""
        await self.scheduler.close()

    def watch_ends(self) -> None:
        """Hear of orders that end, but only while somebody waits for a robot."""
        self._executor.watching.hear_ends(self._order_ended, wanted=bool(self._waiting.wanted()))

    def _order_ended(self, robot: RobotId) -> None:
        if self._waiting.queue(robot):
            self.scheduler.look()


def setup(kernel: Kernel) -> BookingFeature:
    """Let people book, wait and wish, and have turns begin and end by the clock."""
    times = _context(kernel)
    scheduler = BookingScheduler(times)
    feature = BookingFeature(scheduler, times.waiting, kernel.pipeline.executor)
    kernel.changes.after(scheduler.look)
    kernel.changes.after(feature.watch_ends)
    register_commands(kernel.commands, times, scheduler)
    return feature


def _context(kernel: Kernel) -> BookingContext:
    rooms, access, handover = kernel.rooms, kernel.access, kernel.orders.handover
    organiser, clock = rooms.organiser, kernel.clock

    def ready(robot: RobotId) -> bool:
        stopped = rooms.stops[robot].latched
        return not stopped and rooms.linker.presence(robot).online is not False

    sides = BookingQueries(
        visible=organiser.visible,
        may_book=organiser.why_not_move,
        right_ends_ns=lambda *of: organiser.rights.moves_until_ns(*of),  # noqa: PLW0108 - replaced
        may_cancel_any=lambda who, _: organiser.rights.holds(who, FLEET, "slots", clock.wall_ns()),
        selected=rooms.container.selected,
        zone_of=organiser.calendar.zone,
        lease=organiser.lease,
        ready=ready,
        barred=lambda robot: rooms.stops.barred(robot),  # noqa: PLW0108 - replaced
        may_resume=kernel.pipeline.resuming.may,
        handover=handover.end,
        may_stay=lambda who, slot: handover.outranks(who, slot.principal, slot.robot),
    )
    return BookingContext(
        calendar=organiser.calendar,
        waiting=access.waiting,
        wishes=access.wishes,
        vocabularies=rooms.vocabularies,
        changes=access.changes,
        reach=kernel.reach,
        clock=clock,
        sides=sides,
        lease_idle_s=organiser.lease_idle_s,
    )
