# ruff: noqa: PLC0415 - aiogram takes seconds to load, and every worker imports every test
"""Two client libraries drive the server unmodified: their parsers catch its mistakes."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from datetime import timedelta
from typing import TYPE_CHECKING, Any

import pytest
from telegram import Bot as PtbBot
from telegram import InlineKeyboardButton as PtbButton
from telegram import InlineKeyboardMarkup as PtbMarkup
from telegram import Update
from telegram import error as ptb_error
from telegram.ext import (
    CallbackQueryHandler,
    CommandHandler,
    MessageHandler,
    filters,
)

from rosic.testing.telegram.updates import KINDS
from tests.testing.telegram.test_files import png

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Iterator

    from aiogram import Bot, Router
    from aiogram.types import CallbackQuery, Message

    from rosic.testing.telegram import FakeTelegram
    from tests.testing.telegram.conftest import PtbApplication


@pytest.fixture(autouse=True)
def correct(server: FakeTelegram) -> Iterator[None]:
    """What these libraries send is correct, so nothing may be reported."""
    yield
    assert server.violations == []


@asynccontextmanager
async def polling(application: PtbApplication) -> AsyncIterator[None]:
    assert application.updater is not None
    await application.start()
    await application.updater.start_polling(poll_interval=0, timeout=5)
    try:
        yield
    finally:
        await application.updater.stop()
        await application.stop()


@asynccontextmanager
async def dispatching(bot: Bot, router: Router) -> AsyncIterator[None]:
    from aiogram import Dispatcher

    dispatcher = Dispatcher()
    dispatcher.include_router(router)
    task = asyncio.create_task(
        dispatcher.start_polling(bot, handle_signals=False, polling_timeout=5)
    )
    try:
        yield
    finally:
        await dispatcher.stop_polling()
        await task


async def next_of(server: FakeTelegram, after: int, kind: str) -> dict[str, Any]:
    changes = await server.wait(after, 10, [kind])
    assert changes, f"no {kind} in time; violations: {server.violations}"
    return changes[0]


# ---- python-telegram-bot ----


async def test_ptb_converses(server: FakeTelegram, ptb: PtbApplication, ada: int) -> None:
    async def echo(update: Update, _: object) -> None:
        assert update.message is not None
        keyboard = PtbMarkup([[PtbButton("Go", callback_data="go")]])
        await update.message.reply_text(
            f"You said {update.message.text}", reply_markup=keyboard, do_quote=True
        )

    async def stop(update: Update, _: object) -> None:
        assert update.message is not None
        await update.message.reply_text("Stopped.")

    async def press(update: Update, _: object) -> None:
        assert update.callback_query is not None
        await update.callback_query.answer("Going.")
        await update.callback_query.edit_message_text("Went.")

    ptb.add_handler(CommandHandler("stop", stop))
    ptb.add_handler(MessageHandler(filters.TEXT, echo))
    ptb.add_handler(CallbackQueryHandler(press))
    async with polling(ptb):
        seen = server.seq
        said = server.say(ada, ada, "hello")
        sent = await next_of(server, seen, "sent")
        assert server.message(ada, sent["message_id"])["reply_to"] == said
        pressed = server.tap(ada, ada, sent["message_id"], "Go")
        await next_of(server, seen, "edited")
        assert server.press(pressed)["answers"][0]["text"] == "Going."
        versions = server.message(ada, sent["message_id"])["versions"]
        assert [version["text"] for version in versions] == ["You said hello", "Went."]
        seen = server.seq
        server.say(ada, ada, "/stop")
        sent = await next_of(server, seen, "sent")
        assert server.message(ada, sent["message_id"])["text"] == "Stopped."
    assert server.pending() == 0


async def test_ptb_understands_the_errors(
    server: FakeTelegram, ptb: PtbApplication, ada: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PTB_TIMEDELTA", "1")  # or it warns
    server.fail("too_many_requests", "sendMessage", retry_after_s=3)
    with pytest.raises(ptb_error.RetryAfter) as waiting:
        await ptb.bot.send_message(ada, "x")
    assert waiting.value.retry_after == timedelta(seconds=3)
    server.advance(3)
    message = await ptb.bot.send_message(ada, "x")
    with pytest.raises(ptb_error.BadRequest, match="not modified"):
        await message.edit_text("x")
    with pytest.raises(ptb_error.BadRequest, match="Chat not found"):
        await ptb.bot.send_message(5, "x")
    server.block(ada)
    with pytest.raises(ptb_error.Forbidden, match="blocked by the user"):
        await ptb.bot.send_message(ada, "x")
    server.block(ada, blocked=False)
    group = server.create_chat("group", "Lab", members=[ada])
    new = server.migrate(group)
    with pytest.raises(ptb_error.ChatMigrated) as migrated:
        await ptb.bot.send_message(group, "x")
    assert migrated.value.new_chat_id == new
    for kind in ("bad_gateway", "truncated", "reset", "drop_answer"):
        server.fail(kind, "getMe")
        with pytest.raises(ptb_error.TelegramError):
            await ptb.bot.get_me()


async def test_ptb_is_told_of_another_poller(server: FakeTelegram, ptb: PtbApplication) -> None:
    first = asyncio.create_task(ptb.bot.get_updates(timeout=50))
    await server.wait(server.seq, kinds=["call"])
    async with PtbBot(server.token, server.api_base, server.file_base) as thief:
        second = asyncio.create_task(thief.get_updates(timeout=1))
        with pytest.raises(ptb_error.Conflict, match="other getUpdates request"):
            await first
        assert await second == ()
    await ptb.bot.set_webhook("https://example.org")
    with pytest.raises(ptb_error.Conflict, match="webhook is active"):
        await ptb.bot.get_updates()
    assert (await ptb.bot.get_webhook_info()).url == "https://example.org"
    await ptb.bot.delete_webhook()


async def test_ptb_sets_commands_names_and_files(
    server: FakeTelegram, ptb: PtbApplication, ada: int
) -> None:
    bot = ptb.bot
    await bot.set_my_commands([("stop", "Stop everything")])
    assert [command.command for command in await bot.get_my_commands()] == ["stop"]
    await bot.set_my_description("Robots")
    assert (await bot.get_my_description()).description == "Robots"
    sent = await bot.send_document(ada, b"log", filename="log.txt", caption="The log")
    assert sent.document is not None
    file = await sent.document.get_file()
    assert await file.download_as_bytearray() == b"log"
    photo = await bot.send_photo(ada, png(8, 8))
    assert photo.photo[-1].width == 8
    assert await bot.set_message_reaction(ada, sent.message_id, "👍")
    assert await bot.pin_chat_message(ada, sent.message_id)
    chat = await bot.get_chat(ada)
    assert chat.pinned_message is not None
    assert await bot.unpin_chat_message(ada)
    assert await bot.send_chat_action(ada, "typing")
    lab = server.create_chat("supergroup", "Lab", members=[ada], bot="administrator")
    administrators = await bot.get_chat_administrators(lab)
    assert {member.user.id for member in administrators} == {ada, server.world.bot.id}
    assert (await bot.get_chat_member(lab, ada)).status == "creator"
    assert await bot.delete_message(ada, sent.message_id)
    assert await bot.leave_chat(lab)


async def test_ptb_parses_everything_that_people_do(
    server: FakeTelegram, ptb: PtbApplication, ada: int
) -> None:
    everything(server, ada)
    updates = await ptb.bot.get_updates(allowed_updates=Update.ALL_TYPES)
    assert len(updates) == server.pending()
    assert all(len(update.to_dict()) == 2 for update in updates)


def everything(server: FakeTelegram, ada: int) -> None:
    """Leave one update of each kind in the queue."""
    server.world.queue.allow(list(Update.ALL_TYPES))
    bob = server.create_user("Bob")
    lab = server.create_chat("supergroup", "Lab", members=[ada], bot="administrator")
    news = server.create_chat("channel", "News", members=[ada], bot="administrator")
    old = server.create_chat("group", "Old", members=[ada])
    server.link(news, lab)
    number = server.say(ada, ada, "hello /stop @bob https://x.org", reply_to=1)
    server.edit(ada, number, "hello again")
    server.say(ada, ada, "forwarded", forward_origin=bob)
    server.say(ada, ada, "forwarded", forward_origin="Somebody")
    server.say(ada, ada, "inline", via_bot=True)
    server.say(lab, ada, "anonymous", sender_chat=lab)
    server.say(lab, ada, "as channel", sender_chat=news)
    post = server.say(news, None, "a post")
    server.edit(news, post, "a better post")
    server.set_member(lab, bob, "member")
    server.set_member(lab, bob, "restricted")
    server.set_member(lab, bob, "kicked")
    server.react(lab, ada, server.say(lab, ada, "x"), "👍")
    server.migrate(old)
    server.block(ada)
    server.block(ada, blocked=False)
    server.send_file(ada, ada, "log.txt", b"log")
    server.send_file(ada, ada, "x.png", png(4, 4))


# ---- aiogram ----


async def test_aiogram_converses(server: FakeTelegram, aiogram_bot: Bot, ada: int) -> None:
    from aiogram import F, Router
    from aiogram.filters import Command
    from aiogram.types import InlineKeyboardButton, InlineKeyboardMarkup, Message

    router = Router()

    @router.message(Command("stop"))
    async def stop(message: Message) -> None:
        await message.answer("Stopped.")

    @router.message(F.text)
    async def echo(message: Message) -> None:
        button = InlineKeyboardButton(text="Go", callback_data="go")
        keyboard = InlineKeyboardMarkup(inline_keyboard=[[button]])
        await message.reply(f"You said {message.text}", reply_markup=keyboard)

    @router.callback_query(F.data == "go")
    async def press(query: CallbackQuery) -> None:
        assert isinstance(query.message, Message)
        await query.answer("Going.", show_alert=True)
        await query.message.edit_text("Went.")

    async with dispatching(aiogram_bot, router):
        seen = server.seq
        said = server.say(ada, ada, "hello")
        sent = await next_of(server, seen, "sent")
        assert server.message(ada, sent["message_id"])["reply_to"] == said
        pressed = server.tap(ada, ada, sent["message_id"], "go")
        await next_of(server, seen, "edited")
        assert server.press(pressed)["answers"][0]["show_alert"]
        assert server.message(ada, sent["message_id"])["text"] == "Went."
        seen = server.seq
        server.say(ada, ada, "/stop@rosic_test_bot")
        sent = await next_of(server, seen, "sent")
        assert server.message(ada, sent["message_id"])["text"] == "Stopped."


async def test_aiogram_understands_the_errors(
    server: FakeTelegram, aiogram_bot: Bot, ada: int
) -> None:
    from aiogram import exceptions as aiogram_error

    server.fail("too_many_requests", "sendMessage", retry_after_s=3)
    with pytest.raises(aiogram_error.TelegramRetryAfter) as waiting:
        await aiogram_bot.send_message(ada, "x")
    assert waiting.value.retry_after == 3
    server.advance(3)
    message = await aiogram_bot.send_message(ada, "x")
    with pytest.raises(aiogram_error.TelegramBadRequest, match="not modified"):
        await message.edit_text("x")
    server.block(ada)
    with pytest.raises(aiogram_error.TelegramForbiddenError, match="blocked by the user"):
        await aiogram_bot.send_message(ada, "x")
    server.block(ada, blocked=False)
    group = server.create_chat("group", "Lab", members=[ada])
    new = server.migrate(group)
    with pytest.raises(aiogram_error.TelegramMigrateToChat) as migrated:
        await aiogram_bot.send_message(group, "x")
    assert migrated.value.migrate_to_chat_id == new
    server.fail("error", "getMe", code=500)
    with pytest.raises(aiogram_error.TelegramServerError):
        await aiogram_bot.get_me()


async def test_aiogram_is_told_of_another_poller(server: FakeTelegram, aiogram_bot: Bot) -> None:
    from aiogram import exceptions as aiogram_error

    first = asyncio.create_task(aiogram_bot.get_updates(timeout=50))
    await server.wait(server.seq, kinds=["call"])
    second = asyncio.create_task(aiogram_bot.get_updates(timeout=1))
    with pytest.raises(aiogram_error.TelegramConflictError, match="other getUpdates request"):
        await first
    assert await second == []


async def test_aiogram_sets_commands_and_files(
    server: FakeTelegram, aiogram_bot: Bot, ada: int
) -> None:
    from aiogram.types import BotCommand, BufferedInputFile, ReactionTypeEmoji

    bot = aiogram_bot
    await bot.set_my_commands([BotCommand(command="stop", description="Stop everything")])
    assert [command.command for command in await bot.get_my_commands()] == ["stop"]
    await bot.set_my_name("Robots")
    assert (await bot.get_my_name()).name == "Robots"
    sent = await bot.send_document(ada, BufferedInputFile(b"log", "log.txt"), caption="The log")
    assert sent.document is not None
    file = await bot.download(sent.document)
    assert file is not None
    assert file.read() == b"log"
    photo = await bot.send_photo(ada, BufferedInputFile(png(8, 8), "x.png"))
    assert photo.photo is not None
    assert photo.photo[-1].width == 8
    assert await bot.set_message_reaction(
        ada, sent.message_id, reaction=[ReactionTypeEmoji(emoji="👍")]
    )
    assert await bot.pin_chat_message(ada, sent.message_id)
    assert (await bot.get_chat(ada)).pinned_message is not None
    lab = server.create_chat("supergroup", "Lab", members=[ada], bot="administrator")
    assert len(await bot.get_chat_administrators(lab)) == 2
    assert (await bot.get_chat_member(lab, ada)).status == "creator"
    info = await bot.get_webhook_info()
    assert info.url == ""


def test_every_update_type_of_both_libraries_is_known() -> None:
    from aiogram.enums import UpdateType

    assert {*Update.ALL_TYPES, *(kind.value for kind in UpdateType)} == set(KINDS)


async def test_aiogram_parses_everything_that_people_do(
    server: FakeTelegram, aiogram_bot: Bot, ada: int
) -> None:
    everything(server, ada)
    updates = await aiogram_bot.get_updates()
    assert len(updates) == server.pending()
    assert all(update.event_type for update in updates)


async def test_aiogram_edits_captions_speaks_in_topics_and_scopes_commands(
    server: FakeTelegram, aiogram_bot: Bot, ada: int
) -> None:
    from aiogram.exceptions import TelegramBadRequest, TelegramForbiddenError
    from aiogram.types import BotCommand, BotCommandScopeChat, BufferedInputFile, Message

    bot = aiogram_bot
    lab = server.create_chat("supergroup", "Lab", members=[ada], topics=["Omni"])
    omni = server.topics(lab)["Omni"]
    image = BufferedInputFile(png(8, 8), "x.png")
    picture = await bot.send_photo(lab, image, caption="a", message_thread_id=omni)
    assert (picture.message_thread_id, picture.is_topic_message) == (omni, True)
    changed = await bot.edit_message_caption(
        chat_id=lab, message_id=picture.message_id, caption="b"
    )
    assert isinstance(changed, Message)
    assert changed.caption == "b"
    with pytest.raises(TelegramBadRequest, match="thread not found"):
        await bot.send_message(lab, "x", message_thread_id=99)
    own = BotCommandScopeChat(chat_id=ada)
    await bot.set_my_commands([BotCommand(command="invite", description="Invite")], own, "de")
    assert [c.command for c in await bot.get_my_commands(own, "de")] == ["invite"]
    assert await bot.delete_my_commands(own, "de")
    assert await bot.get_my_commands(own, "de") == []
    server.set_member(lab, bot.id, "kicked")
    with pytest.raises(TelegramForbiddenError, match="kicked"):
        await bot.send_message(lab, "x")
