"""Every sentence about what one keeps, lends and is lent."""

from __future__ import annotations

from typing import Final

from rosic.container.messages import size
from rosic.core.i18n import said
from rosic.core.language.sanitise import quote

HOW_TO_SHARE: Final = said(
    "Write what and with whom: /share bay with Bo, /share bay with omni for 2h. To end it: /share "
    "back bay, /share back bay from Bo. What there is says /shelf."
)
HOW_LONG: Final = said("Say for how long as 30 min, 2h or 3 days, a year at most, or leave it out.")
YOURSELF: Final = said("That is yours already.")
SEVERAL: Final = said("Several people are called so. Which one?")
TAKE_BACK: Final = said("Take it back")
EMPTY: Final = said(
    "You keep nothing, and nobody shares anything with you. To keep something: /data NAME = VALUE"
)
MINE: Final = said("You keep:")
LENT: Final = said("You share:")
TO_ME: Final = said("Shared with you:")


def used(names: int, names_most: int, kept: int, kept_most: int) -> str:
    """Return how much of what one may keep is used."""
    return said(
        "  ({names} of {names_most} names, {kept} of {kept_most})",
        names=names, names_most=names_most, kept=size(kept), kept_most=size(kept_most),
    )  # fmt: skip


def lent_line(name: str, reader: str, until: str) -> str:
    """Return one line of what is lent."""
    if until:
        return said("  {name} with {reader}, until {until}", name=name, reader=reader, until=until)
    return said("  {name} with {reader}", name=name, reader=reader)


def take_back(reader: str) -> str:
    """Return what stands on the button that ends a loan."""
    return said("Take back from {reader}", reader=reader)


def shared(name: str, reader: str, until: str) -> str:
    """Return that a name is lent now."""
    if until:
        return said(
            "{reader} can read {name} until {until}.", reader=reader, name=quote(name), until=until
        )
    return said("{reader} can read {name} until you take it back.", reader=reader, name=quote(name))


def somebody_shares(by: str, name: str) -> str:
    """Return what is told to whoever is lent something."""
    return said("{by} shares {name} with you: /shelf shows it.", by=by, name=quote(name))


def taken_back(name: str) -> str:
    """Return that a name is lent no longer."""
    return said("{name} is yours alone again.", name=quote(name))


def nothing_to_share(name: str) -> str:
    """Return that there is nothing of that name."""
    return said("You keep nothing called {name}. Nothing was shared.", name=quote(name))


def nobody_called(name: str) -> str:
    """Return that nobody is called so, and no robot."""
    return said("I know nobody and no robot called {name}. Nothing was changed.", name=quote(name))


def numbered(name: str, number: int) -> str:
    """Return what stands on the button for one of several who are called the same."""
    return f"{name} ({number})"
