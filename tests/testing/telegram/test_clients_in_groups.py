"""Captions, topics and scopes of commands, driven by a client library."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from telegram import BotCommandScopeAllPrivateChats as PtbAllPrivateChats
from telegram import BotCommandScopeChat as PtbScopeChat
from telegram import error as ptb_error

from tests.testing.telegram.test_files import png

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rosic.testing.telegram import FakeTelegram
    from tests.testing.telegram.conftest import PtbApplication


@pytest.fixture(autouse=True)
def correct(server: FakeTelegram) -> Iterator[None]:
    """What these libraries send is correct, so nothing may be reported."""
    yield
    assert server.violations == []


async def test_ptb_edits_captions_speaks_in_topics_and_scopes_commands(
    server: FakeTelegram, ptb: PtbApplication, ada: int
) -> None:
    bot = ptb.bot
    lab = server.create_chat("supergroup", "Lab", members=[ada], topics=["Omni"])
    omni = server.topics(lab)["Omni"]
    picture = await bot.send_photo(lab, png(8, 8), caption="a", message_thread_id=omni)
    assert (picture.message_thread_id, picture.is_topic_message) == (omni, True)
    changed = await bot.edit_message_caption(lab, picture.message_id, caption="b")
    assert not isinstance(changed, bool)
    assert changed.caption == "b"
    log = await bot.send_document(lab, b"log", filename="log.txt", message_thread_id=omni)
    assert log.message_thread_id == omni
    with pytest.raises(ptb_error.BadRequest, match="no text in the message"):
        await bot.edit_message_text("x", lab, log.message_id)
    with pytest.raises(ptb_error.BadRequest, match="thread not found"):
        await bot.send_message(lab, "x", message_thread_id=99)
    private, own = PtbAllPrivateChats(), PtbScopeChat(ada)
    await bot.set_my_commands([("stop", "Anhalten")], private, "de")
    await bot.set_my_commands([("invite", "Invite")], own)
    assert [c.description for c in await bot.get_my_commands(private, "de")] == ["Anhalten"]
    assert list(await bot.get_my_commands(private)) == []
    assert await bot.delete_my_commands(own)
    assert list(await bot.get_my_commands(own)) == []
    server.set_member(lab, bot.id, "kicked")
    with pytest.raises(ptb_error.Forbidden, match="kicked"):
        await bot.send_message(lab, "x")
