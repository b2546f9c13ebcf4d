"""What help there is about one word: a page, or what a command says of itself."""

from __future__ import annotations

from typing import Final

from rosic.core.language.ast import CommandLine, Help
from rosic.core.language.keywords import ALIASES, HELP_PAGES, PAGE_ALIASES

# Said alone, these change nothing: they say how they are said, or show what there is. So that is
# the help about them.
EXPLAINED: Final = frozenset(
    {
        "ask", "assist", "book", "broadcast", "grant", "invite", "me", "mission", "missions",
        "mute", "people", "quiet", "role", "settings", "share", "shelf", "strategy", "task",
        "tasks", "together", "wish",
    }
)  # fmt: skip
# The page on which the others stand.
PAGE_OF: Final = {
    "again": "move", "cancel": "move", "undo": "move", "continue": "move", "resume": "move",
    "card": "see", "chart": "see", "clip": "see", "history": "see", "map": "see",
    "picture": "see", "status": "see", "trajectory": "see",
    "files": "share", "handover": "share", "lock": "share", "mydata": "share", "plan": "share",
    "revoke": "share", "security": "share", "slots": "share", "wait": "share",
    "fleet": "fleet", "alerts": "alarms",
}  # fmt: skip
HELP_WORDS: Final = frozenset({"?", "help", "hilfe"})


def help_named(word: str) -> CommandLine | Help | None:
    """Return what is said about a word in small letters; None where it is no page, no command."""
    page = PAGE_ALIASES.get(word, word)
    if page in HELP_PAGES:
        return Help(page)
    command = ALIASES.get(word, word)
    if command in EXPLAINED:
        return CommandLine(command, "")
    return Help(PAGE_OF[command]) if command in PAGE_OF else None
