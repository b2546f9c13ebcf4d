"""What people read about waiting for a robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.organiser.words_calendar import moment

if TYPE_CHECKING:
    from rosic.organiser.zones import Zone


def queue_full(shown: str, people: int) -> str:
    """No more may wait."""
    return f"{people} people wait for {shown} already. Book a time instead."


def waits_enough(most: int) -> str:
    """The person is in too many queues."""
    return f"You wait for {most} robots already. Leave one of these queues first."


def turn_over(shown: str) -> str:
    """An offer was not taken in time."""
    return f"Your turn with {shown} has passed on. Say wait to queue again."


def not_your_turn(shown: str, place: int) -> str:
    """Somebody takes what was not offered to them.

    Args:
        shown: The robot's title.
        place: 0 if they do not wait.
    """
    if not place:
        return f"You are not waiting for {shown}."
    return f"{shown} is offered to somebody else now. You are number {place} in the queue."


def your_turn(shown: str, offer_s: float) -> str:
    """The offer itself."""
    return f"{shown} is free and it is your turn. Tap within {offer_s:.0f} s to take it."


def your_place(shown: str, place: int, about_ns: int, now_ns: int, zone: Zone) -> str:
    """Where somebody stands, and about when it is their turn."""
    if about_ns <= now_ns:
        return f"You are number {place} in the queue for {shown}."
    about = moment(about_ns, now_ns, zone)
    return f"You are number {place} in the queue for {shown}: about {about}."
