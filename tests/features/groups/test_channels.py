"""Channels as windows, where the disk is slower than who puts the bot out of a channel."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any, cast

from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind
from rosic.features.groups.channels import NONE, ChannelDisplays
from rosic.gateway.chat_dashboards import key_of
from tests.pace import pace

CHANNEL = Chat("telegram", "-100", ChatKind.CHANNEL)
MESSENGER: Any = SimpleNamespace(name="telegram")
BY_ADA: Any = SimpleNamespace(private=True, rest="", caller=SimpleNamespace(principal="ada"))


class SlowCards:
    """Live cards with one in a channel; its end is not written before it is let."""

    def __init__(self) -> None:
        self.let = asyncio.Event()
        self.ended = asyncio.Event()
        self.card: Any = SimpleNamespace(
            key=key_of(MESSENGER, CHANNEL), messenger=MESSENGER, chat=CHANNEL, robots=("ant",)
        )

    def in_channels(self) -> tuple[Any, ...]:
        return () if self.card is None else (self.card,)

    def of(self, _messenger: object, _chat: Chat) -> object:
        return self.card

    async def end(self, _card: object) -> None:
        await self.let.wait()
        self.card = None
        self.ended.set()


async def test_a_channel_that_we_were_put_out_of_is_not_shown_while_its_end_is_written() -> None:
    cards = SlowCards()
    rooms: Any = SimpleNamespace(
        profiles={"ant": SimpleNamespace(shown="Ant")},
        organiser=SimpleNamespace(
            rights=SimpleNamespace(holds=lambda *_: True, givers=lambda *_: ()), wall_ns=lambda: 0
        ),
    )
    windows = ChannelDisplays(cast("Any", cards), rooms, cast("Any", None), cast("Any", None))

    async def listed() -> str:
        return (await windows.channel(BY_ADA)).text

    assert "A channel shows Ant" in await listed()
    windows.passed(MESSENGER, ChatEvent(chat=CHANNEL, what=ChatEventKind.REMOVED))
    assert await listed() == NONE
    windows.passed(MESSENGER, ChatEvent(chat=CHANNEL, what=ChatEventKind.ADDED, title="News"))
    assert "News shows Ant" in await listed()
    windows.passed(MESSENGER, ChatEvent(chat=CHANNEL, what=ChatEventKind.REMOVED))
    cards.let.set()
    await asyncio.wait_for(cards.ended.wait(), 60 * pace())
    assert await listed() == NONE
