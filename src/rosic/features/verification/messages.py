"""What is said about verifying somebody's devices."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined, said
from rosic.core.message import Button

if TYPE_CHECKING:
    from collections.abc import Sequence

NOT_HERE: Final = said(
    "On this messenger there is nothing to verify. Say it where messages are encrypted by keys "
    "that can be compared: on Matrix."
)
IN_GROUP: Final = said("Say /verify to me alone, please.")
VERIFIED_ALREADY: Final = said("You are verified here: what you write counts.")
ONLY_ADMINS: Final = said("Whoever looks after this place compares emoji. Nothing was done.")
PROGRAM: Final = said("A program has no device that anybody could verify.")
NONE_SHOWN: Final = said("No emoji are shown here now. Nothing was done.")
SEVERAL: Final = said(
    "More than one verification was shown here. Use the buttons beneath the emoji you compared."
)
NOT_SHOWN_HERE: Final = said("These emoji were not shown in this chat. Nothing was done.")
NOT_SURE: Final = said(
    "Nothing was done: whoever runs the homeserver could have tapped this. Reply with the number "
    "of the button, or write: they match"
)
NOT_ASKED: Final = said("Their client could not be asked now. Say it once more in a while.")
ENDED: Final = said("That ended already. To begin again: /verify")
SAID_SAME: Final = said("Noted. It counts once they have said in their client that they match.")
SAID_DIFFERENT: Final = said("Nothing counts by it. Whoever looks after this place is told.")
YOU_ARE: Final = said(
    "You are verified: what you write from your own devices counts here from now on."
)
YOU_ARE_NOT: Final = said("You are not verified: that ended. To begin again: /verify")
BUTTONS: Final = (said("They match"), said("They differ"))
NOBODY_COMPARES: Final = said(
    "Nobody who looks after this place can be shown emoji where the homeserver could not put in "
    "others. Have somebody run this on the computer of ROSIC: rosic verify"
)


def begun(names: Sequence[str]) -> str:
    """Return what somebody reads who asks to be verified."""
    asked = said(
        "I have asked your client to compare emoji: accept it there. Read the seven that it shows "
        "to whoever looks after this place, in person or by telephone, and confirm them there."
    )
    if not names:
        return joined(" ", (asked, NOBODY_COMPARES))
    return joined(" ", (asked, said("Shown the same: {names}.", names=joined(", ", names))))


def no_account(name: str) -> str:
    """Return that nobody can verify somebody."""
    return said("{name} has no account whose devices can be verified.", name=name)


def begun_with(name: str) -> str:
    """Return what somebody reads who begins to verify somebody else."""
    return said(
        "The client of {name} asks them to compare emoji. Once they have accepted I show the "
        "seven where the homeserver cannot put in others.",
        name=name,
    )


def compare(name: str, account: str, device: str, shown: str) -> str:
    """Return what whoever compares reads."""
    return said(
        "{name} is to be verified: {account}, device {device}. Let them read to you, in person or "
        "by telephone and in no chat, the emoji that their client shows:\n{shown}\nIf all seven "
        "match, in order, what they write counts from then on. If one differs, somebody stands "
        "between you.",
        name=name,
        account=account,
        device=device,
        shown=shown,
    )


def buttons(number: int) -> tuple[tuple[Button, ...], ...]:
    """Return the buttons beneath it."""
    return tuple(
        (Button(label, f"/{verb} {number}"),)
        for label, verb in zip(BUTTONS, ("match", "differ"), strict=True)
    )


def is_verified(name: str, account: str) -> str:
    """Return what whoever compared reads in the end."""
    return said("{name} is verified: {account}.", name=name, account=account)


def is_not_verified(name: str, account: str, why: str) -> str:
    """Return what whoever was to compare reads, if it came to nothing."""
    return said("{name} is not verified ({account}): {why}", name=name, account=account, why=why)


DIFFERENT: Final = said("the emoji were not the same. Somebody may stand between you.")
TOO_LATE: Final = said("it took too long.")
CANCELLED: Final = said("it was ended.")
NOT_KEPT: Final = said("it could not be written down.")
WHY: Final = {
    "m.mismatched_sas": DIFFERENT,
    "m.key_mismatch": DIFFERENT,
    "m.timeout": TOO_LATE,
}
