"""What people read about keys, locks, second steps and misuse."""

from __future__ import annotations

from rosic.authoriser.messages import lasting
from rosic.core.i18n import joined, said

ENDED = said("Your access here has ended. The admin of this place can renew it.")
NO_KEY = said("There is no such key. Nothing was done.")
KEY_TAKEN = said("One of your keys was taken back. You can go on as before.")
KEY_GONE = said("This key was taken back before. Nothing was done.")
NOTHING_TO_ROTATE = said(
    "There is no good key to replace. Invite the person again. Nothing was done."
)
LOCKED = said("Your access is locked. Ask an admin.")
OWN_UNLOCK = said("Another admin has to unlock you. Nothing was done.")
PRIVATE_ONLY = said("Do this in a private chat with me. Nothing was done.")
NOT_SET_UP = said(
    "This needs a code from your phone, and none is set up. Set it up in a private "
    "chat with me. Nothing was done."
)
ASK_CODE = said(
    "This needs the six digits that your authenticator app shows now. Nothing was done."
)
NOT_A_CODE = said("A code is six digits, as your authenticator app shows them.")
WRONG_CODE = said("This code is not right. Nothing was done.")
USED_CODE = said("This code was used before. Wait for the next one. Nothing was done.")
CODE_NOT_WRITTEN = said("I could not write down that this code was used, so it does not count.")
SET_UP_FIRST = said("Begin again: the picture is too old. Nothing was done.")
PROVE_FIRST = said("Your phone is set up already. Give its present code first. Nothing was done.")
PHONE_BROKEN = said("What I know about your phone cannot be read. An admin has to reset it.")
OWN_RESET = said("Another admin has to reset your codes. Nothing was done.")
NOTHING_TO_RESET = said("No phone is set up for this person. Nothing was done.")
PHONE_READY = said("Your phone is set up. I ask for a code before dangerous things.")
CLOCK_GOOD = "The clock of this machine shows the latest time that was seen here. All is well."
CLOCK_ACCEPTED = (
    "The clock of this machine counts again. What ended in the meantime may be good again: "
    "look at rosic people and rosic key list."
)
CODE_TAKEN = said("Thank you. I ask again after an hour without use.")


NO_SUCH_SECRET = said(
    "That is no key of a program here, or it is not good any more. Make another: rosic key create."
)
NO_PROGRAM_NAME = "A program needs a name that can be shown. Nothing was done."
NEVER_ADMIN = (
    "A program gives nobody rights and looks after nothing but robots: choose a role for robots "
    "alone, operator for example. Nothing was done."
)


def name_taken(name: str) -> str:
    """Return why a program cannot be called so."""
    return f"Somebody is called {name} already, or nearly so. Choose another name."


def program_made(name: str, what: str, secret: str) -> str:
    """Return what the operator reads once a program is known. It shows the secret."""
    return (
        f"{name} is known now, a program: {what}. This is its key. It is shown once; give it to "
        f"that program alone, as ROSIC_KEY or in a file that only you can read:\n{secret}"
    )


def secret_renewed(sentence: str, secret: str) -> str:
    """Return what the operator reads once a program's key was replaced. It shows the secret."""
    return f"{sentence} The new one is shown once:\n{secret}"


def scan(key: str) -> str:
    """Return what stands under the picture."""
    return said(
        "Scan this with an authenticator app, or type the key {key}. Then send me the "
        "six digits it shows. Delete this message afterwards.",
        key=key,
    )


def too_many_codes(seconds: float) -> str:
    """Return what is said after five wrong codes."""
    return said(
        "Too many wrong codes. Try again in {lasting}. Nothing was done.", lasting=lasting(seconds)
    )


def clock_behind(seconds: float) -> str:
    """Return what the operator reads when the machine's clock was set back."""
    return (
        f"The clock of this machine is {lasting(seconds)} behind the latest time that was seen "
        "here. What has ended stays ended, times are counted from the later one, and nothing new "
        "moves. If the clock is right now and was wrong before: rosic clock --accept"
    )


def rotated(name: str, grace_s: float) -> str:
    """Return what the admin reads after a key was replaced."""
    if grace_s > 0:
        return said(
            "{name} has a new key. The old one is good for another {lasting}.",
            name=name,
            lasting=lasting(grace_s),
        )
    return said("{name} has a new key. The old one is not good any more.", name=name)


def revoked(name: str) -> str:
    """Return what the admin reads after a key was taken back."""
    return said("{name} has no access any more.", name=name)


def locked(name: str) -> str:
    """Return what the admin reads after locking somebody."""
    return said(
        "{name} is locked: nothing they send is carried out until an admin unlocks them.", name=name
    )


def unlocked(name: str) -> str:
    """Return what the admin reads after unlocking somebody."""
    return said("{name} is unlocked.", name=name)


def not_locked(name: str) -> str:
    """Return what is said when there is nothing to unlock."""
    return said("{name} is not locked. Nothing was done.", name=name)


def key_line(name: str, key: str, state: str) -> str:
    """Return one key of a list."""
    return joined("  ", (key, name, state))


def ends_in(seconds: float | None) -> str:
    """Return how long a key is good."""
    return (
        said("until taken back")
        if seconds is None
        else said("for {lasting}", lasting=lasting(seconds))
    )


def replaced_for(seconds: float) -> str:
    """Return how long a key is good beside the one that took its place."""
    return said("replaced by a newer key, good for another {lasting}", lasting=lasting(seconds))


def misuse_person(what: str) -> str:
    """Return what somebody reads whose key was invalidated by rule."""
    return said("Your access has ended, because there were {what}. Ask an admin.", what=what)


def misuse_admins(name: str, what: str) -> str:
    """Return what the admins read about it."""
    return said(
        "The access of {name} was ended by rule: {what}. Look, then invite them again.",
        name=name,
        what=what,
    )


def spared_admins(name: str, what: str) -> str:
    """Return what is said when the rule would have ended the last admin."""
    return said(
        "{name} is the only admin, so their access was not ended, although there were "
        "{what}. Look whether somebody else uses their account.",
        name=name,
        what=what,
    )


def many_refused(count: int, seconds: float) -> str:
    """Return the rule about refused attempts."""
    return said("{count} refused attempts within {lasting}", count=count, lasting=lasting(seconds))


def many_attempts(count: int, seconds: float) -> str:
    """Return the rule about bursts."""
    return said("{count} requests within {lasting}", count=count, lasting=lasting(seconds))
