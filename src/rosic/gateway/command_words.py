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
    from collections.abc import Callable, Mapping

    from rosic.core.i18n import Catalogue

# What to type. A translation is understood: it stands in `rosic.core.language.keywords.ALIASES`.
# With a slash only where a messenger makes all of it a link, one word in ASCII: what is tapped of
# a longer one is its first word alone, and /cancel ends what is under way.
TYPED: Final = {
    "again": said("/again"),
    "use": said("/use"),
    "undo": said("/undo"),
    "stop": said("/stop"),
    "resume": said("/resume"),
    "robots": said("/robots"),
    "status": said("/status"),
    "card": said("/card"),
    "history": said("/history"),
    "picture": said("/picture"),
    "map": said("/map"),
    "trajectory": said("/trajectory"),
    "chart": said("/chart"),
    "slots": said("/slots"),
    "book": said("/book"),
    "wish": said("/wish"),
    "wait": said("/wait"),
    "cancel": said("/cancel"),
    "cancel booking": said("cancel booking"),
    "handover": said("/handover"),
    "me": said("/me"),
    "role": said("/role"),
    "ask": said("/ask"),
    "settings": said("/settings"),
    "files": said("/files"),
    "mydata": said("/mydata"),
    "people": said("/people"),
    "invite": said("/invite"),
    "grant": said("/grant"),
    "revoke": said("/revoke"),
    "lock": said("/lock"),
    "security": said("/security"),
    "plan": said("/plan"),
    "fleet": said("/fleet"),
    "together": said("/together"),
    "task": said("/task"),
    "tasks": said("/tasks"),
    "mission": said("/mission"),
    "alerts": said("/alerts"),
    "mute": said("/mute"),
    "share": said("/share"),
    "shelf": said("/shelf"),
}


# The same where a button says it: what is done, to whom.
_PHRASES: Final[Mapping[str, Callable[[str], str]]] = {
    "book": lambda what: said("Book {what}", what=what),
    "wish": lambda what: said("Wish for {what}", what=what),
    "wait": lambda what: said("Wait for {what}", what=what),
    "help": lambda what: said("help {what}", what=what),
    "resume": lambda what: said("Resume {shown}", shown=what),
    "use": lambda what: said("Choose {what}", what=what),
    "chart": lambda what: said("Chart of {what}", what=what),
    "trajectory": lambda what: said("Trajectory of {what}", what=what),
    "slots": lambda what: said("Times of {what}", what=what),
    "take over": lambda what: said("Take over {what}", what=what),
}
_SET: Final = {
    "units": said("units"),
    "metric": said("metric"),
    "imperial": said("imperial"),
    "speed": said("speed"),
    "robot": said("robot"),
    "none": said("none"),
}
_ALONE: Final = {
    "help": said("help"),
    "wish": said("Wishes"),
    "robots": said("Robots"),
    "resume all": said("Resume all"),
    "cancel booking": said("Give a time back"),
}
_TIMED: Final = frozenset({"book", "wish", "slots"})
_DATE: Final = re.compile(r"(\d{4})-(\d\d)-(\d\d)\Z", re.ASCII)


def offered(command: str, named: Callable[[str], str]) -> str:
    """Return how a button reads that says a command: as a phrase where there is one for it.

    Args:
        command: As it would be typed.
        named: Returns how the robot or group of a name is shown; empty for any other word.
    """
    if command in _ALONE:
        return _ALONE[command]
    words = command.split(" ")
    for many in (2, 1):
        head, rest = " ".join(words[:many]), words[many:]
        robots = list(takewhile(named, rest))
        if head in _PHRASES and robots:
            others = rest[len(robots) :]
            when = joined(" ", map(_day_shown if head in _TIMED else str, others))
            return _PHRASES[head](joined(", ", filter(None, (*map(named, robots), when))))
    verb, _, follows = command.partition(" ")
    typed = TYPED.get(verb.removeprefix("/")) if verb.startswith("/") else None
    return command if typed is None else joined(" ", filter(None, (typed, _settings(follows))))


def _settings(rest: str) -> str:
    """Return the words of a setting as the reader types them: ``units imperial``."""
    return joined(" ", (_SET.get(word) or word for word in rest.split(" ")))


def _day_shown(word: str) -> str:
    """Return a date as people say it, any other word as it is."""
    found = _DATE.match(word)
    if found is None:
        return shown_when(word)
    local = LocalTime(*map(int, found.groups()))
    return day(local, local)


def menu_name(name: str, catalogue: Catalogue | None) -> str:
    """Return a command as a menu names it; in English where a menu cannot spell the word."""
    typed = TYPED.get(name)
    found = name if typed is None else in_language(typed, catalogue).removeprefix("/")
    return found if found.isascii() and found.isalnum() else name
