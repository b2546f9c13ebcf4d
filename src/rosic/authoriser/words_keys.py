"""What people read about keys, locks, second steps and misuse."""

from __future__ import annotations

from rosic.authoriser.words_entry import lasting

ENDED = "Your access here has ended. The admin of this place can renew it."
NO_KEY = "There is no such key. Nothing was done."
KEY_TAKEN = "One of your keys was taken back. You can go on as before."
KEY_GONE = "This key was taken back before. Nothing was done."
NOTHING_TO_ROTATE = "There is no good key to replace. Invite the person again. Nothing was done."
LOCKED = "Your access is locked. Ask an admin."
OWN_UNLOCK = "Another admin has to unlock you. Nothing was done."
PRIVATE_ONLY = "Do this in a private chat with me. Nothing was done."
NOT_SET_UP = (
    "This needs a code from your phone, and none is set up. "
    "Set it up in a private chat with me. Nothing was done."
)
ASK_CODE = "This needs the six digits that your authenticator app shows now. Nothing was done."
NOT_A_CODE = "A code is six digits, as your authenticator app shows them."
WRONG_CODE = "This code is not right. Nothing was done."
USED_CODE = "This code was used before. Wait for the next one. Nothing was done."
CODE_NOT_WRITTEN = "I could not write down that this code was used, so it does not count."
SET_UP_FIRST = "Begin again: the picture is too old. Nothing was done."
PROVE_FIRST = "Your phone is set up already. Give its present code first. Nothing was done."
PHONE_BROKEN = "What I know about your phone cannot be read. An admin has to reset it."
OWN_RESET = "Another admin has to reset your codes. Nothing was done."
NOTHING_TO_RESET = "No phone is set up for this person. Nothing was done."
PHONE_READY = "Your phone is set up. I ask for a code before dangerous things."
CLOCK_GOOD = "The clock of this machine shows the latest time that was seen here. All is well."
CLOCK_ACCEPTED = (
    "The clock of this machine counts again. What ended in the meantime may be good again: "
    "look at rosic people and rosic key list."
)
CODE_TAKEN = "Thank you. I ask again after an hour without use."


def scan(key: str) -> str:
    """Return what stands under the picture."""
    return (
        f"Scan this with an authenticator app, or type the key {key}. Then send me the six digits "
        "it shows. Delete this message afterwards."
    )


def too_many_codes(seconds: float) -> str:
    """Return what is said after five wrong codes."""
    return f"Too many wrong codes. Try again in {lasting(seconds)}. Nothing was done."


def clock_behind(seconds: float) -> str:
    """Return what the operator reads when the machine's clock was set back."""
    return (
        f"The clock of this machine is {lasting(seconds)} behind the latest time that was seen "
        "here. What has ended stays ended, and times are counted from the later one. If the clock "
        "is right now and was wrong before: rosic clock --accept"
    )


def rotated(name: str, grace_s: float) -> str:
    """Return what the admin reads after a key was replaced."""
    old = f"is good for another {lasting(grace_s)}" if grace_s > 0 else "is not good any more"
    return f"{name} has a new key. The old one {old}."


def revoked(name: str) -> str:
    """Return what the admin reads after a key was taken back."""
    return f"{name} has no access any more."


def locked(name: str) -> str:
    """Return what the admin reads after locking somebody."""
    return f"{name} is locked: nothing they send is carried out until an admin unlocks them."


def unlocked(name: str) -> str:
    """Return what the admin reads after unlocking somebody."""
    return f"{name} is unlocked."


def not_locked(name: str) -> str:
    """Return what is said when there is nothing to unlock."""
    return f"{name} is not locked. Nothing was done."


def key_line(name: str, key: str, state: str) -> str:
    """Return one key of a list."""
    return f"{key}  {name}  {state}"


def ends_in(seconds: float | None) -> str:
    """Return how long a key is good."""
    return "until taken back" if seconds is None else f"for {lasting(seconds)}"


def misuse_person(what: str) -> str:
    """Return what somebody reads whose key was invalidated by rule."""
    return f"Your access has ended, because there were {what}. Ask an admin."


def misuse_admins(name: str, what: str) -> str:
    """Return what the admins read about it."""
    return f"The access of {name} was ended by rule: {what}. Look, then invite them again."


def spared_admins(name: str, what: str) -> str:
    """Return what is said when the rule would have ended the last admin."""
    return (
        f"{name} is the only admin, so their access was not ended, although there were {what}. "
        "Look whether somebody else uses their account."
    )


def many_refused(count: int, seconds: float) -> str:
    """Return the rule about refused attempts."""
    return f"{count} refused attempts within {lasting(seconds)}"


def many_attempts(count: int, seconds: float) -> str:
    """Return the rule about bursts."""
    return f"{count} requests within {lasting(seconds)}"
