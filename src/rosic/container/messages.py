"""Every sentence about containers: settings, shared data, archives. Nothing else makes one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import figure, joined, said, said_n
from rosic.core.language.sanitise import quote
from rosic.core.language.suggestions import listed

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

KIB: Final = 1024
_FEW: Final = 10

# ---- settings ----

HOW_FAST: Final = said("Say how fast you want to go at most, with its unit: 0.2 m/s. Or say none.")
SETTINGS_DAMAGED: Final = said(
    "Your settings cannot be read any more, and a highest speed may be among them. Until you say "
    "one, you go slowly: /settings speed 0.2 m/s, or /settings speed none."
)
SPEED_NOT_POSITIVE: Final = said("A highest speed must be above 0. To go nowhere, say stop.")
WHICH_UNITS: Final = said(
    "Lengths and speeds can be shown in metric or in imperial units. Say which."
)
WHICH_ZONE: Final = said(
    "Say the time zone of the place where you are: Europe/Vienna. Or say none."
)


def no_language(given: str, names: Iterable[str]) -> str:
    """Return that a language is not spoken here."""
    known = listed(tuple(names))
    return (
        said("I do not speak {quote}. I speak {known}.", quote=quote(given), known=known)
        if given
        else said("I speak {known}.", known=known)
    )


def no_such_robot(given: str) -> str:
    """Return that a robot cannot be the usual one."""
    return said("You see no robot {quote}.", quote=quote(given))


def no_robot_so_fast(unit: str) -> str:
    """Return that a speed is a speed of no robot here."""
    return said(
        "No robot here is given a speed in {quote}. {how_fast}",
        quote=quote(unit),
        how_fast=HOW_FAST,
    )


# ---- shared data ----

VALUE_EMPTY: Final = said("There is nothing to keep. Write a name and a value.")
NAME: Final = said("name")
VALUE: Final = said("value")
NAME_EMPTY: Final = said("What is kept needs a name.")
NOT_YOURS: Final = said("You may not read that.")


def not_yours_to_keep(shown: str) -> str:
    """Return that only whoever works with a robot keeps data with it."""
    return said(
        "Only whoever has {shown} now can keep data with it. Nothing was kept.", shown=shown
    )


def too_long(what: str, most: int) -> str:
    """Return that a name or a value is too long."""
    return said(
        "A {what} can have at most {most} characters. Nothing was kept.", what=what, most=most
    )


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
    return said(
        "{shown} keeps at most {size}. Nothing was kept. Remove something first.",
        shown=shown,
        size=size(most_bytes),
    )


def nothing_kept(shown: str, name: str = "") -> str:
    """Return that there is nothing."""
    return (
        said("{shown} keeps nothing called {quote}.", shown=shown, quote=quote(name))
        if name
        else said("{shown} keeps nothing yet.", shown=shown)
    )


# ---- archives ----

ALREADY_ON: Final = said("The messages of this chat are being kept already.")
NOT_ON: Final = said("The messages of this chat are not being kept.")
TOO_MANY_ARCHIVES: Final = said(
    "As many chats as possible are being kept already. Nothing has changed here. "
    "The operator can end another one."
)
NO_SPREADSHEET: Final = said(
    "A spreadsheet cannot be made on this computer yet. Its owner can install what "
    "it takes: pip install 'rosic[export]', in a checkout .venv/bin/pip install -e '.[export]'."
)
ERASED: Final = "(erased)"
CUT: Final = "… (cut)"


def days_wrong(most: int) -> str:
    """Return that messages cannot be kept so long."""
    return said("Messages can be kept from 1 to {most} days. Nothing has changed.", most=most)


def gap(begin: str, end: str) -> str:
    """Return the line of an archive that stands for a time in which nobody listened."""
    return said(
        "(not listening from {begin} to {end}: messages may be missing here)", begin=begin, end=end
    )


def lost(begin: str, end: str) -> str:
    """Return the line of an archive that stands for what could not be written down."""
    return said(
        "(could not be written down from {begin} to {end}: messages are missing here)",
        begin=begin,
        end=end,
    )


def older_gone(count: int) -> str:
    """Return the first line of an archive that no longer begins at its beginning."""
    return said_n(
        "({n} older entry is no longer kept)", "({n} older entries are no longer kept)", count
    )


# ---- sizes and lists ----


def size(count: int) -> str:
    """Return a number of bytes as it is said."""
    if count < KIB:
        return said("{count} bytes", count=count)
    number, unit = (count / KIB, "KiB") if count < KIB * KIB else (count / KIB / KIB, "MiB")
    return figure(f"{number:.0f} {unit}" if number >= _FEW else f"{number:.1f} {unit}")


def kept_line(name: str, value: str, sender: str, ago: str) -> str:
    """Return one line of what a container keeps."""
    return joined("", (name, ": ", value, " (", sender, ", ", ago, ")"))


def kept_lines(shown: str, lines: Sequence[str]) -> str:
    """Return what a container keeps."""
    return joined(
        "\n", [said("{shown} keeps:", shown=shown), *(joined("", ("  ", line)) for line in lines)]
    )
