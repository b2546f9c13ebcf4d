"""Every sentence that a chat or a terminal is told about what is kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.container.words_container import size
from rosic.core.language.cleaning import quote
from rosic.core.saying import said, said_n

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.container.export import Sum
    from rosic.container.preferences import Preferences

SAVED: Final = "Saved."
LEAVE_IT: Final = "Leave it"
NOT_READABLE: Final = "I cannot read what is kept now. Nothing was changed. Try again in a while."
NO_SUCH_CONTAINER: Final = "There is no such container."

# ---- settings ----

HOW_TO_SET: Final = (
    "Write what and how, for example: /settings speed 0.2 m/s, /settings units imperial, "
    "/settings robot none, /settings zone Europe/Vienna, /settings language en"
)


def no_such_setting(said: str) -> str:
    """Return that there is nothing of that name to set."""
    return f"There is no setting {quote(said)}. {HOW_TO_SET}"


def settings(kept: Preferences, language: str, robot: str, zone: str) -> str:
    """Return everything that somebody has set, and what holds where they have set nothing."""
    speed = kept.speed.partition("<=")[2].strip()
    lines = (
        ("Language", language),
        ("Units", kept.units or "metric"),
        ("Robot, when none is named", robot or "none"),
        ("Highest speed", speed or "whatever each robot allows"),
        ("Time zone", zone),
    )
    return "\n".join(["Your settings:", *(f"  {what}: {value}" for what, value in lines)])


def speed_set(speed: str, robots: Sequence[str]) -> str:
    """Return what a highest speed touches."""
    said = speed.partition("<=")[2].strip()
    return f"Saved. Nothing you command goes faster than {said}. It holds for {', '.join(robots)}."


# ---- my data ----

KINDS: Final[Mapping[str, str]] = {
    "archived": "your messages in chats that are kept",
    "card": "your name and your addresses",
    "command": "your commands, and where I answered",
    "invitation": "invitations you made",
    "message": "which messages showed your commands",
    "outcome": "how your commands ended",
    "pending": "your request to come in",
    "preference": "your settings",
    "shelf": "data you keep",
    "shelf-loan": "data you share",
    "totp": "your authenticator",
}
NOTHING_KEPT: Final = "Nothing about you is kept."
SEALED: Final = "It is sealed with a key of your own. /forget me erases that key."
OPEN: Final = (
    "In the open stand only numbers: that an id gave which robot which command when, "
    "and who decided what about that id."
)
EXPORT: Final = "Show all of it"
FORGET: Final = "Forget me"


def my_data(sums: Iterable[Sum]) -> str:
    """Return what is kept about somebody."""
    lines = [f"  {KINDS.get(s.kind, s.kind)}: {s.count} ({size(s.size)})" for s in sums]
    if not lines:
        return NOTHING_KEPT
    return "\n".join(["What is kept about you:", *lines, SEALED, OPEN])


NO_FILES_HERE: Final = said("I cannot send files here, so this is what fits into a message:")


def handed_over(name: str, count: int) -> str:
    """Return what a file is, and what to mind."""
    return said(
        "{name}, {size}. It is not sealed: whoever has it can read it.", name=name, size=size(count)
    )


def too_large_a_file(count: int, command: str) -> str:
    """Return that a file is larger than this messenger takes."""
    return said(
        "The file would have {size}, which is more than I can send here. The operator can give it "
        "to you: {command}",
        size=size(count),
        command=command,
    )


def rest_left_out(count: int, command: str) -> str:
    """Return that not everything fits into a message."""
    return said_n(
        "{n} more line is too much for a message. The operator can give you all: {command}",
        "{n} more lines are too much for a message. The operator can give you all: {command}",
        count,
        command=command,
    )


# ---- being forgotten ----

HOW_TO_FORGET: Final = "To have everything about you erased here, write: /forget me"
ONLY_ME: Final = (
    "You can have only yourself forgotten. An admin can end somebody's access with /revoke, and "
    "the operator can erase them."
)
SURE: Final = (
    "Shall I forget you? Your access ends at once, your times are given back, and everything "
    "here that names you or repeats your words becomes unreadable for good. Numbers stay: that "
    "somebody gave which command when. What you wrote stays in this messenger. Backups made "
    "earlier stay readable for whoever has them and the key that belongs to them."
)
YES_FORGET: Final = "Forget me for good"
LAST_ADMIN: Final = (
    "You are the only admin here, so nobody could let anybody in any more. Nothing was erased. "
    "Make somebody else admin first."
)
FORGOTTEN: Final = "You are forgotten here. Farewell."
FORGOTTEN_MOVING: Final = (
    "You are forgotten here. A robot of yours has not confirmed that it is at rest: please look, "
    "and use its own stop button if need be."
)
NOT_ERASED_YET: Final = (
    "Your access has ended, but the record could not be cleared now. It is tried again until it is "
    "done; the operator has been told."
)
NOBODY: Final = "There is nobody of that id, or they were erased before."


def in_use(shown: str, who: str) -> str:
    """Return why a robot's container cannot be erased now."""
    return said(
        "{robot} is in use now, by {who}. Nothing was erased. Try again when it is free.",
        robot=shown,
        who=who,
    )


