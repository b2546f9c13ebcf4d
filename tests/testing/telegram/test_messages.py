"""Sending, editing, deleting: https://core.telegram.org/bots/api#updating-messages."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from rosic.testing.telegram import ControlError, FakeTelegram

if TYPE_CHECKING:
    from tests.testing.telegram.asking import Api

KEYBOARD = {"inline_keyboard": [[{"text": "Go", "callback_data": "go"}]]}


async def test_what_is_sent_is_what_the_person_sees(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    said = server.say(ada, ada, "hello")
    sent = await api.ok(
        "sendMessage",
        chat_id=ada,
        text="  hello back ",
        reply_parameters={"message_id": said},
        reply_markup=KEYBOARD,
    )
    assert sent["text"] == "hello back"
    assert sent["reply_to_message"]["text"] == "hello"
    assert sent["from"]["is_bot"]
    seen = server.message(ada, sent["message_id"])
    assert (seen["text"], seen["callback_data"], seen["reply_to"]) == ("hello back", ["go"], said)


@pytest.mark.parametrize(
    ("parameters", "refusal"),
    [
        ({"text": ""}, "400 Bad Request: message text is empty"),
        ({"text": " \n "}, "400 Bad Request: message text is empty"),
        ({}, "400 Bad Request: message text is empty"),
        ({"text": "x" * 4097}, "400 Bad Request: message is too long"),
        ({"text": "\U0001f916" * 2049}, "400 Bad Request: message is too long"),
        ({"text": "x", "chat_id": 12}, "400 Bad Request: chat not found"),
        ({"text": "x", "chat_id": "@nobody"}, "400 Bad Request: chat not found"),
        ({"text": "x", "chat_id": ""}, "400 Bad Request: chat_id is empty"),
        (
            {"text": "x", "reply_parameters": {"message_id": 99}},
            "400 Bad Request: message to be replied not found",
        ),
        (
            {"text": "x", "reply_markup": "{"},
            "400 Bad Request: can't parse reply keyboard markup JSON object",
        ),
        ({"text": "x", "message_thread_id": 5}, "400 Bad Request: message thread not found"),
        ({"text": "x", "parse_mode": "Markdown"}, "400 Bad Request: unsupported parse_mode"),
    ],
)
async def test_what_cannot_be_sent(
    server: FakeTelegram, api: Api, ada: int, parameters: dict[str, object], refusal: str
) -> None:
    assert await api.refusal("sendMessage", **{"chat_id": ada, **parameters}) == refusal
    assert server.messages(ada) == []


async def test_the_longest_text_counts_utf16_after_parsing(api: Api, ada: int) -> None:
    await api.ok("sendMessage", chat_id=ada, text="x" * 4096)
    await api.ok("sendMessage", chat_id=ada, text="\U0001f916" * 2048)
    await api.ok("sendMessage", chat_id=ada, text=f"<b>{'x' * 4096}</b>", parse_mode="HTML")


async def test_lone_surrogates_are_no_text(api: Api, ada: int) -> None:
    body = b'{"chat_id": %d, "text": "\\ud800"}' % ada
    headers = {"Content-Type": "application/json"}
    async with api.session.post(api.url("sendMessage"), data=body, headers=headers) as response:
        assert response.status == 400


async def test_a_reply_may_be_sent_without_its_message(api: Api, ada: int) -> None:
    reply = {"message_id": 99, "allow_sending_without_reply": True}
    sent = await api.ok("sendMessage", chat_id=ada, text="x", reply_parameters=reply)
    assert "reply_to_message" not in sent


async def test_a_person_must_have_started_the_bot(server: FakeTelegram, api: Api) -> None:
    eve = server.create_user("Eve", started=False)
    assert await api.refusal("sendMessage", chat_id=eve, text="x") == (
        "400 Bad Request: chat not found"
    )
    server.create_chat("group", "Lab", members=[eve])
    assert await api.refusal("sendMessage", chat_id=eve, text="x") == (
        "403 Forbidden: bot can't initiate conversation with a user"
    )
    server.say(eve, eve, "/start")
    await api.ok("sendMessage", chat_id=eve, text="x")
    server.block(eve)
    assert await api.refusal("sendMessage", chat_id=eve, text="x") == (
        "403 Forbidden: bot was blocked by the user"
    )
    with pytest.raises(ControlError):
        server.say(eve, eve, "hello?")
    server.block(eve, blocked=False)
    await api.ok("sendMessage", chat_id=eve, text="x")


async def test_a_bot_cannot_write_to_bots(server: FakeTelegram, api: Api) -> None:
    other = server.create_user("Other", is_bot=True)
    assert await api.refusal("sendMessage", chat_id=other, text="x") == (
        "403 Forbidden: bot can't send messages to bots"
    )


async def test_ids_alone_name_no_message(server: FakeTelegram, api: Api, ada: int) -> None:
    lab = server.create_chat("supergroup", "Lab", members=[ada])
    first = await api.ok("sendMessage", chat_id=ada, text="x")
    own = await api.ok("sendMessage", chat_id=lab, text="x")
    second = await api.ok("sendMessage", chat_id=ada, text="x")
    assert second["message_id"] == first["message_id"] + 1
    # The first message of the group says that the bot was added.
    assert own["message_id"] <= 2


# ---- editing ----


async def test_an_edit_keeps_the_history(server: FakeTelegram, api: Api, ada: int) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="one", reply_markup=KEYBOARD)
    number = sent["message_id"]
    server.advance(5)
    edited = await api.ok("editMessageText", chat_id=ada, message_id=number, text="two")
    assert edited["edit_date"] == sent["date"] + 5
    assert "reply_markup" not in edited, "an edit without a keyboard takes it away"
    seen = server.message(ada, number)
    assert [version["text"] for version in seen["versions"]] == ["one", "two"]
    first, second = (version["received_s"] for version in seen["versions"])
    assert second - first == 5
    assert await api.ok("getUpdates") == [], "bots do not hear of their own messages"


async def test_an_edit_must_change_something(api: Api, ada: int) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="one", reply_markup=KEYBOARD)
    same = {"chat_id": ada, "message_id": sent["message_id"]}
    refusal = (
        "400 Bad Request: message is not modified: specified new message content and reply markup "
        "are exactly the same as a current content and reply markup of the message"
    )
    assert (
        await api.refusal("editMessageText", **same, text=" one", reply_markup=KEYBOARD) == refusal
    )
    assert await api.refusal("editMessageReplyMarkup", **same, reply_markup=KEYBOARD) == refusal
    await api.ok("editMessageReplyMarkup", **same)
    assert await api.refusal("editMessageReplyMarkup", **same) == refusal


async def test_what_cannot_be_edited(server: FakeTelegram, api: Api, ada: int) -> None:
    said = server.say(ada, ada, "mine")

    async def refusal(**parameters: object) -> str:
        return await api.refusal("editMessageText", chat_id=ada, text="x", **parameters)

    assert await refusal(message_id=said) == "400 Bad Request: message can't be edited"
    assert await refusal(message_id=99) == "400 Bad Request: message to edit not found"
    assert await refusal() == "400 Bad Request: message identifier is not specified"
    sent = await api.ok("sendMessage", chat_id=ada, text="one")
    assert await api.refusal(
        "editMessageText", chat_id=ada, message_id=sent["message_id"], text=""
    ) == ("400 Bad Request: message text is empty")
    reply_keyboard = {"keyboard": [[{"text": "x"}]]}
    assert await refusal(message_id=sent["message_id"], reply_markup=reply_keyboard) == (
        "400 Bad Request: inline keyboard expected"
    )
    sent = await api.ok("sendMessage", chat_id=ada, text="one", reply_markup=reply_keyboard)
    assert await refusal(message_id=sent["message_id"]) == (
        "400 Bad Request: message can't be edited"
    )


async def test_deleting(server: FakeTelegram, api: Api, ada: int) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="one")
    which = {"chat_id": ada, "message_id": sent["message_id"]}
    await api.ok("deleteMessage", **which)
    assert server.message(ada, sent["message_id"])["deleted"]
    assert await api.refusal("deleteMessage", **which) == (
        "400 Bad Request: message to delete not found"
    )
    assert await api.refusal("editMessageText", **which, text="x") == (
        "400 Bad Request: message to edit not found"
    )


async def test_deleting_ends_after_two_days_whoever_asks(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    lab = server.create_chat("supergroup", "Lab", members=[ada], bot="administrator")
    sent = await api.ok("sendMessage", chat_id=ada, text="one")
    old = [
        {"chat_id": ada, "message_id": sent["message_id"]},
        {"chat_id": ada, "message_id": server.say(ada, ada, "a code")},
        {"chat_id": lab, "message_id": server.say(lab, ada, "a code")},
    ]
    server.advance(48 * 3600 - 5)
    fresh = {"chat_id": ada, "message_id": server.say(ada, ada, "a code")}
    server.advance(6)
    for which in old:
        assert await api.refusal("deleteMessage", **which) == (
            "400 Bad Request: message can't be deleted for everyone"
        )
    await api.ok("deleteMessage", **fresh)


async def test_other_peoples_messages_are_deleted_by_who_has_the_right(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    bot = server.world.bot.id
    lab = server.create_chat("supergroup", "Lab", members=[ada])
    which = {"chat_id": lab, "message_id": server.say(lab, ada, "x")}
    refusal = "400 Bad Request: message can't be deleted"
    assert await api.refusal("deleteMessage", **which) == refusal
    server.set_member(lab, bot, "administrator", without=["can_delete_messages"])
    assert await api.refusal("deleteMessage", **which) == refusal
    server.set_member(lab, bot, "administrator")
    await api.ok("deleteMessage", **which)


async def test_in_a_channel_its_own_posts_need_less_than_others(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    bot = server.world.bot.id
    news = server.create_chat("channel", "News", members=[ada], bot="administrator")
    posts = {"chat_id": news, "message_id": server.say(news, None, "x")}
    own = {
        "chat_id": news,
        "message_id": (await api.ok("sendMessage", chat_id=news, text="y"))["message_id"],
    }
    assert server.message(news, own["message_id"])["by_bot"]
    server.set_member(news, bot, "administrator", without=["can_delete_messages"])
    assert (
        await api.refusal("deleteMessage", **posts) == "400 Bad Request: message can't be deleted"
    )
    await api.ok("deleteMessage", **own)


# ---- keyboards ----


@pytest.mark.parametrize(
    ("button", "refusal"),
    [
        ({"text": "x", "callback_data": "d" * 65}, "BUTTON_DATA_INVALID"),
        ({"text": "x", "callback_data": "é" * 33}, "BUTTON_DATA_INVALID"),
        ({"text": "x", "callback_data": ""}, "BUTTON_DATA_INVALID"),
        ({"text": "x", "callback_data": 7}, "BUTTON_DATA_INVALID"),
        (
            {"text": "x"},
            "can't parse inline keyboard button: Text buttons are unallowed in the inline keyboard",
        ),
        (
            {"callback_data": "x"},
            "can't parse inline keyboard button: Can't find field \"text\"",
        ),
        ({"text": " ", "callback_data": "x"}, "BUTTON_TEXT_INVALID"),
        ({"text": "x", "callback_data": "x", "url": "https://x.org"}, "BUTTON_TYPE_INVALID"),
        ({"text": "x", "calback_data": "x"}, None),
        (
            {"text": "x", "url": "javascript:x"},
            "inline keyboard button URL 'javascript:x' is invalid: Wrong HTTP URL",
        ),
    ],
)
async def test_buttons_that_are_none(
    api: Api, ada: int, button: dict[str, object], refusal: str | None
) -> None:
    markup = {"inline_keyboard": [[button]]}
    answer = await api.refusal("sendMessage", chat_id=ada, text="?", reply_markup=markup)
    assert refusal is None or answer == f"400 Bad Request: {refusal}"


@pytest.mark.parametrize(
    "markup",
    [
        {"inline_keyboard": {}},
        {"inline_keyboard": [{}]},
        {"inline_keyboard": [["x"]]},
        {"inline_keyboard": [[{"text": "x", "callback_data": "x"}] * 101]},
        {"inlinekeyboard": []},
        {"inline_keyboard": [], "selective": True},
    ],
)
async def test_keyboards_that_are_none(api: Api, ada: int, markup: object) -> None:
    answer = await api.refusal("sendMessage", chat_id=ada, text="?", reply_markup=markup)
    assert answer.startswith("400 Bad Request: ")


async def test_64_bytes_fit_a_button(server: FakeTelegram, api: Api, ada: int) -> None:
    markup = {"inline_keyboard": [[{"text": "x", "callback_data": "d" * 64}]]}
    await api.ok("sendMessage", chat_id=ada, text="?", reply_markup=markup)
    assert server.messages(ada)[-1]["callback_data"] == ["d" * 64]


# ---- presses ----


async def test_a_press_and_its_answer(server: FakeTelegram, api: Api, ada: int) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="?", reply_markup=KEYBOARD)
    pressed = server.tap(ada, ada, sent["message_id"], "Go")
    (update,) = await api.ok("getUpdates")
    query = update["callback_query"]
    assert (query["id"], query["data"]) == (pressed, "go")
    assert query["from"]["id"] == ada
    assert query["message"]["message_id"] == sent["message_id"]
    assert query["chat_instance"]
    assert "date" not in query
    await api.ok("answerCallbackQuery", callback_query_id=pressed, text="done", show_alert=True)
    (answer,) = server.press(pressed)["answers"]
    assert (answer["text"], answer["show_alert"]) == ("done", True)


async def test_late_and_invented_answers(server: FakeTelegram, api: Api, ada: int) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="?", reply_markup=KEYBOARD)
    pressed = server.tap(ada, ada, sent["message_id"], "go")
    refusal = (
        "400 Bad Request: query is too old and response timeout expired or query ID is invalid"
    )
    assert await api.refusal("answerCallbackQuery", callback_query_id="1") == refusal
    long = {"callback_query_id": pressed, "text": "x" * 201}
    assert await api.refusal("answerCallbackQuery", **long) == "400 Bad Request: MESSAGE_TOO_LONG"
    server.advance(16)
    assert await api.refusal("answerCallbackQuery", callback_query_id=pressed) == refusal


async def test_only_a_button_that_is_there_can_be_pressed(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="?", reply_markup=KEYBOARD)
    number = sent["message_id"]
    with pytest.raises(ControlError, match="no button 'Come'"):
        server.tap(ada, ada, number, "Come")
    with pytest.raises(ControlError, match="not in chat"):
        server.tap(server.create_user("Bob"), ada, number, "Go")
    await api.ok("editMessageText", chat_id=ada, message_id=number, text="!")
    with pytest.raises(ControlError, match="no button"):
        server.tap(ada, ada, number, "Go")
    server.tap(ada, ada, number, "Go", stale=True)
    server.tap(ada, ada, number, "anything at all", forged=True)
    await api.ok("deleteMessage", chat_id=ada, message_id=number)
    server.tap(ada, ada, number, "Go", stale=True)
    updates = await api.ok("getUpdates")
    assert [update["callback_query"]["data"] for update in updates] == [
        "go",
        "anything at all",
        "go",
    ]
    assert updates[-1]["callback_query"]["message"]["date"] == 0, "an inaccessible message"
