"""Orders that wait for their time: planned in a chat, given as their author when it comes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.scheduled_orders import messages as words
from rosic.features.scheduled_orders.commands import PlanningParts, ScheduledOrderCommands
from rosic.features.scheduled_orders.order_plan import OrderPlanReader
from rosic.features.scheduled_orders.runs import ScheduledRuns
from rosic.features.scheduled_orders.schedule import KIND, OrderSchedule
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.notifier import Notifier
    from rosic.gateway.feature import Kernel

__all__ = ["ScheduledOrdersFeature", "setup"]


class ScheduledOrdersFeature(Feature):
    """Gives orders at their time.

    Attributes:
        schedule: What waits.
    """

    def __init__(
        self, rooms: Components, reach: Notifier, schedule: OrderSchedule, runs: ScheduledRuns
    ) -> None:
        self.schedule = schedule
        self._rooms = rooms
        self._reach = reach
        self._runs = runs

    async def recover(self) -> None:
        """Say what was under way when the last run ended, and take back what nobody may."""
        for due in self.schedule.settle():
            self._runs.interrupted(due)
        self.access_changed()

    async def run(self) -> None:
        """Begin what is due from now on."""
        self.schedule.run(self._runs)

    async def close(self) -> None:
        """Nothing begins any more."""
        await self.schedule.close()
        await self._runs.close()

    def access_changed(self) -> None:
        """Take back what somebody had planned whose access was locked or has ended.

        It stays taken back when they are let in again: whoever held their phone may have planned.
        """
        locked, authoriser = self._rooms.organiser.locked, self._rooms.authoriser
        for who in self.schedule.authors():
            if who in locked or not authoriser.has_access(who):
                self._runs.cancel(who)
                self._reach.tell((who,), words.taken_back(self.schedule.drop(who)))


def setup(kernel: Kernel) -> ScheduledOrdersFeature:
    """Let people plan orders."""
    rooms, orders, changes = kernel.rooms, kernel.orders, kernel.changes
    agreements = kernel.pipeline.agreements
    schedule = OrderSchedule(changes, kernel.clock)
    kernel.keep(KIND, schedule.restore, schedule.apply)
    runs = ScheduledRuns(rooms, orders, agreements, schedule, kernel.clock)
    reader = OrderPlanReader(rooms, agreements, orders.chat_sender.languages)
    parts = PlanningParts(schedule, runs, reader, agreements)
    commands = ScheduledOrderCommands(
        rooms, changes, parts, kernel.reach, kernel.clock, kernel.entropy
    )
    commands.register(kernel.commands)
    kernel.pipeline.cancels.also(commands.withdraw)
    kernel.erasure.join(records=schedule.end_all)
    feature = ScheduledOrdersFeature(rooms, kernel.reach, schedule, runs)
    changes.after(feature.access_changed)
    return feature
