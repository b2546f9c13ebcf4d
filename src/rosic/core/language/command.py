"""Commands as data: what is asked of ROSIC itself, declared once, by whoever answers it.

The words of the grammar, ``help``, menus, completion, what is left out of archives and the table in
``docs/language.md`` are read from here. ``docs/howto/add-a-command.md`` adds one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from enum import StrEnum
from typing import Final, NamedTuple

import msgspec

from rosic.core.i18n import said
from rosic.core.language.ast import CommandLine, Help
from rosic.core.language.keywords import HELP_PAGES, PAGE_ALIASES


class HelpPage(StrEnum):
    """A page of ``help``."""

    MOVE = "move"
    SEE = "see"
    SHARE = "share"
    FLEET = "fleet"
    ALARMS = "alarms"


class HelpNeed(StrEnum):
    """What somebody must be able to do here for a command to stand on a page of ``help``."""

    NOTHING = "nothing"
    MOTION = "motion"
    """Move a robot."""
    RESUME = "resume"
    """Let a stopped robot move again."""
    PICTURE = "picture"
    """See a robot that has a camera; it is named."""
    MAP = "map"
    """See a robot that has a map; it is named."""
    POSE = "pose"
    """See a robot that says where it is; it is named."""
    TELEMETRY = "telemetry"
    """See a robot that reports values; it is named."""
    BOOKING = "booking"
    """Move a robot whose time can be booked."""
    GRANT = "grant"
    """Give rights to others."""
    TOGETHER = "together"
    """Move a whole group; an order to one is shown before the command."""


class HelpEntry(NamedTuple):
    """Where a command stands in ``help``.

    Attributes:
        page: The page.
        rank: Its place there: the lower, the earlier. One rank of a page belongs to one command.
        needs: What somebody must be able to do for it, or a right about the place (``invite``).
    """

    page: HelpPage
    rank: int
    needs: HelpNeed | str = HelpNeed.NOTHING


class MenuAudience(StrEnum):
    """In whose menus a command stands."""

    EVERYBODY = "everybody"
    ADMINS = "admins"
    TOPICS = "topics"
    """Of a group that has topics."""


class MenuEntry(NamedTuple):
    """Where a command stands in the menus of messengers.

    Attributes:
        rank: Its place: the lower, the earlier. One rank belongs to one command.
        audience: In whose menus.
        groups: Whether it stands in the menus of groups, too.
    """

    rank: int
    audience: MenuAudience = MenuAudience.EVERYBODY
    groups: bool = False


class Command(msgspec.Struct, frozen=True, kw_only=True):
    """One command, whatever becomes of it: its handler is registered beside it.

    Attributes:
        name: The word, in small letters. With a blank in it, it is said of another (``cancel
            booking``), and is no word of the grammar by itself.
        aliases: The same in other languages, one word each. None of them is reserved: where a
            robot, a group or a skill is called so, that is meant.
        pairs: The same in two words, and nothing after them.
        typed: How it is typed in the reader's language: ``said("/book")``. A translation of it
            stands among the aliases. Empty: as it is called.
        summary: What it is for; in ``help`` and menus.
        page: Where ``help NAME`` leads, if it does not stand on a page.
        verbs: Words in other languages that may follow, each with the English one that it means.
        explained: Said alone it changes nothing: it says how it is said, or shows what there is. So
            ``help NAME`` says that.
        observes: It shows something and changes nothing, whatever follows it: so it is answered
            where nobody can be sure who asks.
        redacted_unless: What stands behind it lets somebody in, so none of it is kept; except this
            word. None: nothing secret stands behind it.
        help: Its place in ``help``. None: it stands in none.
        menu: Its place in menus. None: it stands in none.
        phrase: Returns how a button reads that says it of a robot (as it is shown).
        alone: How a button reads that says it and nothing else.
        timed: What follows in such a button are times.
        cancelled_by: The command that takes ``cancel NAME ...``, as ``... cancel``. Empty: none.
        hint: What it is, for completion in the terminal. Empty: it is not completed.
        of_robots: Names of robots follow it, for completion.
        grammar: The grammar itself gives it a meaning, and nobody may call a robot or a skill so.
        spoken: Somebody may say it. If not, another command is passed on to it, or only the secret
            behind it counts.
    """

    name: str
    aliases: tuple[str, ...] = ()
    pairs: tuple[tuple[str, str], ...] = ()
    typed: str = ""
    summary: str = ""
    page: HelpPage | None = None
    verbs: Mapping[str, str] = {}
    explained: bool = False
    observes: bool = False
    redacted_unless: str | None = None
    help: HelpEntry | None = None
    menu: MenuEntry | None = None
    phrase: Callable[[str], str] | None = None
    alone: str = ""
    timed: bool = False
    cancelled_by: str = ""
    hint: str = ""
    of_robots: bool = False
    grammar: bool = False
    spoken: bool = True


GRAMMAR: Final = (
    Command(
        name="help",
        aliases=("hilfe",),
        summary=said("What you can say"),
        menu=MenuEntry(150, groups=True),
        phrase=lambda what: said("help {what}", what=what),
        alone=said("help"),
        hint="what can be said",
        of_robots=True,
        grammar=True,
    ),
    Command(
        name="resume",
        aliases=("freigeben",),
        typed=said("/resume"),
        summary=said("Let a stopped robot move again"),
        help=HelpEntry(HelpPage.MOVE, 60, HelpNeed.RESUME),
        menu=MenuEntry(70, groups=True),
        phrase=lambda what: said("Resume {shown}", shown=what),
        hint="undo a stop",
        of_robots=True,
        grammar=True,
    ),
    Command(
        name="robots",
        aliases=("roboter", "menu", "menü", "hauptmenü"),
        typed=said("/robots"),
        summary=said("The robots you may see"),
        help=HelpEntry(HelpPage.SEE, 10),
        menu=MenuEntry(10, groups=True),
        alone=said("Robots"),
        hint="which robots there are",
        grammar=True,
    ),
    Command(
        name="start",
        summary="what the link of an invitation says",
        redacted_unless="",
        grammar=True,
    ),
    Command(
        name="status",
        aliases=("zustand",),
        typed=said("/status"),
        summary=said("What every robot is doing"),
        help=HelpEntry(HelpPage.SEE, 20),
        menu=MenuEntry(20, groups=True),
        hint="how the robots are",
        of_robots=True,
        grammar=True,
    ),
    Command(
        name="use",
        aliases=("nimm",),
        typed=said("/use"),
        summary=said("Choose a robot, so that its name may be left out"),
        help=HelpEntry(HelpPage.MOVE, 20, HelpNeed.MOTION),
        menu=MenuEntry(30, groups=True),
        phrase=lambda what: said("Choose {what}", what=what),
        hint="choose a robot, so that its name may be left out",
        of_robots=True,
        grammar=True,
    ),
    Command(
        name="stop",
        typed=said("/stop"),
        summary=said("Stop every robot you may see"),
        help=HelpEntry(HelpPage.MOVE, 40),
        menu=MenuEntry(50, groups=True),
        hint="stop, at once; everything if no robot is named",
        of_robots=True,
        grammar=True,
    ),
    Command(name="resume all", alone=said("Resume all"), grammar=True),
)
"""What the grammar itself gives a meaning, whatever else is declared."""


VERBS: Final = frozenset(
    command.name for command in GRAMMAR if " " not in command.name and command.name != "stop"
)
"""A stop is looked for before the grammar reads anything."""


class CommandTable:
    """All commands of a gateway, those of the grammar among them, looked up by what is said.

    Attributes:
        words: What is a command if nothing else is called so.
        aliases: From a word in another language to the command.
        pairs: From two words to the command.
        secret: From the words behind which something secret stands to the exempt word there.

    Raises:
        ValueError: Two commands share a word, a place on a page or a place in a menu.
    """

    def __init__(self, commands: Iterable[Command]) -> None:
        self._by_name: dict[str, Command] = {}
        self.aliases: dict[str, str] = {}
        self.pairs: dict[tuple[str, ...], str] = {}
        places: set[object] = set()
        for command in (*GRAMMAR, *commands):
            said_as = (command.name, *command.aliases)
            taken = [word for word in said_as if word in self._by_name or word in self.aliases]
            here = [
                *([command.help[:2]] if command.help else ()),
                *([("menu", command.menu.rank)] if command.menu else ()),
            ]
            if taken or not places.isdisjoint(here):
                raise ValueError(f"the command {command.name} takes the place of another")
            self._by_name[command.name] = command
            self.aliases.update(dict.fromkeys(command.aliases, command.name))
            self.pairs.update(dict.fromkeys(command.pairs, command.name))
            places.update(here)
        self.words = frozenset(
            name
            for name, command in self._by_name.items()
            if command.spoken and not command.grammar and " " not in name
        )
        self.secret: dict[str, str] = {
            word: command.redacted_unless
            for command in self
            if command.redacted_unless is not None
            for word in (command.name, *command.aliases)
        }

    def verb(self, command: str, word: str) -> str:
        """Return what is to be done by a command, by the word in small letters that follows it."""
        return self._by_name[command].verbs.get(word, word)

    def __iter__(self) -> Iterator[Command]:
        return iter(self._by_name.values())

    def find(self, word: str) -> Command | None:
        """Return the command of a word in small letters, whatever its language."""
        return self._by_name.get(self.aliases.get(word, word))

    def explains(self, word: str) -> bool:
        """Whether a command, said alone, says how it is said."""
        return self._by_name[word].explained

    def on_page(self, page: HelpPage) -> list[Command]:
        """Return what stands on a page of ``help``, in its order."""
        here = [(c.help.rank, c) for c in self if c.help is not None and c.help.page is page]
        return [command for _, command in sorted(here, key=lambda ranked: ranked[0])]

    def in_menu(self, audience: MenuAudience) -> list[Command]:
        """Return what stands in somebody's menus, in its order."""
        here = [
            (c.menu.rank, c) for c in self if c.menu is not None and c.menu.audience is audience
        ]
        return [command for _, command in sorted(here, key=lambda ranked: ranked[0])]


NO_COMMANDS: Final = CommandTable(())
"""Where robots alone are spoken to, as in a file: nothing but the words of the grammar."""


# ---- help about one word ----


def help_named(word: str, commands: CommandTable) -> CommandLine | Help | None:
    """Return what is said about a word in small letters; None where it is no page, no command."""
    page = PAGE_ALIASES.get(word, word)
    if page in HELP_PAGES:
        return Help(page)
    command = commands.find(word)
    if command is None:
        return None
    if command.explained:
        return CommandLine(command.name, "")
    leads = command.page or (command.help.page if command.help is not None else None)
    return None if leads is None else Help(leads.value)
