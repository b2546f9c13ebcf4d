"""What people read about wishes that cannot be put down or taken back."""

from __future__ import annotations

from rosic.core.i18n import said, said_n
from rosic.errors import OutOfBounds
from rosic.organiser.calendar_messages import length


def window_too_short(length_s: int) -> OutOfBounds:
    """Say that nothing that long fits."""
    return OutOfBounds(said("The window is shorter than {length}.", length=length(length_s)))


def window_over() -> OutOfBounds:
    """Say that it is too late for this."""
    return OutOfBounds(said("That window is over."))


def no_such_priority(least: int, most: int) -> OutOfBounds:
    """Say which numbers there are."""
    return OutOfBounds(
        said("A priority is a number from {least} to {most}.", least=least, most=most)
    )


def enough(most: int) -> str:
    """Say that somebody has as many wishes as one person may."""
    return said_n(
        "You have {n} wish already, and more are not possible. /wish off 1 takes it back.",
        "You have {n} wishes already, and more are not possible. /wish off 1 takes one back.",
        most,
    )


def all_enough(most: int) -> str:
    """Say that there are as many as are planned at a time."""
    return said("There are {most} wishes already. An admin has to make a plan first.", most=most)


def no_such_wish(count: int) -> str:
    """Say which numbers there are."""
    if not count:
        return said("You have no wishes.")
    return said_n(
        "You have {n} wish. Say its number: /wish off 1",
        "You have {n} wishes. Say the number of one: /wish off 1",
        count,
    )
