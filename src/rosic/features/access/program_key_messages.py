"""Every sentence about keys of programs that a chat is told here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.messages import lasting
from rosic.core.i18n import joined, said
from rosic.features.access.messages import can_do

if TYPE_CHECKING:
    from collections.abc import Sequence

CREATE, LIST, ROTATE, REVOKE, FORGET = "create", "list", "rotate", "revoke", "forget"

HOW: Final = said(
    "A program has a key of its own, which I show once. Write for example:\n"
    "/key create NAME operator on omni for 30 days\n"
    "/key list\n"
    "/key rotate NAME for 1 hour (so long the old one stays good)\n"
    "/key revoke NAME"
)
NO_KEYS: Final = said("There is no key of a program that you could look after.")
ROTATE_IT: Final = said("New key for {name}")
REVOKE_IT: Final = said("End {name}")
TAKE_AWAY: Final = said("Take it out of this chat")
TAKEN_AWAY: Final = said("The key is out of this chat. Whoever has read it has it all the same.")
FOR_A_PERSON: Final = said("A program makes no keys: a person does that.")
NO_NAME: Final = said(
    "How is the program called, and what may it? Write for example: "
    "/key create NAME operator on omni for 30 days. Nothing was done."
)
NOBODY: Final = said(
    "There is no program of that name that you could look after. /key list shows them. Nothing was "
    "done."
)
NO_GRACE: Final = said(
    "I cannot read how long the old key stays good. Write for example: /key rotate NAME for 1 "
    "hour. Nothing was done."
)
HANDLE: Final = said(
    "It is shown once. Give it to that program alone, as ROSIC_KEY or in a file that only you can "
    "read; then take it out of this chat. It goes by itself in 15 minutes, where that can be."
)


def created(name: str, what: str, secret: str) -> str:
    """Return what whoever made a program reads. It shows the secret."""
    known = said("{name} is known now, a program: {what}. This is its key.", name=name, what=what)
    return joined("\n", (known, HANDLE, secret))


def rotated(name: str, grace_s: float, secret: str) -> str:
    """Return what whoever replaced a key reads. It shows the secret."""
    old = (
        said(
            "{name} has a new key. The old one is good for another {lasting}.",
            name=name,
            lasting=lasting(grace_s),
        )
        if grace_s > 0
        else said("{name} has a new key. The old one is not good any more.", name=name)
    )
    return joined("\n", (old, HANDLE, secret))


def line(name: str, what: str, ends: str, issuer: str) -> str:
    """Return one program of a list."""
    return said(
        "{name}: {what}, {ends}; by {issuer}", name=name, what=what, ends=ends, issuer=issuer
    )


def older(name: str, ends: str) -> str:
    """Return one key of a list that a newer one of the same program has replaced."""
    return said("{name}, the older key: {ends}", name=name, ends=ends)


def revoke_question(name: str) -> str:
    """Return the question before the keys of a program end."""
    return said(
        "End every key of {name} for good? What it moves stops, and it is let in no more.",
        name=name,
    )


def revoked(name: str) -> str:
    """Return what whoever ended a program reads."""
    return said("{name} has no good key any more.", name=name)


def not_yours(name: str, helpers: Sequence[str]) -> str:
    """Return why somebody may not touch a program."""
    return said(
        "{name} may more than you may give. {can} Nothing was done.",
        name=name,
        can=can_do(helpers),
    )