def last_admin(name: str) -> str:
    """Return why the operator cannot erase somebody."""
    return f"{name} is the only admin here. Nothing was erased. Make somebody else admin first."


def erased(name: str, *, at_rest: bool) -> str:
    """Return that somebody was erased, to whoever did it."""
    if at_rest:
        return f"{name} is erased. Copies of the record made before stay readable with their key."
    return f"{name} is erased, but a robot of theirs has not confirmed that it is at rest. Look."


# ---- archives ----

HOW_TO_ARCHIVE: Final = (
    "Write /archive on, /archive on 30 days, /archive off, /archive erase, or /archive export with "
    "text, jsonl or xlsx."
)
NOT_YOURS: Final = "Only an admin decides whether messages are kept, and takes them out."


def spreadsheet_later(command: str) -> str:
    """Return who can make a spreadsheet where no file can be sent."""
    return said(
        "A spreadsheet cannot be sent in a message. The operator can make it: {command} --as xlsx",
        command=command,
    )


NO_MESSAGES: Final = "No message of this chat is kept."
ERASE_SURE: Final = "Shall every message of this chat that is kept be erased?"
YES_ERASE: Final = "Erase them"
ARCHIVE_ERASED: Final = "Every message of this chat that was kept is erased, and none is kept now."


def begun(name: str, days: int) -> str:
    """Return what a chat is told when its messages begin to be kept."""
    return (
        f"From now on the messages of this chat are kept for {_days(days)}: {name} decided so. "
        "Everybody here may ask with /archive. They are sealed; what I write is kept, too."
    )


def ended(name: str, days: int) -> str:
    """Return what a chat is told when its messages are kept no longer."""
    return (
        f"From now on the messages of this chat are not kept: {name} decided so. "
        f"Those kept before go after {_days(days)}; /archive erase erases them at once."
    )


def archive_off(count: int) -> str:
    """Return that a chat is not kept."""
    if not count:
        return "The messages of this chat are not kept."
    return f"The messages of this chat are not kept now. {_entries(count)} of before are left."


def archive_on(name: str, since: str, days: int, count: int, most_bytes: int) -> str:
    """Return that a chat is kept."""
    return (
        f"The messages of this chat are kept since {since}, for {_days(days)}: {name} decided so. "
        f"Kept now: {_entries(count)}, {size(most_bytes)}."
    )


def _days(count: int) -> str:
    return "1 day" if count == 1 else f"{count} days"


def _entries(count: int) -> str:
    return "1 entry" if count == 1 else f"{count} entries"


# ---- shared data ----

HOW_TO_KEEP: Final = (
    "Write /data and a robot's name to see what it keeps, /data NAME = VALUE to keep something "
    "yourself, /data ROBOT NAME = VALUE to keep it with a robot you have now; an empty value "
    "removes it."
)
TO_EXPORT: Final = "rosic container export"
DATA_STORED: Final = "Data stored."
DATA_REMOVED: Final = "Data removed."
YOU: Final = "Your container"
