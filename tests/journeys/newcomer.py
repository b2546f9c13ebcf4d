"""Somebody who meets the bot for the first time: what they tap and type, counted."""

from __future__ import annotations

import msgspec

from rosic.testing.telegram.transcript import (
    ENGLISH,
    START,
    App,
    Transcript,
    TranscriptView,
    transcript,
)
from tests.journeys.lab import Lab

BOT = "Lab robots"


class Newcomer(msgspec.Struct):
    """One person with one phone.

    Attributes:
        taps: Telegram's own START among them.
        typed: Messages they wrote themselves.
        app: Telegram's own words on their phone.
    """

    place: Lab
    account: int
    taps: int = 0
    typed: int = 0
    app: App = ENGLISH

    async def start(self, code: str, expected: str) -> None:
        """Open the link of an invitation and tap START; an empty code: find the bot by its name."""
        self.taps += 1
        await self.place.say(self.account, f"{START} {code}".rstrip())
        await self.reads(expected)

    async def tap(self, label: str, expected: str) -> None:
        """Tap the newest button that says this, and read what comes of it."""
        message = await self.place.until(lambda: self._showing(label))
        assert message is not None, f"nobody showed {label}: {(await self.saw()).lines()}"
        self.taps += 1
        await self.place.control.tap(self.account, self.account, message, label)
        await self.reads(expected)

    async def type(self, text: str, expected: str) -> None:
        """Write a message, and read what comes of it."""
        self.typed += 1
        await self.place.say(self.account, text)
        await self.reads(expected)

    async def reads(self, expected: str) -> None:
        """Wait until the chat says what is expected."""
        await self.place.reads(self.account, expected)

    async def _showing(self, label: str) -> int | None:
        for message in reversed(await self.place.control.messages(self.account, by_bot=True)):
            if any(label == button["text"] for row in message["buttons"] for button in row):
                return int(message["message_id"])
        return None

    async def saw(self) -> Transcript:
        """Return the whole conversation."""
        control, chat = self.place.control, self.account
        view = TranscriptView(title=BOT, reader=chat, below="bot", app=self.app)
        return transcript(await control.messages(chat), await control.presses(chat), view)
