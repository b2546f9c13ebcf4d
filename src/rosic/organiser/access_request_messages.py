"""What people read who ask for a right too often, too late or for too long."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from rosic.core.i18n import said
from rosic.organiser.calendar_messages import length

Pause: TypeAlias = Callable[[float], str]


def no_such_time() -> str:
    """Return that nothing is given for so short or so long a time."""
    return said(
        "What you ask for lasts at least half a minute and at most a week. Nothing was asked."
    )


def asked_already(wait_s: float) -> str:
    """Return that the same question is still open."""
    return said(
        "I have asked that for you already. If nobody answers within {wait}, you can ask again.",
        wait=_rounded(wait_s),
    )


def denied_lately(wait_s: float) -> str:
    """Return that the answer was no."""
    return said(
        "The answer to that was no. You can ask again in {wait}. Nothing was asked.",
        wait=_rounded(wait_s),
    )


def too_many_open(wait_s: float) -> str:
    """Return that enough of their questions wait."""
    return said(
        "You wait for too many answers already. Ask again when one of them has come, or in "
        "{wait}. Nothing was asked.",
        wait=_rounded(wait_s),
    )


def too_often(wait_s: float) -> str:
    """Return that they asked enough for now."""
    return said(
        "You have asked often enough for now. You can ask again in {wait}. Nothing was asked.",
        wait=_rounded(wait_s),
    )


def too_many_here(wait_s: float) -> str:
    """Return that everybody together asks too much."""
    return said(
        "Too many people ask for something now. Try again in {wait}, or speak to an admin. "
        "Nothing was asked.",
        wait=_rounded(wait_s),
    )


def settled() -> str:
    """Return that there is nothing to answer any more."""
    return said("That question is settled already, or it waited too long. Nothing was done.")


def _rounded(wait_s: float) -> str:
    """Return a time that is never too short: whole minutes from a minute on."""
    minute_s = 60
    whole_s = -int(-wait_s // minute_s) * minute_s if wait_s > minute_s else -int(-wait_s // 1)
    return length(whole_s)
