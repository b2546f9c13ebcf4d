"""What goes out: messages, edits, answers to taps; at the pace that Telegram allows."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from telegram import LinkPreviewOptions, ReplyParameters

from rosic.core.i18n import said
from rosic.core.message import SendPriority
from rosic.errors import ChatGone, ChatNotBegun, MessageGone, MessengerFault
from rosic.messengers.telegram import formatting as texts
from rosic.messengers.telegram.bot_client import CALL_S
from rosic.messengers.telegram.errors import ErrorKind, TelegramError
from rosic.messengers.telegram.files import FILE_S, picture_of, prepared
from rosic.messengers.telegram.formatting import inert, keyboard_of

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from telegram import Bot, InlineKeyboardMarkup

    from rosic.contracts.clock import Clock
    from rosic.core.message import Chat, Inbound, Outbound
    from rosic.messengers.telegram.bot_client import ApiBot, BotClient
    from rosic.messengers.telegram.chats import Chats
    from rosic.messengers.telegram.files import SendableFile
    from rosic.messengers.telegram.rate_limiter import RateLimiter

T = TypeVar("T")

GIVE_UP_S = 60.0
"""After so long a message or an edit is reported as not sent; whoever sends decides what then."""
WAITS_S = (0.5, 1.0, 2.0, 4.0)
TAP_S = 5.0
GONE = ("message to edit not found", "message can't be edited", "message_id_invalid")
"""Telegram's words for a message that was deleted, or is too old to be changed."""
TOO_OLD = "message can't be deleted"
"""Telegram's words for a part of a long text that it lets nobody take away any more."""
HAS_A_FILE = "no text in the message to edit"
"""Telegram's words for a message whose text is the caption of a file."""
NO_TOPIC = ("message thread not found", "topic_closed", "topic_deleted")
"""Telegram's words for a topic in which nothing more can be said: it is said in the group then."""
NOT_BEGUN = ("chat not found", "can't initiate conversation")
"""Telegram's words for the chat of somebody who has never written to this bot."""
NO_RIGHT = "not enough rights"
NOT_THERE = ("message to pin not found", "message to unpin not found", "message_id_invalid")
"""Telegram's words for a message that was deleted; of one to be unpinned, also that it is not."""
NO_PREVIEW = LinkPreviewOptions(is_disabled=True)

log = logging.getLogger("rosic.messengers.telegram")


class BotCall(NamedTuple):
    """One call to a chat.

    Attributes:
        chat: As it was given; the group may have moved since.
        repeatable: Twice is the same as once, so it is tried again even if it may have arrived.
        message: Which one it changes; empty for a new one.
    """

    chat: str
    weight: SendPriority
    repeatable: bool = False
    topic: int | None = None
    message: str = ""


