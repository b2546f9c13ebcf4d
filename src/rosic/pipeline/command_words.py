"""What people type to ask for something, in their language; shown by help, menus and buttons."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.language.clock_words_elsewhere import shown_when
from rosic.core.saying import in_language, joined, said

if TYPE_CHECKING:
    from rosic.core.saying import Catalogue

# What to type. A translation is understood: it stands in `rosic.core.language.words.ALIASES`.
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


# The same where a button says it: a word, then whom it is about.
_LABELLED: Final = {
    "book": said("book"),
    "wish": said("wish"),
    "wait": said("wait"),
    "help": said("help"),
    "resume": said("resume"),
    "resume all": said("resume all"),
    "robots": said("robots"),
    "use": said("use"),
    "chart": said("chart"),
    "trajectory": said("trajectory"),
    "cancel booking": said("cancel booking"),
    "take over": said("take over"),
}
_SET: Final = {
    "units": said("units"),
    "metric": said("metric"),
    "imperial": said("imperial"),
    "speed": said("speed"),
    "robot": said("robot"),
    "none": said("none"),
}
_TIMED: Final = frozenset({"book", "wish"})


def offered(command: str) -> str:
    """Return how a button reads that says a command: its first words in the reader's language."""
    head, _, rest = command.partition(" ")
    follows, _, last = rest.partition(" ")
    for words, others in ((f"{head} {follows}", last), (head, rest)):
        if words in _LABELLED:
            named = shown_when(others) if words in _TIMED else others
            return joined(" ", filter(None, (_LABELLED[words], named)))
    typed = TYPED.get(head.removeprefix("/")) if head.startswith("/") else None
    return command if typed is None else joined(" ", filter(None, (typed, _settings(rest))))


def _settings(rest: str) -> str:
    """Return the words of a setting as the reader types them: ``units imperial``."""
    return joined(" ", (_SET.get(word) or word for word in rest.split(" ")))


def menu_name(name: str, catalogue: Catalogue | None) -> str:
    """Return a command as a menu names it; in English where a menu cannot spell the word."""
    typed = TYPED.get(name)
    found = name if typed is None else in_language(typed, catalogue).removeprefix("/")
    return found if found.isascii() and found.isalnum() else name
