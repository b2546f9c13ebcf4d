"""What people read about places that are kept under a name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said
from rosic.core.language.sanitise import echo

if TYPE_CHECKING:
    from collections.abc import Iterable

HOW_TO: Final = said(
    "Say for which robot, and how the place where it is now is called: /place omni dock. /places "
    "lists them; /place omni dock remove forgets one."
)
NONE: Final = said("No place is kept here. /place omni dock keeps the place where omni is now.")
ONE_WORD: Final = said(
    "A place is called by one word of up to 24 letters, digits and hyphens, beginning with a "
    "letter. Nothing was kept."
)


def means_else(name: str) -> str:
    """Return that a word cannot name a place."""
    return said(
        "{name} means something else here, so no place can be called that. Nothing was kept.",
        name=echo(name),
    )


def goes_nowhere(robot: str) -> str:
    """Return that a robot has no skill that goes to a place."""
    return said(
        "{robot} has no skill that goes to a place: goto, with x and y. Nothing was kept.",
        robot=robot,
    )


def says_not(robot: str, what: str) -> str:
    """Return that a skill asks for more than a place says."""
    return said(
        "{robot}: goto asks for {what}, which a place does not say. Nothing was kept.",
        robot=robot,
        what=what,
    )


def not_known(robot: str) -> str:
    """Return that it is not known where a robot is."""
    return said("I do not know where {robot} is now. Nothing was kept.", robot=robot)


def moves(robot: str) -> str:
    """Return that a robot is not at rest."""
    return said("{robot} moves. Say it again once it is at rest. Nothing was kept.", robot=robot)


def outside(robot: str, why: str) -> str:
    """Return that a robot could not be sent to where it is."""
    return said("{robot} could not be sent here. {why} Nothing was kept.", robot=robot, why=why)


def too_many(robot: str, most: int) -> str:
    """Return that a robot has as many places as it may."""
    return said(
        "{robot} has {most} places already. Forget one first. Nothing was kept.",
        robot=robot,
        most=most,
    )


def kept(robot: str, name: str, where: str) -> str:
    """Return that a place is kept."""
    return said("{robot}: {name} is here now: {where}.", robot=robot, name=name, where=where)


def forgotten(robot: str, name: str) -> str:
    """Return that a place is kept no more."""
    return said("{robot}: {name} is forgotten.", robot=robot, name=name)


def no_such(robot: str, name: str) -> str:
    """Return that a robot has no such place."""
    return said("{robot} has no place called {name}.", robot=robot, name=echo(name))


def places(robot: str, found: Iterable[str]) -> str:
    """Return the places of one robot."""
    return said("{robot}: {places}", robot=robot, places=joined("; ", found))