class Outgoing:
    """Speaks for one bot.

    Args:
        line: To Telegram.
        limiter: Says when.
        chats: Where chats are now, and where nothing can be said.
        clock: Waits.
        file_bytes: How large a file may be.
    """

    def __init__(
        self, line: BotClient, limiter: RateLimiter, chats: Chats, clock: Clock, file_bytes: int
    ) -> None:
        self._file_bytes = file_bytes
        self._line = line
        self._limiter = limiter
        self._chats = chats
        self._clock = clock
        self._granted: set[str] = set()

    async def turn(self, chat: Chat, weight: SendPriority) -> None:
        """Wait for a turn in this chat; whatever is said there next takes it.

        Raises:
            MessengerFault: There was none in time.
        """
        where = self._chats.where(chat.id)
        if where not in self._granted and not self._chats.gone(where):
            await self._limiter.turn(where, weight, within_s=GIVE_UP_S)
            self._granted.add(where)

    async def send(self, outbound: Outbound) -> str:
        """Send; a long text goes as several messages, buttons under the last, whose id counts.

        Raises:
            MessengerFault: Not sent, or it cannot be known. Of a long text a part may be there.
        """
        keyboard = keyboard_of(outbound)
        self._chats.offered(outbound)
        call = BotCall(outbound.chat.id, outbound.weight, topic=_topic(outbound))
        behind = self._chats.lost(call.chat, outbound.reply_to)
        reply = None if behind else _reply(outbound.reply_to)
        parts = texts.split(outbound.text)
        sent: list[str] = []
        if outbound.attachment is not None:
            file = prepared(outbound.attachment, self._file_bytes)
            if len(parts) == 1 and texts.units(parts[0]) <= texts.CAPTION_UNITS:
                return await self._send_file(call, file, parts[0], reply, keyboard)
            await self._send_file(call, file, "", reply, None)
        for number, part in enumerate(parts, start=1):
            markup = keyboard if number == len(parts) else None
            sent.append(await self._send_one(call, part, reply, markup))
            reply = None
        self._chats.split(outbound.chat.id, tuple(sent))
        return sent[-1]

    async def edit(self, message: str, outbound: Outbound) -> None:
        """Edit in place.

        Raises:
            MessageGone: It was deleted, or it or a part of it is too old to be changed.
            MessengerFault: Not changed, or it cannot be known; or the text now needs more
                messages than it took when it was sent.
        """
        keyboard = keyboard_of(outbound)
        self._chats.offered(outbound)
        chat = outbound.chat.id
        call = BotCall(chat, outbound.weight, repeatable=True, message=message)
        parts, shown = texts.split(outbound.text), self._chats.parts(chat, message)
        if len(parts) > len(shown):
            raise MessengerFault("The message has become too long to be changed in place.")
        surplus = len(shown) - len(parts)
        for number in shown[:surplus]:
            await self._delete_one(call, _number(number))
        for number, part in zip(shown[surplus:], parts, strict=True):
            markup = keyboard if number == message else None
            await self._edit_one(call, _number(number), part, markup)
        if surplus:
            self._chats.split(chat, shown[surplus:])

    async def put_picture(self, message: str, outbound: Outbound) -> None:
        """Make a message show a picture, as text or picture it was before.

        Raises:
            MessengerFault: Not changed, or it cannot be known; or it is no picture for Telegram.
        """
        keyboard, number = keyboard_of(outbound), _number(message)
        self._chats.offered(outbound)
        media = picture_of(outbound)

        async def act(bot: Bot, chat: int) -> None:
            await bot.edit_message_media(
                media,
                chat,
                number,
                reply_markup=keyboard,
                write_timeout=FILE_S,
                read_timeout=FILE_S,
            )

        call = BotCall(outbound.chat.id, outbound.weight, repeatable=True, message=message)
        await self._change(call, act, within_s=FILE_S)

    async def answer(self, inbound: Inbound, text: str) -> None:
        """End the waiting after a tap. Never raises: a tap that is too old has nobody waiting."""
        if not inbound.tap:
            return
        shown = texts.shorten(text, texts.ANSWER_UNITS) or None
        try:
            await self._line.ask(
                lambda bot: bot.answer_callback_query(inbound.tap, text=shown), within_s=TAP_S
            )
        except MessengerFault as fault:
            log.info("a tap was not answered: %s", fault)

    async def pin(self, chat: str, message: str, *, pinned: bool) -> None:
        """Pin, without a sound, or unpin. What is so already succeeds.

        Raises:
            MessageGone: There is no such message any more.
            MessengerFault: Not done; in a group only an administrator who may pin can do it.
        """
        number = _number(message)

        async def act(bot: Bot, where: int) -> None:
            if pinned:
                await bot.pin_chat_message(where, number, disable_notification=True)
            else:
                await bot.unpin_chat_message(where, message_id=number)

        try:
            call = BotCall(chat, SendPriority.QUESTION, repeatable=True, message=message)
            await self._call(call, act)
        except TelegramError as trouble:
            reason = trouble.reason.lower()
            if trouble.kind is not ErrorKind.REFUSED:
                raise
            if NO_RIGHT in reason:
                raise MessengerFault(may_not_pin()) from None
            if not any(words in reason for words in NOT_THERE):
                raise
            if pinned:
                raise MessageGone(str(trouble)) from None

    # ---- one call each ----

    async def _send_one(
        self,
        call: BotCall,
        text: str,
        reply: ReplyParameters | None,
        markup: InlineKeyboardMarkup | None,
    ) -> str:
        async def act(bot: Bot, chat: int, thread: int | None) -> str:
            message = await bot.send_message(
                chat,
                text,
                entities=inert(text),
                link_preview_options=NO_PREVIEW,
                reply_parameters=reply,
                reply_markup=markup,
                message_thread_id=thread,
            )
            return str(message.message_id)

        return await self._call_in_topic(call, act)

    async def _send_file(
        self,
        call: BotCall,
        file: SendableFile,
        caption: str,
        reply: ReplyParameters | None,
        markup: InlineKeyboardMarkup | None,
    ) -> str:
        async def act(bot: ApiBot, chat: int, thread: int | None) -> str:
            return await file.send(bot, chat, caption, reply, markup, thread)

        return await self._call_in_topic(call, act, within_s=file.within_s)

    async def _edit_one(
        self, call: BotCall, number: int, text: str, markup: InlineKeyboardMarkup | None
    ) -> None:
        async def change_text(bot: Bot, chat: int) -> None:
            await bot.edit_message_text(
                text,
                chat_id=chat,
                message_id=number,
                entities=inert(text),
                link_preview_options=NO_PREVIEW,
                reply_markup=markup,
            )

        async def change_caption(bot: Bot, chat: int) -> None:
            await bot.edit_message_caption(
                chat_id=chat,
                message_id=number,
                caption=text,
                caption_entities=inert(text),
                reply_markup=markup,
            )

        try:
            await self._change(call, change_text)
        except TelegramError as trouble:
            if trouble.kind is not ErrorKind.REFUSED or HAS_A_FILE not in trouble.reason.lower():
                raise
            if texts.units(text) > texts.CAPTION_UNITS:  # it has no room under the file
                raise MessageGone(str(trouble)) from None
            await self._change(call, change_caption)

    async def _change(
        self, call: BotCall, act: Callable[[Bot, int], Awaitable[None]], *, within_s: float = CALL_S
    ) -> None:
        try:
            await self._call(call, act, within_s=within_s)
        except TelegramError as trouble:
            if trouble.kind is not ErrorKind.REFUSED:
                raise
            if any(words in trouble.reason.lower() for words in GONE):
                raise MessageGone(str(trouble)) from None
            if "not modified" not in trouble.reason:
                raise

    async def _delete_one(self, call: BotCall, number: int) -> None:
        async def act(bot: Bot, chat: int) -> None:
            await bot.delete_message(chat, number)

        try:
            await self._call(call, act)
        except TelegramError as trouble:
            if trouble.kind is ErrorKind.REFUSED and TOO_OLD in trouble.reason.lower():
                raise MessageGone(str(trouble)) from None  # what it says now is said anew
            if trouble.kind is not ErrorKind.REFUSED or "not found" not in trouble.reason:
                raise

    async def _call_in_topic(
        self,
        call: BotCall,
        act: Callable[[ApiBot, int, int | None], Awaitable[str]],
        *,
        within_s: float = CALL_S,
    ) -> str:
        """Say it in its topic; in the group itself if the topic is closed or gone."""
        thread = call.topic
        if thread is not None:
            try:
                message = await self._call(call, lambda b, c: act(b, c, thread), within_s=within_s)
                return self._chats.sent(call.chat, message)
            except TelegramError as trouble:
                if not any(words in trouble.reason.lower() for words in NO_TOPIC):
                    raise
        message = await self._call(call, lambda b, c: act(b, c, None), within_s=within_s)
        return self._chats.sent(call.chat, message)

    async def _call(
        self, call: BotCall, act: Callable[[ApiBot, int], Awaitable[T]], *, within_s: float = CALL_S
    ) -> T:
        """Make one call in its turn, again where that cannot do it twice.

        Raises:
            MessageGone: What it would change is in a group that has moved since.
            MessengerFault: It did not succeed in time.
        """
        give_up_ns = self._clock.monotonic_ns() + int(GIVE_UP_S * 1e9)
        failures = 0
        while True:
            left_s = (give_up_ns - self._clock.monotonic_ns()) / 1e9
            chat = self._chats.where(call.chat)
            number = _number(chat)
            if call.message and self._chats.lost(call.chat, call.message):
                raise MessageGone("That message stayed behind when the group moved.")
            if self._chats.gone(chat):
                self._granted.discard(chat)
                raise _gone(begun=self._chats.begun(chat))
            if chat in self._granted:
                self._granted.discard(chat)
                await self._limiter.obey(chat)  # asked for since the turn was given
            else:
                await self._limiter.turn(chat, call.weight, within_s=left_s)
            try:
                with self._limiter.under_way(chat):
                    return await self._line.ask(
                        lambda bot, to=number: act(bot, to),  # type: ignore[misc]
                        within_s=within_s,
                    )
            except TelegramError as trouble:
                failures += 1
                await self._prepare_again(call, chat, trouble, failures)

    async def _prepare_again(
        self, call: BotCall, chat: str, trouble: TelegramError, failures: int
    ) -> None:
        """Do what must be done before the call is made once more.

        Raises:
            TelegramError: It must not, or need not, be made again.
            ChatGone: In this chat no call will succeed; `ChatNotBegun` if none ever did.
        """
        if trouble.kind is ErrorKind.TOO_FAST:
            log.info("asked to wait %g s in one chat", trouble.wait_s)
            self._limiter.hold(chat, trouble.wait_s)
        elif trouble.kind is ErrorKind.MOVED and failures <= len(WAITS_S):
            self._chats.moved(chat, trouble.new_chat)
        elif trouble.kind is ErrorKind.GONE:
            # A person's chat is there for a bot once that person has written to it.
            words = trouble.reason.casefold()
            begun = _number(chat) < 0 or not any(one in words for one in NOT_BEGUN)
            if begun:
                log.info("nobody can be spoken to in one chat any more: %s", trouble.reason)
            self._chats.left(chat, begun=begun)
            raise _gone(begun=begun) from None
        elif _worth_it(call, trouble) and failures <= len(WAITS_S):
            await self._clock.sleep(WAITS_S[failures - 1])
        else:
            raise trouble


def _worth_it(call: BotCall, trouble: TelegramError) -> bool:
    return trouble.kind is ErrorKind.NOT_SENT or (
        trouble.kind is ErrorKind.LOST and call.repeatable
    )


def _gone(*, begun: bool) -> ChatGone:
    if begun:
        return ChatGone("Nobody can be spoken to in that chat any more.")
    return ChatNotBegun("Nobody in that chat has written to me yet, and a bot may not be first.")


def _number(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise MessengerFault("Telegram has no such chat or message. Nothing was sent.") from None


def _topic(outbound: Outbound) -> int | None:
    topic = outbound.chat.topic
    return int(topic) if topic.isdecimal() else None


def _reply(message: str) -> ReplyParameters | None:
    if not message.isdecimal():  # nothing to reply to, or a tap: its id is no message's
        return None
    number = int(message)
    # A tap's id is a number too, but one that no message can have.
    if number >= 2**31:
        return None
    return ReplyParameters(number, allow_sending_without_reply=True)


def may_not_pin() -> str:
    """Say why nothing is pinned here, and who can change it."""
    return said(
        "I may not pin messages here. An admin of this chat can make me one who may; "
        "or pin it yourself."
    )
