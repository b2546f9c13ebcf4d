"""Channels as windows, where the disk is slower than who puts the bot out of a channel."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace
from typing import Any, cast

from rosic.core.identity import Address
from rosic.core.message import Chat, ChatEvent, ChatEventKind, ChatKind
from rosic.features.groups.channels import NONE, QUESTIONS, STRANGE_AT_MOST, ChannelDisplays
from rosic.gateway.chat_dashboards import key_of
from rosic.testing.clock import ManualClock
from tests.gateway.place import ADA, BO, Place
from tests.pace import pace

CHANNEL = Chat("telegram", "-100", ChatKind.CHANNEL)
MESSENGER: Any = SimpleNamespace(name="telegram")
BY_ADA: Any = SimpleNamespace(
    private=True,
    rest="",
    caller=SimpleNamespace(principal="ada"),
    messenger=MESSENGER,
    inbound=SimpleNamespace(chat=Chat("telegram", "1"), under=""),
)


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
        authoriser=SimpleNamespace(directory=SimpleNamespace(at=lambda _: None)),
        organiser=SimpleNamespace(
            rights=SimpleNamespace(holds=lambda *_: True, givers=lambda *_: ()), wall_ns=lambda: 0
        ),
    )
    nobody = cast("Any", None)
    windows = ChannelDisplays(cast("Any", cards), rooms, nobody, nobody, ManualClock())

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


# ---- who is asked ----


async def _put(place: Place, number: int, who: str) -> list[tuple[str, str, bool]]:
    """Put the bot into a channel; return who was told what, and whether by an edit."""
    before = place.chat._told_ever
    event = ChatEvent(
        chat=Chat("memory", f"c{number}", ChatKind.CHANNEL),
        what=ChatEventKind.ADDED,
        who=Address("memory", who),
        title=f"News {number}",
    )
    place.chat.passed(event)
    await place.quiet()
    told = list(place.chat.told)[len(place.chat.told) - (place.chat._told_ever - before) :]
    return [(one.outbound.chat.id, one.outbound.text, one.edited) for one in told]


async def test_a_stranger_who_puts_us_into_channels_asks_nobody_anything() -> None:
    async with Place().open() as place:
        assert len(await _put(place, 0, ADA)) == 1
        buttons = place.gateway.rooms.authoriser.buttons
        kept = len(buttons._bound)
        for who in ("99", BO):  # nor does somebody known here who may open no window
            for number in range(1, 3 * STRANGE_AT_MOST):
                assert await _put(place, number, who) == []
        assert len(buttons._bound) == kept
        listed = await place.say("/channel", chat=ADA)
        assert "News 0 shows no robot. Ada put me there." in listed
        assert listed.count("Bo put me there") == STRANGE_AT_MOST
        label, command = next(
            (one.label, one.command) for row in place.last()[1].buttons for one in row
        )
        assert (label, command.split()[0]) == ("Show something in News 0", "/channel")
        assert "Ada put me into the channel News 0." in await place.say(command, chat=ADA)


async def test_whoever_may_open_it_is_asked_once_at_a_time_and_reads_who_put_it_there() -> None:
    async with Place().open() as place:
        ((where, text, edited),) = await _put(place, 1, ADA)
        assert (where, edited) == (ADA, False)
        assert text.startswith("Ada put me into the channel News 1. It shows nothing yet.")
        ((where, text, edited),) = await _put(place, 2, ADA)
        assert (where, edited) == (ADA, True)
        assert "the channel News 2" in text
        asked = sum([len(await _put(place, number, ADA)) for number in range(3, 40)])
        assert asked == QUESTIONS.burst - 2
