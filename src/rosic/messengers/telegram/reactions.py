"""What is done to messages without a word: an emoji beside one, or taking one away."""

from __future__ import annotations

from typing import TYPE_CHECKING

from telegram import ReactionTypeEmoji

from rosic.core.identity import Address
from rosic.errors import MessageGone, MessengerFault
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.messengers.telegram.incoming import PLATFORM

if TYPE_CHECKING:
    from rosic.messengers.telegram.bot_client import BotClient
    from rosic.messengers.telegram.chats import Chats
    from rosic.messengers.telegram.rate_limiter import RateLimiter

GESTURE_S = 5.0
GONE = ("message to delete not found", "message_id_invalid")
"""Telegram's words for a message that was deleted already."""


class Reactions:
    """Makes them for one bot, each with one call.

    Telegram's limits on messages are not asked; only where Telegram has asked to wait, they wait.
    """

    def __init__(self, line: BotClient, chats: Chats, limiter: RateLimiter) -> None:
        self._limiter = limiter
        self._line = line
        self._chats = chats

    async def react(self, chat: str, message: str, emoji: str) -> None:
        """Put an emoji beside a message.

        Raises:
            MessengerFault: It is not there, or it cannot be known.
        """
        where, number = self._numbers(chat, message)
        await self._limiter.obey(str(where))
        await self._line.ask(
            lambda bot: bot.set_message_reaction(where, number, [ReactionTypeEmoji(emoji)]),
            within_s=GESTURE_S,
        )

    async def retract(self, chat: str, message: str) -> None:
        """Take a message out of a chat. One that is not there any more is out of it.

        Raises:
            MessageGone: It can never be done: it is too old, or not ours to take away.
            MessengerFault: Not done, or it cannot be known; it may succeed later.
        """
        for part in self._chats.parts(chat, message):
            where, number = self._numbers(chat, part)
            await self._limiter.obey(str(where))
            try:
                await self._line.ask(
                    lambda bot, w=where, n=number: bot.delete_message(w, n),  # type: ignore[misc]
                    within_s=GESTURE_S,
                )
            except TelegramError as trouble:
                if any(words in trouble.reason.lower() for words in GONE):
                    continue
                if trouble.kind in {ErrorKind.REFUSED, ErrorKind.GONE}:
                    raise MessageGone(str(trouble)) from None
                raise

    async def admins(self, chat: str) -> tuple[Address, ...]:
        """Return the accounts of those who look after a chat of many, anonymous ones included.

        Raises:
            MessengerFault: Telegram does not say, or not now.
        """
        where = self._chats.where(chat)
        found = await self._line.ask(
            lambda bot: bot.get_chat_administrators(where), within_s=GESTURE_S
        )
        return tuple(Address(PLATFORM, str(one.user.id)) for one in found)

    def _numbers(self, chat: str, message: str) -> tuple[int, int]:
        if self._chats.lost(chat, message):
            raise MessageGone("That message stayed behind when the group moved.")
        where = self._chats.where(chat)
        try:
            return int(where), int(message)
        except ValueError:
            raise MessengerFault("Telegram has no such message. Nothing was done.") from None
