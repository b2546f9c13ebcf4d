"""Whoever writes to the bot: what they say and tap, what they wait to read, and how often."""

from __future__ import annotations

import asyncio
import time
from typing import TYPE_CHECKING, Any, Final

import msgspec

from rosic.testing.telegram.transcript import (
    ENGLISH,
    START,
    App,
    Transcript,
    TranscriptView,
    transcript,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.testing.telegram.client import Control

BOT: Final = "Lab robots"
SHOWN: Final = 10
CHANGES: Final = ("sent", "edited", "answered", "confirmed")


class ChatReader:
    """Says something in chats, and waits until the bot says what is expected.

    Args:
        control: Of the server.
        within_s: How long is waited for what is expected.
    """

    def __init__(self, control: Control, within_s: float = 60.0) -> None:
        self.control = control
        self.within_s = within_s

    async def say(self, user: int, text: str, chat: int = 0, **unusual: Any) -> int:  # noqa: ANN401
        """Write in somebody's private chat, or in another one; return the message's id."""
        return await self.control.say(chat or user, user, text, **unusual)

    async def ask(
        self,
        user: int,
        text: str,
        expected: str,
        *,
        within_s: float | None = None,
        **more: Any,  # noqa: ANN401
    ) -> dict[str, Any]:
        """Write, and wait for a reply that says what is expected. Return it."""
        message = await self.say(user, text, **more)
        chat = more.get("chat", user)
        return await self.reads(chat, expected, to=message, within_s=within_s)

    async def reads(
        self, chat: int, expected: str, *, to: int | None = None, within_s: float | None = None
    ) -> dict[str, Any]:
        """Wait until the bot shows what is expected in a chat, perhaps in reply to a message.

        Raises:
            AssertionError: Nobody read it in time; says what there is.
        """

        async def look() -> dict[str, Any] | None:
            for message in await self.control.messages(chat, by_bot=True):
                if (to is None or message["reply_to"] == to) and expected in (
                    message["text"] or ""
                ):
                    return message
            return None

        found: dict[str, Any] | None = await self.until(look, within_s)
        if found is None:
            said = [(m["reply_to"], m["text"]) for m in await self.control.messages(chat)]
            raise AssertionError(f"nobody read {expected!r}; there is {said[-SHOWN:]}")
        return found

    async def until(self, look: Callable[[], Any], within_s: float | None = None) -> Any:  # noqa: ANN401
        """Look again after every change at the server, until something is found; None in the end.

        What is looked for may also change by itself, so it is looked for a few times a second.
        """
        end_s = time.monotonic() + (self.within_s if within_s is None else within_s)
        while True:
            seq = await self.control.seq()
            found = look()
            found = await found if asyncio.iscoroutine(found) else found
            if found or time.monotonic() > end_s:
                return found or None
            await self.control.wait(seq, 0.2, CHANGES)

    async def drained(self, within_s: float | None = None) -> None:
        """Wait until the gateway has settled everything that people sent.

        Raises:
            AssertionError: It has not in time.
        """

        async def empty() -> bool:
            return await self.control.pending() == 0

        if not await self.until(empty, within_s):
            raise AssertionError("there are updates that were not settled")


class Newcomer(msgspec.Struct):
    """One person with one phone, who meets the bot for the first time.

    Attributes:
        taps: Telegram's own START among them.
        typed: Messages they wrote themselves.
        words: Of these messages.
        app: Telegram's own words on their phone.
    """

    place: ChatReader
    account: int
    taps: int = 0
    typed: int = 0
    words: int = 0
    app: App = ENGLISH

    async def start(self, code: str, expected: str) -> None:
        """Open the link of an invitation and tap START; an empty code: find the bot by its name."""
        self.taps += 1
        await self.place.say(self.account, f"{START} {code}".rstrip())
        await self.reads(expected)

    async def tap(self, label: str, expected: str) -> None:
        """Tap the newest button that says this, and read what comes of it.

        Raises:
            AssertionError: Nobody showed it, or nobody read what is expected.
        """
        message = await self.place.until(lambda: self._showing(label))
        if message is None:
            raise AssertionError(f"nobody showed {label}: {(await self.saw()).lines()}")
        self.taps += 1
        await self.place.control.tap(self.account, self.account, message, label)
        await self.reads(expected)

    async def type(self, text: str, expected: str) -> None:
        """Write a message, and read what comes of it."""
        self.typed += 1
        self.words += len(text.split())
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
