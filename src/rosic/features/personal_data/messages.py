"""Every sentence that a chat or a terminal is told about what is kept."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.container.messages import size
from rosic.container.preferences import IMPERIAL, METRIC, OFF, ON, TOLD
from rosic.core.i18n import joined, said, said_n
from rosic.core.language.sanitise import quote
from rosic.core.language.suggestions import AND
from rosic.core.policy.limits import quantity_in_words

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from rosic.container.export import ContainerSummary
    from rosic.container.preferences import Preferences


SAVED: Final = said("Saved.")
LEAVE_IT: Final = said("Leave it")
NOT_READABLE: Final = said(
    "I cannot read what is kept now. Nothing was changed. Try again in a while."
)
NO_SUCH_CONTAINER: Final = said("There is no such container.")

# ---- settings ----

HOW_TO_SET: Final = said(
    "Write what and how, for example: /settings speed 0.2 m/s, /settings units "
    "imperial, /settings robot none, /settings zone Europe/Vienna, /settings "
    "language en"
)


METRIC_SAID, IMPERIAL_SAID = said("metric"), said("imperial")
UNITS_SAID: Final[Mapping[str, str]] = {METRIC: METRIC_SAID, IMPERIAL: IMPERIAL_SAID}


def no_such_setting(given: str) -> str:
    """Return that there is nothing of that name to set."""
    return said(
        "There is no setting {quote}. {how_to_set}", quote=quote(given), how_to_set=HOW_TO_SET
    )


# In every language its own name: whoever reads it reads that language.
THIS_LANGUAGE: Final = said("English")


def language(language: str, names: Iterable[str]) -> str:
    """Return which language somebody reads, and which there are."""
    return said(
        "Language: {language}. I speak {names}.",
        language=language,
        names=joined(AND, tuple(names)),
    )


INTERPRETED: Final = said("What I do not understand")
INTERPRETED_SAID: Final[Mapping[str, str]] = {
    ON: said("may be shown to an interpreter"),
    TOLD: said("may be shown to an interpreter"),
    OFF: said("is shown to nobody"),
}


def settings(kept: Preferences, language: str, robot: str, zone: str) -> str:
    """Return everything that somebody has set, and what holds where they have set nothing."""
    speed = kept.speed.partition("<=")[2].strip()
    shown = INTERPRETED_SAID.get(kept.interpreter)
    lines = (
        (said("Language"), language),
        (said("Units"), UNITS_SAID.get(kept.units, METRIC_SAID)),
        (said("Robot, when none is named"), robot or said("none")),
        (said("Highest speed"), _speed(speed)),
        (said("Time zone"), zone),
        *(((INTERPRETED, shown),) if shown else ()),
    )
    return joined(
        "\n",
        [
            said("Your settings:"),
            *(joined("", ("  ", what, ": ", value)) for what, value in lines),
            HOW_TO_SET,
        ],
    )


def _speed(limit: str) -> str:
    return quantity_in_words(limit) if limit else said("whatever each robot allows")


def speed_set(speed: str, robots: Sequence[str]) -> str:
    """Return what a highest speed touches."""
    given = speed.partition("<=")[2].strip()
    return said(
        "Saved. Nothing you command goes faster than {speed}. It holds for {robots}.",
        speed=quantity_in_words(given),
        robots=joined(", ", robots),
    )


# ---- my data ----

KINDS: Final[Mapping[str, str]] = {
    "archived": said("your messages in chats that are kept"),
    "card": said("your name and your addresses"),
    "chat-mission": said("missions you put together"),
    "command": said("your commands, and where I answered"),
    "file": said("files you sent"),
    "fleet-card": said("your view of all robots"),
    "habits": said("what you often ask for"),
    "file-part": said("what is in them"),
    "invitation": said("invitations you made"),
    "mission-draft": said("a mission you are putting together"),
    "mission-time": said("missions you planned"),
    "message": said("which messages showed your commands"),
    "outcome": said("how your commands ended"),
    "pending": said("your request to come in"),
    "preference": said("your settings"),
    "scheduled-order": said("orders you planned"),
    "retract": said("which messages I take away later"),
    "shared-ear": said("where you hear what robots share"),
    "shelf": said("data you keep"),
    "shelf-loan": said("data you share"),
    "task-letter": said("what you wrote of tasks"),
    "totp": said("your authenticator"),
    "unsaid": said("what I still have to tell you"),
}
NOTHING_KEPT: Final = said("Nothing about you is kept.")
SEALED: Final = said("It is sealed with a key of your own. /forget me erases that key.")
OPEN: Final = said(
    "In the open stand only numbers: that an id gave which robot which command "
    "when, and who decided what about that id."
)
EXPORT: Final = said("Show all of it")
FORGET: Final = said("Forget me")


def my_data(sums: Iterable[ContainerSummary]) -> str:
    """Return what is kept about somebody."""
    lines = [
        joined("", ("  ", KINDS.get(s.kind, s.kind), ": ", s.count, " (", size(s.size), ")"))
        for s in sums
    ]
    if not lines:
        return NOTHING_KEPT
    return joined("\n", [said("What is kept about you:"), *lines, SEALED, OPEN])


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

HOW_TO_FORGET: Final = said("To have everything about you erased here, write: /forget me")
ONLY_ME: Final = said(
    "You can have only yourself forgotten. An admin can end somebody's access with "
    "/revoke, and the operator can erase them."
)
SURE: Final = said(
    "Shall I forget you? Your access ends at once, your times are given back, and "
    "everything here that names you or repeats your words becomes unreadable for "
    "good. Numbers stay: that somebody gave which command when. What you wrote "
    "stays in this messenger. Backups made earlier stay readable for whoever has "
    "them and the key that belongs to them."
)
YES_FORGET: Final = said("Forget me for good")
LAST_ADMIN: Final = said(
    "You are the only admin here, so nobody could let anybody in any more. Nothing "
    "was erased. Make somebody else admin first: /grant NAME admin."
)
FORGOTTEN: Final = said("You are forgotten here. Farewell.")
FORGOTTEN_MOVING: Final = said(
    "You are forgotten here. A robot of yours has not confirmed that it is at rest: "
    "please look, and use its own stop button if need be."
)
NOT_ERASED_YET: Final = said(
    "Your access has ended, but the record could not be cleared now. It is tried "
    "again until it is done; the operator has been told."
)
NOBODY: Final = said("There is nobody of that id, or they were erased before.")


def in_use(shown: str, who: str) -> str:
    """Return why a robot's container cannot be erased now."""
    return said(
        "{robot} is in use now, by {who}. Nothing was erased. Try again when it is free.",
        robot=shown,
        who=who,
    )


