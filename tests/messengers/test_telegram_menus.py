"""Menus of Telegram while it cannot be reached: one line in the log, and tried until set."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING, cast

from rosic.core.message import Menu, MenuScope
from rosic.messengers.telegram.command_menu import WAITS_S, TelegramMenus
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.testing.clock import ManualClock

if TYPE_CHECKING:
    import pytest

    from rosic.messengers.telegram.bot_client import BotClient

MENUS = [Menu(MenuScope.PRIVATE, (("stop", "Stop"),), locale) for locale in ("", "de", "fr", "vi")]


class Broken:
    """A line over which nothing goes until it is mended."""

    def __init__(self, kind: ErrorKind) -> None:
        self.kind: ErrorKind | None = kind
        self.asked = 0

    async def ask(self, _act: object) -> None:
        self.asked += 1
        if self.kind is not None:
            raise TelegramError("It did not go.", self.kind, "NetworkError: no way")


def _menus(line: Broken, clock: ManualClock) -> TelegramMenus:
    return TelegramMenus("bot", cast("BotClient", line), clock)


async def test_while_nobody_can_be_reached_it_is_said_once_and_asked_ever_more_rarely(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO, "rosic.messengers.telegram")
    clock, line = ManualClock(), Broken(ErrorKind.NOT_SENT)
    setting = asyncio.create_task(_menus(line, clock).set(MENUS))
    await clock.advance(600.0)
    assert not setting.done()
    assert len(caplog.messages) == 1
    assert "the menus are not set yet, I go on trying: NetworkError: no way" in caplog.messages[0]
    assert line.asked <= len(WAITS_S) + 600.0 / WAITS_S[-1]
    before, line.kind = line.asked, None
    await clock.advance(WAITS_S[-1] + 5.0)
    assert setting.done()
    assert line.asked == before + len(MENUS)


async def test_what_does_not_succeed_otherwise_ends_the_row_until_the_next_time(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.INFO, "rosic.messengers.telegram")
    clock, line = ManualClock(), Broken(ErrorKind.LOST)
    menus = _menus(line, clock)
    setting = asyncio.create_task(menus.set(MENUS))
    await clock.advance(60.0)
    assert setting.done()
    assert line.asked == 3
    assert len(caplog.messages) == 2, "one when it began, one when it gave up"
    line.kind = None
    again = asyncio.create_task(menus.set(MENUS))
    await clock.advance(60.0)
    assert again.done()
    assert line.asked == 3 + len(MENUS)
