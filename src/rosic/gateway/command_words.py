"""What people type to ask for something, in their language; shown by help, menus and buttons."""

from __future__ import annotations

import re
from itertools import takewhile
from typing import TYPE_CHECKING, Final

from rosic.core.i18n import in_language, joined, said
from rosic.core.language.time_words import shown_when
from rosic.core.local_time import LocalTime
from rosic.organiser.calendar_messages import day

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.core.i18n import Catalogue
    from rosic.core.language.command import Command, CommandTable

_SET: Final = {
    "units": said("units"),
    "metric": said("metric"),
    "imperial": said("imperial"),
    "speed": said("speed"),
    "robot": said("robot"),
    "none": said("none"),
}
_VERBS: Final = {
    "on": said("on"),
    "off": said("off"),
    "add": said("add"),
    "erase": said("erase"),
    "export": said("export"),
    "me": said("me"),
}
"""What is to be done by a command, where it is the first word behind it."""
_DATE: Final = re.compile(r"(\d{4})-(\d\d)-(\d\d)\Z", re.ASCII)


def offered(command: str, named: Callable[[str], str], commands: CommandTable) -> str:
    """Return how a button reads that says a command: as a phrase where there is one for it.

    Args:
        command: As it would be typed.
        named: Returns how the robot or group of a name is shown; empty for any other word.
        commands: What can be asked of ROSIC itself.
    """
    declared = commands.find(command)
    if declared is not None and declared.alone:
        return declared.alone
    words = command.split(" ")
    for many in (2, 1):
        head, rest = commands.find(" ".join(words[:many])), words[many:]
        robots = list(takewhile(named, rest))
        if head is not None and head.phrase is not None and robots:
            others = rest[len(robots) :]
            when = joined(" ", map(_day_shown if head.timed else str, others))
            return head.phrase(joined(", ", filter(None, (*map(named, robots), when))))
    verb, _, follows = command.partition(" ")
    typed = commands.find(verb.removeprefix("/")) if verb.startswith("/") else None
    if typed is None or not typed.typed:
        return command
    return joined(" ", filter(None, (typed.typed, _follows(follows))))


def _follows(rest: str) -> str:
    """Return what follows a command as the reader types it: ``units imperial``, ``export``."""
    first, *others = rest.split(" ")
    shown = _VERBS.get(first) or _SET.get(first) or first
    return joined(" ", (shown, *(_SET.get(word) or word for word in others)))


def _day_shown(word: str) -> str:
    """Return a date as people say it, any other word as it is."""
    found = _DATE.match(word)
    if found is None:
        return shown_when(word)
    local = LocalTime(*map(int, found.groups()))
    return day(local, local)


def menu_name(command: Command, catalogue: Catalogue | None) -> str:
    """Return a command as a menu names it; in English where a menu cannot spell the word."""
    if not command.typed:
        return command.name
    found = in_language(command.typed, catalogue).removeprefix("/")
    return found if found.isascii() and found.isalnum() else command.name