def last_admin(name: str) -> str:
    """Return why the operator cannot erase somebody."""
    return said(
        "{name} is the only admin here. Nothing was erased. Make somebody else admin first: "
        "/grant NAME admin.",
        name=name,
    )


def erased(name: str, *, at_rest: bool) -> str:
    """Return that somebody was erased, to whoever did it."""
    if at_rest:
        return said(
            "{name} is erased. Copies of the record made before stay readable with their key.",
            name=name,
        )
    return said(
        "{name} is erased, but a robot of theirs has not confirmed that it is at rest. Look.",
        name=name,
    )


# ---- archives ----

HOW_TO_ARCHIVE: Final = said(
    "Write /archive on, /archive on 30 days, /archive off, /archive erase, or "
    "/archive export with text, jsonl or xlsx."
)
NOT_YOURS: Final = said("Only an admin decides whether messages are kept, and takes them out.")


def spreadsheet_later(command: str) -> str:
    """Return who can make a spreadsheet where no file can be sent."""
    return said(
        "A spreadsheet cannot be sent in a message. The operator can make it: {command} --as xlsx",
        command=command,
    )


NO_MESSAGES: Final = said("No message of this chat is kept.")
ERASE_SURE: Final = said("Shall every message of this chat that is kept be erased?")
YES_ERASE: Final = said("Erase them")
ARCHIVE_ERASED: Final = said(
    "Every message of this chat that was kept is erased, and none is kept now."
)


def begun(name: str, days: int) -> str:
    """Return what a chat is told when its messages begin to be kept."""
    return said(
        "From now on the messages of this chat are kept for {days}: {name} decided so. "
        "Everybody here may ask with /archive. They are sealed; what I write is kept, "
        "too.",
        days=_days(days),
        name=name,
    )


def ended(name: str, days: int) -> str:
    """Return what a chat is told when its messages are kept no longer."""
    return said(
        "From now on the messages of this chat are not kept: {name} decided so. Those "
        "kept before go after {days}; /archive erase erases them at once.",
        name=name,
        days=_days(days),
    )


def archive_off(count: int) -> str:
    """Return that a chat is not kept."""
    if not count:
        return said("The messages of this chat are not kept.")
    return said(
        "The messages of this chat are not kept now. {entries} of before are left.",
        entries=_entries(count),
    )


def archive_on(name: str, since: str, days: int, count: int, most_bytes: int) -> str:
    """Return that a chat is kept."""
    return said(
        "The messages of this chat are kept since {since}, for {days}: {name} decided "
        "so. Kept now: {entries}, {size}.",
        since=since,
        days=_days(days),
        name=name,
        entries=_entries(count),
        size=size(most_bytes),
    )


def _days(count: int) -> str:
    return said_n("{n} day", "{n} days", count)


def _entries(count: int) -> str:
    return said_n("{n} entry", "{n} entries", count)


# ---- shared data ----

HOW_TO_KEEP: Final = said(
    "Write /data and a robot's name to see what it keeps, /data NAME = VALUE to "
    "keep something yourself, /data ROBOT NAME = VALUE to keep it with a robot you "
    "have now; an empty value removes it."
)
TO_EXPORT: Final = "rosic container export"
DATA_STORED: Final = said("Data stored.")
DATA_REMOVED: Final = said("Data removed.")
YOU: Final = said("Your container")


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
        names=names,
        names_most=names_most,
        kept=size(kept),
        kept_most=size(kept_most),
    )


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
