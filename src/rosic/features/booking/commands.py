"""Who does which command about times."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import said
from rosic.core.language.command import (
    Command,
    HelpEntry,
    HelpNeed,
    HelpPage,
    MenuAudience,
    MenuEntry,
)
from rosic.features.booking.book import BookCommand, CancelBookingCommand, MoveBookingCommand
from rosic.features.booking.plan import PlanCommand, WishCommand
from rosic.features.booking.queue import QueueCommands
from rosic.features.booking.slots import SlotListing
from rosic.gateway.cancel import BOOKING

if TYPE_CHECKING:
    from rosic.features.booking.context import BookingContext
    from rosic.features.booking.scheduler import BookingScheduler
    from rosic.gateway.commands import CommandRegistry

COMMANDS: Final = (
    Command(
        name="book",
        aliases=("buchen",),
        typed=said("/book"),
        summary=said("Have a robot for a time of your own"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 20, HelpNeed.BOOKING),
        menu=MenuEntry(110),
        phrase=lambda what: said("Book {what}", what=what),
        timed=True,
    ),
    Command(
        name="rebook",
        aliases=("umbuchen",),
        typed=said("/rebook"),
        summary=said("Move a booking to another time"),
        help=HelpEntry(HelpPage.SHARE, 25, HelpNeed.BOOKING),
        phrase=lambda what: said("Move a booking of {what}", what=what),
        alone=said("Move a booking"),
        timed=True,
    ),
    Command(
        name="slots",
        observes=True,
        aliases=("zeiten",),
        typed=said("/slots"),
        summary=said("Which times are whose"),
        help=HelpEntry(HelpPage.SHARE, 10, HelpNeed.BOOKING),
        phrase=lambda what: said("Times of {what}", what=what),
        timed=True,
    ),
    Command(
        name="wish",
        aliases=("wunsch",),
        typed=said("/wish"),
        summary=said("Say when you would like a robot"),
        explained=True,
        help=HelpEntry(HelpPage.SHARE, 30, HelpNeed.BOOKING),
        menu=MenuEntry(120),
        phrase=lambda what: said("Wish for {what}", what=what),
        alone=said("Wishes"),
        timed=True,
    ),
    Command(
        name="wait",
        aliases=("warten",),
        typed=said("/wait"),
        summary=said("Get a robot when it is free"),
        help=HelpEntry(HelpPage.SHARE, 40, HelpNeed.BOOKING),
        phrase=lambda what: said("Wait for {what}", what=what),
    ),
    Command(
        name="plan",
        aliases=("planen",),
        typed=said("/plan"),
        summary=said("Weigh all wishes and book a plan"),
        help=HelpEntry(HelpPage.SHARE, 190, "slots"),
        menu=MenuEntry(270, MenuAudience.ADMINS),
    ),
    Command(name=BOOKING, spoken=False),
    Command(
        name="cancel booking",
        typed=said("cancel booking"),
        summary=said("Give a time back"),
        help=HelpEntry(HelpPage.SHARE, 50, HelpNeed.BOOKING),
        alone=said("Give a time back"),
    ),
)


def register_commands(
    commands: CommandRegistry, times: BookingContext, scheduler: BookingScheduler
) -> None:
    """Let times be booked, moved, given back, waited for, wished and planned."""
    commands.register("book", BookCommand(times).book)
    commands.register("rebook", MoveBookingCommand(times).rebook)
    commands.register("slots", SlotListing(times).show)
    commands.register(BOOKING, CancelBookingCommand(times).cancel)
    commands.register("wait", QueueCommands(times, scheduler).wait)
    commands.register("wish", WishCommand(times).wish)
    commands.register("plan", PlanCommand(times).plan)
