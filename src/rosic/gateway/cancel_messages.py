"""Sentences about ending what one has under way, and about holding it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.core.i18n import joined, said, said_n

if TYPE_CHECKING:
    from collections.abc import Iterable

CANCELLED = said("Cancelled.")
NOTHING = said("Nothing of yours is under way.")
NOTHING_ELSE = said("Nothing else of that message was done.")
NOBODY_LEFT_OUT = said("That left nothing out: all of yours was ended.")
NOT_ALL = said("Something else of yours could not be ended. See status, and say stop if it moves.")
CANCEL_A_BOOKING = said("Cancel a booking")


def rested(shown: str, at_rest: bool | None, seconds: float) -> str:
    """Return whether a robot is at rest now whose order was cancelled."""
    if at_rest is False:
        return said(
            "{shown} has not come to rest by it. It is stopped now; look before you resume it.",
            shown=shown,
        )
    if at_rest is None:
        return said("{shown} does not say whether it is at rest; please look.", shown=shown)
    return said("{shown} is at rest ({seconds:.2f} s).", shown=shown, seconds=seconds)


def waited(count: int) -> str:
    """Return how many orders waited; empty for none."""
    if not count:
        return ""
    return said_n(
        "One command that waited is not done.", "{n} commands that waited are not done.", count
    )


def withdrawn(count: int) -> str:
    """Return how many commands had waited for a second person."""
    return said_n(
        "The question to a second person is withdrawn.",
        "{n} questions to a second person are withdrawn.",
        count,
    )


def at_work_for(shown: str, name: str) -> str:
    """Return that a robot does something for somebody else."""
    return said("{shown} is at work for {name}; to stop it, say stop.", shown=shown, name=name)


def goes_on(what: Iterable[str]) -> str:
    """Return that what somebody asked for has not ended, and what ends it; it may be at rest."""
    return said(
        "What you asked for has not ended yet ({what}). "
        "To end it, tap a button or say stop or cancel.",
        what=joined("; ", what),
    )


def not_there(shown: str) -> str:
    """Return that nothing is known of what a robot does."""
    return said("{shown} is not there; whether it moves is not known.", shown=shown)


def cancel_label(shown: str) -> str:
    """Return the label of the button that ends what one robot does for whoever taps it."""
    return said("Cancel {shown}", shown=shown)


def stop_label(shown: str) -> str:
    """Return the label of the button that stops one robot."""
    return said("STOP {shown}", shown=shown)
