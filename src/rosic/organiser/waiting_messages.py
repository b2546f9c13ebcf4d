"""What people read about waiting for a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.organiser.calendar_messages import moment

if TYPE_CHECKING:
    from rosic.organiser.timezones import Zone


def queue_full(shown: str, people: int) -> str:
    """No more may wait."""
    return said(
        "{people} people wait for {shown} already. Book a time instead.", people=people, shown=shown
    )


def waits_enough(most: int) -> str:
    """The person is in too many queues."""
    return said("You wait for {most} robots already. Leave one of these queues first.", most=most)


def turn_over(shown: str) -> str:
    """An offer was not taken in time."""
    return said("Your turn with {shown} has passed on. Say wait to queue again.", shown=shown)


def not_your_turn(shown: str, place: int) -> str:
    """Somebody takes what was not offered to them.

    Args:
        shown: The robot's title.
        place: 0 if they do not wait.
    """
    if not place:
        return said("You are not waiting for {shown}.", shown=shown)
    return said(
        "{shown} is offered to somebody else now. You are number {place} in the queue.",
        shown=shown,
        place=place,
    )


def your_turn(shown: str, offer_s: float) -> str:
    """The offer itself."""
    return said(
        "{shown} is free and it is your turn. Tap within {offer_s:.0f} s to take it.",
        shown=shown,
        offer_s=offer_s,
    )


def your_place(shown: str, place: int, about_ns: int, now_ns: int, zone: Zone) -> str:
    """Where somebody stands, and about when it is their turn."""
    if about_ns <= now_ns:
        return said("You are number {place} in the queue for {shown}.", place=place, shown=shown)
    about = moment(about_ns, now_ns, zone)
    return said(
        "You are number {place} in the queue for {shown}: about {about}.",
        place=place,
        shown=shown,
        about=about,
    )
