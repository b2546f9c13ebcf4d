"""What a messenger may offer while somebody types: commands with a line about each."""

from __future__ import annotations

import enum

import msgspec


class MenuScope(enum.Enum):
    """In which chats a menu is shown."""

    PRIVATE = "private"
    GROUPS = "groups"
    CHAT = "chat"


class Menu(msgspec.Struct, frozen=True):
    """Commands, in one language, for some chats. Showing one gives nobody a right to it.

    Attributes:
        commands: Name without a slash, and what it does; none takes the menu away.
        locale: For whom: ``de``; empty for everybody whose language has no menu.
        chat: Id of the one chat that it is for.
    """

    where: MenuScope
    commands: tuple[tuple[str, str], ...]
    locale: str = ""
    chat: str = ""

    @property
    def key(self) -> tuple[str, str, str]:
        """What tells it from every other menu."""
        return self.where.value, self.chat, self.locale
