"""What people read when something is asked for too often: whose limit, and from when on again."""

from __future__ import annotations

from math import ceil
from typing import TYPE_CHECKING

from rosic.core.i18n import said
from rosic.errors import TooManyRequests

if TYPE_CHECKING:
    from rosic.core.i18n import Sentence

_LONG_S, _LONGER_S = 120, 7_200


def person_full(wait_s: float) -> TooManyRequests:
    """Return the refusal of somebody's own limit."""
    sentence = said("That is more than one person may ask. Again in {wait}.", wait=_wait(wait_s))
    return TooManyRequests(sentence, retry_after_s=wait_s)


def robot_full(shown: str, wait_s: float) -> TooManyRequests:
    """Return the refusal of a robot's limit."""
    sentence = said(
        "{robot} has had as many commands as it takes, from everybody together. "
        "Nothing was done. Again in {wait}.",
        robot=shown,
        wait=_wait(wait_s),
    )
    return TooManyRequests(sentence, retry_after_s=wait_s, own=False)


def role_full(role: str, wait_s: float) -> TooManyRequests:
    """Return the refusal of a role's limit."""
    sentence = said(
        "Your role has asked for as much as it may: everybody who is {role}, together. "
        "Nothing was done. Again in {wait}.",
        role=role,
        wait=_wait(wait_s),
    )
    return TooManyRequests(sentence, retry_after_s=wait_s, own=False)


def _wait(wait_s: float) -> Sentence:
    """Return how long, never less than it is."""
    if wait_s <= _LONG_S:
        return said("{n} s", n=max(1, ceil(wait_s - 1e-9)))
    if wait_s <= _LONGER_S:
        return said("{n} min", n=ceil(wait_s / 60))
    return said("{n} h", n=ceil(wait_s / 3_600))
