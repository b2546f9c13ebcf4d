"""Every sentence about containers: settings, shared data, archives. Nothing else makes one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.language.cleaning import quote
from rosic.core.language.suggestions import listed
from rosic.core.saying import said, said_n

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

KIB: Final = 1024
_FEW: Final = 10

# ---- settings ----

HOW_FAST: Final = "Say how fast you want to go at most, with its unit: 0.2 m/s. Or say none."
SETTINGS_DAMAGED: Final = said(
    "Your settings cannot be read any more, and a highest speed may be among them. Until you say "
    "one, you go slowly: /settings speed 0.2 m/s, or /settings speed none."
)
SPEED_NOT_POSITIVE: Final = "A highest speed must be above 0. To go nowhere, say stop."
WHICH_UNITS: Final = "Lengths and speeds can be shown in metric or in imperial units. Say which."
WHICH_ZONE: Final = "Say the time zone of the place where you are: Europe/Vienna. Or say none."


def no_language(said: str, names: Iterable[str]) -> str:
    """Return that a language is not spoken here."""
    known = listed(tuple(names))
    return f"I do not speak {quote(said)}. I speak {known}." if said else f"I speak {known}."


def no_such_robot(said: str) -> str:
    """Return that a robot cannot be the usual one."""
    return f"You see no robot {quote(said)}."


def no_robot_so_fast(unit: str) -> str:
    """Return that a speed is a speed of no robot here."""
    return f"No robot here is given a speed in {quote(unit)}. {HOW_FAST}"


# ---- shared data ----

VALUE_EMPTY: Final = "There is nothing to keep. Write a name and a value."
NAME_EMPTY: Final = "What is kept needs a name."
NOT_YOURS: Final = "You may not read that."


def not_yours_to_keep(shown: str) -> str:
    """Return that only whoever works with a robot keeps data with it."""
    return f"Only whoever has {shown} now can keep data with it. Nothing was kept."


def too_long(what: str, most: int) -> str:
    """Return that a name or a value is too long."""
    return f"A {what} can have at most {most} characters. Nothing was kept."


def too_many_names(shown: str, most: int) -> str:
    """Return that there is no room for a further name."""
    return said_n(
        "{shown} keeps at most {n} name. Nothing was kept. Remove one first.",
        "{shown} keeps at most {n} names. Nothing was kept. Remove one first.",
        most,
        shown=shown,
    )


def shelf_full(shown: str, most_bytes: int) -> str:
    """Return that there is no room for a further value."""
    return f"{shown} keeps at most {size(most_bytes)}. Nothing was kept. Remove something first."


def nothing_kept(shown: str, name: str = "") -> str:
    """Return that there is nothing."""
    return f"{shown} keeps nothing called {quote(name)}." if name else f"{shown} keeps nothing yet."


# ---- archives ----

ALREADY_ON: Final = "The messages of this chat are being kept already."
NOT_ON: Final = "The messages of this chat are not being kept."
TOO_MANY_ARCHIVES: Final = (
    "As many chats as possible are being kept already. Nothing has changed here. "
    "The operator can end another one."
)
NO_SPREADSHEET: Final = (
    "A spreadsheet cannot be made on this computer yet. Its owner can install what it takes: "
    "pip install 'rosic[export]'."
)
ERASED: Final = "(erased)"
CUT: Final = "… (cut)"


def days_wrong(most: int) -> str:
    """Return that messages cannot be kept so long."""
    return f"Messages can be kept from 1 to {most} days. Nothing has changed."


def gap(begin: str, end: str) -> str:
    """Return the line of an archive that stands for a time in which nobody listened."""
    return f"(not listening from {begin} to {end}: messages may be missing here)"


def lost(begin: str, end: str) -> str:
    """Return the line of an archive that stands for what could not be written down."""
    return f"(could not be written down from {begin} to {end}: messages are missing here)"


def older_gone(count: int) -> str:
    """Return the first line of an archive that no longer begins at its beginning."""
    return f"({count} older {'entry is' if count == 1 else 'entries are'} no longer kept)"


# ---- sizes and lists ----


def size(count: int) -> str:
    """Return a number of bytes as it is said."""
    if count < KIB:
        return f"{count} bytes"
    number, unit = (count / KIB, "KiB") if count < KIB * KIB else (count / KIB / KIB, "MiB")
    return f"{number:.0f} {unit}" if number >= _FEW else f"{number:.1f} {unit}"


def age(seconds: float) -> str:
    """Return how long ago something was."""
    for length, unit in ((86_400, "d"), (3_600, "h"), (60, "min")):
        if seconds >= length:
            return f"{seconds // length:.0f} {unit} ago"
    return f"{max(seconds, 0):.0f} s ago"


def kept_line(name: str, value: str, sender: str, ago: str) -> str:
    """Return one line of what a container keeps."""
    return f"{name}: {value} ({sender}, {ago})"


def kept_lines(shown: str, lines: Sequence[str]) -> str:
    """Return what a container keeps."""
    return "\n".join([f"{shown} keeps:", *(f"  {line}" for line in lines)])
