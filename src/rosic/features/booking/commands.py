"""Who does which errand about times."""

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
    from rosic.gateway.office import CommandRegistry


def employ_clerks(office: CommandRegistry, times: BookingContext, keeper: BookingScheduler) -> None:
    """Let ``book``, ``slots``, ``cancel booking``, ``wait``, ``wish`` and ``plan`` be done."""
    office.employ("book", BookCommand(times).book)
    office.employ("slots", SlotListing(times).show)
    office.employ(BOOKING, CancelBookingCommand(times).cancel)
    office.employ("wait", QueueCommands(times, keeper).wait)
    office.employ("wish", WishCommand(times).wish)
    office.employ("plan", PlanCommand(times).plan)
