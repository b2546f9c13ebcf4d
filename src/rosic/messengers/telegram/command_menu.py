"""The menu of commands that Telegram shows while somebody types: by language and by chat."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING

from telegram import (
    BotCommand,
    BotCommandScope,
    BotCommandScopeAllGroupChats,
    BotCommandScopeAllPrivateChats,
    BotCommandScopeChat,
)

from rosic.core.message import MenuScope
from rosic.messengers.telegram.errors import ErrorKind, TelegramError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from telegram import Bot

    from rosic.contracts.clock import Clock
    from rosic.core.message import Menu
    from rosic.messengers.telegram.bot_client import BotClient

AT_MOST = 256
"""Menus, and so calls, that are looked after at once; further ones are left as they are."""
BETWEEN_S = 0.1
TRIES = 3
WAITS_S = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 60.0)
DESCRIPTION = 256

log = logging.getLogger("rosic.messengers.telegram")


class TelegramMenus:
    """Remembers what was set, so that nothing is set twice."""

    def __init__(self, name: str, line: BotClient, clock: Clock) -> None:
        self._name = name
        self._line = line
        self._clock = clock
        self._set: dict[tuple[str, str, str], tuple[tuple[str, str], ...]] = {}
        self._failures = 0

    async def set(self, menus: Sequence[Menu]) -> None:
        """Make these menus look as given, however long Telegram cannot be reached.

        That is logged once. Whatever else does not succeed is, with all after it, for the next
        time.
        """
        self._failures = 0
        for menu in menus:
            known = self._set.get(menu.key)
            if known == menu.commands or (known is None and len(self._set) >= AT_MOST):
                continue
            if not await self._change(menu):
                log.warning("%s: not every menu was set; the next change tries again", self._name)
                return
            self._failures = 0
            self._set[menu.key] = menu.commands
            await self._clock.sleep(BETWEEN_S)

    async def _change(self, menu: Menu) -> bool:
        """Return whether it looks so now, or never will."""
        tries = 0
        while tries < TRIES:
            try:
                await self._line.ask(lambda bot: _call(bot, menu))
            except TelegramError as trouble:
                if trouble.kind in {
                    ErrorKind.REFUSED,
                    ErrorKind.GONE,
                }:  # a chat that nobody has opened yet
                    log.info("%s: a menu was refused: %s", self._name, trouble.reason)
                    return True
                tries += trouble.kind is not ErrorKind.NOT_SENT
                await self._wait_out(trouble)
            else:
                return True
        return False

    async def _wait_out(self, trouble: TelegramError) -> None:
        if not self._failures:
            log.info(
                "%s: the menus are not set yet, I go on trying: %s", self._name, trouble.reason
            )
        wait_s = WAITS_S[min(self._failures, len(WAITS_S) - 1)]
        self._failures += 1
        await self._clock.sleep(max(wait_s, trouble.wait_s))


async def _call(bot: Bot, menu: Menu) -> bool:
    scope, locale = _scope(menu), menu.locale or None
    if not menu.commands:
        return await bot.delete_my_commands(scope, locale)
    commands = [BotCommand(name, text[:DESCRIPTION]) for name, text in menu.commands]
    return await bot.set_my_commands(commands, scope, locale)


def _scope(menu: Menu) -> BotCommandScope:
    if menu.where is MenuScope.CHAT:
        return BotCommandScopeChat(int(menu.chat))
    private = menu.where is MenuScope.PRIVATE
    return BotCommandScopeAllPrivateChats() if private else BotCommandScopeAllGroupChats()
