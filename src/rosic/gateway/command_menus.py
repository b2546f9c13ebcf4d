"""What people are offered while they type: everybody the daily commands, admins their own too."""

from __future__ import annotations

import asyncio
import logging
import re
from itertools import takewhile
from typing import TYPE_CHECKING, Final, TypeAlias

from rosic.core.i18n import in_language, joined, said
from rosic.core.language.command import MenuAudience
from rosic.core.language.time_words import shown_when
from rosic.core.local_time import LocalTime
from rosic.core.message import Menu, MenuScope
from rosic.organiser.calendar_messages import day

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from rosic.authoriser.directory import Directory
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import SetMenus
    from rosic.core.i18n import Catalogue
    from rosic.core.identity import PrincipalId
    from rosic.core.language.command import Command, CommandTable

    _Entries: TypeAlias = Sequence[Command]


# ---- command words ----

# What people type to ask for something, in their language; shown by help, menus and buttons.

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


# ---- command menus ----

ADMINS_AT_MOST: Final = 40
CHOSEN_AT_MOST: Final = 40
"""Each is some calls; further ones find everything in /help."""
SETTLE_S: Final = 2.0
ENGLISH: Final = "en"

log = logging.getLogger("rosic.menus")


class CommandMenus:
    """Works out every menu, and has the messengers show what has changed.

    Args:
        directory: Where people are reached.
        admins: Returns who looks after people here, the same ones first each time.
        catalogues: Other languages than English.
        chosen: Returns which language people chose here, by its code: their own chat's menu is in
            that one, whatever their messenger is set to.
        clock: Waits until a row of changes is over.
        commands: What can be asked for.
    """

    def __init__(
        self,
        directory: Directory,
        admins: Callable[[], Sequence[PrincipalId]],
        catalogues: dict[str, Catalogue],
        chosen: Callable[[], Mapping[PrincipalId, str]],
        clock: Clock,
        commands: CommandTable,
    ) -> None:
        self._everybody = commands.in_menu(MenuAudience.EVERYBODY)
        self._of_admins = commands.in_menu(MenuAudience.ADMINS)
        of_groups = [c for c in self._everybody if c.menu is not None and c.menu.groups]
        self._groups = (*of_groups, *commands.in_menu(MenuAudience.TOPICS))
        self._directory = directory
        self._admins = admins
        self._languages: dict[str, Catalogue | None] = {"": None, **catalogues}
        self._chosen = chosen
        self._clock = clock
        self._platforms: list[tuple[str, SetMenus]] = []
        self._with_own: dict[str, set[str]] = {}
        # Each messenger by itself: one that cannot be reached keeps the others waiting for nothing.
        self._due: set[int] = set()
        self._tasks: dict[int, asyncio.Task[None]] = {}

    def show_on(self, platform: str, set_menus: SetMenus) -> None:
        """Look after the menus of one more messenger."""
        self._platforms.append((platform, set_menus))

    def look(self) -> None:
        """Roles may have changed: see to it soon. Returns at once."""
        for number in range(len(self._platforms)):
            self._due.add(number)
            task = self._tasks.get(number)
            if task is None or task.done():
                self._tasks[number] = asyncio.create_task(self._follow(number))

    async def _follow(self, number: int) -> None:
        platform, set_menus = self._platforms[number]
        while number in self._due:
            await self._clock.sleep(SETTLE_S)
            self._due.discard(number)
            try:
                await set_menus(self.of(platform))
            except Exception:
                log.exception("the menus could not be shown")

    def of(self, platform: str) -> list[Menu]:
        """Return every menu of a platform; an empty one for a chat that has none of its own now."""
        whole = (*self._everybody, *self._of_admins)
        admins = list(self._admins())[:ADMINS_AT_MOST]
        entries: dict[str, _Entries] = {account: whole for _, account in self._at(platform, admins)}
        chosen = self._reading(platform)
        for account in chosen:
            entries.setdefault(account, self._everybody)
        before = self._with_own.setdefault(platform, set())
        menus: list[Menu] = []
        for locale, catalogue in self._languages.items():
            menus.append(Menu(MenuScope.PRIVATE, _said(self._everybody, catalogue), locale))
            menus.append(Menu(MenuScope.GROUPS, _said(self._groups, catalogue), locale))
            menus += [
                Menu(
                    MenuScope.CHAT,
                    _said(entries.get(chat, ()), chosen.get(chat, catalogue)),
                    locale,
                    chat,
                )
                for chat in sorted(before.union(entries))
            ]
        before.clear()
        before.update(entries)
        return menus

    def _reading(self, platform: str) -> dict[str, Catalogue | None]:
        """Return in which language whoever chose one reads, by account."""
        chosen = {
            principal: self._languages["" if code == ENGLISH else code]
            for principal, code in self._chosen().items()
            if code == ENGLISH or code in self._languages
        }
        few = list(chosen)[:CHOSEN_AT_MOST]
        return {account: chosen[principal] for principal, account in self._at(platform, few)}

    def _at(
        self, platform: str, people: Iterable[PrincipalId]
    ) -> Iterator[tuple[PrincipalId, str]]:
        for principal in people:
            person = self._directory.person(principal)
            for address in () if person is None else person.addresses:
                if address.platform == platform:
                    yield principal, address.account

    async def close(self) -> None:
        """Look no more."""
        for task in self._tasks.values():
            task.cancel()
        await asyncio.gather(*self._tasks.values(), return_exceptions=True)


def _said(entries: _Entries, catalogue: Catalogue | None) -> tuple[tuple[str, str], ...]:
    return tuple(
        (menu_name(command, catalogue), in_language(command.summary, catalogue))
        for command in entries
    )
