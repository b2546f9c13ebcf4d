"""Every sentence about access that ends, and about phones, that a chat is told here."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.messages import listed
from rosic.core.i18n import joined, said
from rosic.features.access.messages import MOST_NAMED

if TYPE_CHECKING:
    from collections.abc import Sequence


# ---- ending access ----

REVOKE: Final = said("Revoke")
UNLOCK: Final = said("Unlock")
LOCK_ME: Final = said("Lock me")
HOW_TO_REVOKE: Final = said("Whose access shall end for good? Write for example: /revoke NAME")
HOW_TO_LOCK: Final = said(
    "Who shall be locked out at once? Write: /lock NAME, or /lock me. What they move stops."
)
LOCK_LAST: Final = said(
    "You are the only admin here. Once you are locked, only the operator of this "
    "place can unlock you. Lock yourself?"
)
LOCKED_YOURSELF: Final = said(
    "You are locked: nothing you send is carried out until another admin unlocks you."
)


def revoke_question(name: str, what: str) -> str:
    """Return the question before somebody's access ends."""
    return said(
        "End the access of {who} for good? What they move stops, their times are free again, and "
        "their codes let nobody in any more.",
        who=joined("", (name, " (", what, ")")) if what else name,
    )


def no_access(name: str) -> str:
    """Return that there is nothing to take."""
    return said("{name} has no access any more. Nothing was done.", name=name)


def last_admin(name: str) -> str:
    """Return why somebody cannot go."""
    return said(
        "{name} is the last admin here. Make somebody else an admin first: /grant NAME admin. "
        "Nothing was done.",
        name=name,
    )


def was_key_taken(by: str, name: str) -> str:
    """Return what the other admins read."""
    return said("{by} took a key of {name} back. {name} has another one.", by=by, name=name)


def was_revoked(by: str, name: str) -> str:
    """Return what the other admins read."""
    return said("{by} ended the access of {name}.", by=by, name=name)


def was_locked(by: str, name: str) -> str:
    """Return what the other admins read."""
    return (
        said("{by} locked {name}.", by=by, name=name)
        if by != name
        else said("{by} locked their own access.", by=by)
    )


def was_unlocked(by: str, name: str) -> str:
    """Return what the other admins read."""
    return said("{by} unlocked {name}.", by=by, name=name)


def you_are_unlocked(by: str) -> str:
    """Return what somebody reads who was locked."""
    return said("{by} unlocked you. You may do again what you could before.", by=by)


def how_to_unlock(names: Sequence[str]) -> str:
    """Return how to unlock, and who is locked."""
    who = said(" Locked now: {listed}.", listed=listed(names[:MOST_NAMED])) if names else ""
    return said("Who shall have their access back? Write: /unlock NAME.{who}", who=who)


# ---- a phone ----

HOW_TO_RESET: Final = said("Whose phone shall be forgotten? Write: /authenticator reset NAME")
NO_PHONE: Final = said("Authenticator: not set up. /authenticator begins.")
PHONE_SET_UP: Final = said("Authenticator: set up. I ask for a code before dangerous things.")
PHONE_PROVEN: Final = said("Authenticator: set up, and your code was given in this chat lately.")


SCAN = said("Or let the app on another device scan the picture.")


def set_up(uri: str, key: str) -> str:
    """Return what somebody reads who sets a phone up; it holds the secret."""
    return said(
        "On the phone with your authenticator app, tap this link:\n{uri}\nOr type this "
        "key there: {key}\nThen send me the six digits that it shows, so: /code 123456. "
        "Delete this message afterwards: whoever reads it can make your codes.",
        uri=uri,
        key=key,
    )


def phone_reset(name: str) -> str:
    """Return what the admin reads after resetting a phone."""
    return said(
        "The phone of {name} is forgotten. They can set up another with /authenticator.", name=name
    )


def your_phone_was_reset(by: str) -> str:
    """Return what the person reads."""
    return said("{by} reset your authenticator. /authenticator sets up another phone.", by=by)
