"""Who does which command about times."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.booking.book import BookCommand
from rosic.features.booking.cancel import CancelBookingCommand
from rosic.features.booking.plan import PlanCommand
from rosic.features.booking.queue import QueueCommands
from rosic.features.booking.slots import SlotListing
from rosic.features.booking.wish import WishCommand
from rosic.gateway.cancel import BOOKING

if TYPE_CHECKING:
    from rosic.features.booking.context import BookingContext
    from rosic.features.booking.scheduler import BookingScheduler
    from rosic.gateway.commands import CommandRegistry


def register_commands(
    commands: CommandRegistry, times: BookingContext, scheduler: BookingScheduler
) -> None:
    """Let ``book``, ``slots``, ``cancel booking``, ``wait``, ``wish`` and ``plan`` be done."""
    commands.register("book", BookCommand(times).book)
    commands.register("slots", SlotListing(times).show)
    commands.register(BOOKING, CancelBookingCommand(times).cancel)
    commands.register("wait", QueueCommands(times, scheduler).wait)
    commands.register("wish", WishCommand(times).wish)
    commands.register("plan", PlanCommand(times).plan)
