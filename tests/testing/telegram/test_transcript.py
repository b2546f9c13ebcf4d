"""What somebody saw and did, from the server's record."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rosic.testing.telegram.transcript import TranscriptView, transcript

if TYPE_CHECKING:
    from rosic.testing.telegram import FakeTelegram
    from rosic.testing.telegram.transcript import Transcript
    from tests.testing.telegram.asking import Api, Wall


def keyboard(*labels: str) -> dict[str, Any]:
    keys = [{"text": label, "callback_data": label.casefold()} for label in labels]
    return {"inline_keyboard": [keys]}


def seen(server: FakeTelegram, chat: int, reader: int, *, every_form: bool = False) -> Transcript:
    view = TranscriptView(title="Robots", reader=reader, every_form=every_form)
    return transcript(server.messages(chat), server.presses(chat), view)


async def a_menu(api: Api, chat: int) -> int:
    sent = await api.ok("sendMessage", chat_id=chat, text="Which?", reply_markup=keyboard("A", "B"))
    return int(sent["message_id"])


async def changes(api: Api, chat: int, message: int, text: str, *labels: str) -> None:
    markup = {"reply_markup": keyboard(*labels)} if labels else {}
    await api.ok("editMessageText", chat_id=chat, message_id=message, text=text, **markup)


async def test_the_form_that_was_tapped_is_shown_and_the_last_one(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    server.say(ada, ada, "/start a-secret")
    message = await a_menu(api, ada)
    server.tap(ada, ada, message, "B")
    await changes(api, ada, message, "Really?", "Yes", "No")
    await changes(api, ada, message, "Really, really?", "Yes")
    server.tap(ada, ada, message, "Yes")
    await changes(api, ada, message, "Done.")
    shown = seen(server, ada, ada)
    assert shown.lines() == [
        "[START]*",
        "you> /start",
        "bot> Which?",
        "  [A] [B]*",
        "bot> Really, really?",
        "  [Yes]*",
        "bot> Done.",
    ]
    assert (shown.taps, shown.typed, shown.read) == (3, 0, 3)
    assert [(b.edited, b.past) for b in shown.bubbles[1:]] == [
        (False, True),
        (True, True),
        (True, False),
    ]
    assert "bot> Really?" in seen(server, ada, ada, every_form=True).lines()
    assert "a-secret" not in str(shown)


async def test_a_button_that_stays_is_marked_on_the_form_that_was_there_when_it_was_tapped(
    server: FakeTelegram, api: Api, ada: int, wall: Wall
) -> None:
    message = await a_menu(api, ada)
    for number in (1, 2):
        wall.now_s += 1
        if number > 1:
            server.tap(ada, ada, message, "B")
            wall.now_s += 1
        await changes(api, ada, message, f"Form {number}", "A", "B")
    assert seen(server, ada, ada).lines() == [
        "bot> Form 1",
        "  [A] [B]*",
        "bot> Form 2",
        "  [A] [B]",
    ]


async def test_other_peoples_taps_do_not_count_and_everybody_has_a_name_in_a_group(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    ben = server.create_user("Ben")
    room = server.create_chat("supergroup", "Room", members=[ada, ben], bot="administrator")
    asked = server.say(room, ben, "menu")
    sent = await api.ok(
        "sendMessage",
        chat_id=room,
        text="Which?",
        reply_markup=keyboard("A"),
        reply_parameters={"message_id": asked},
    )
    server.tap(ben, room, sent["message_id"], "A")
    server.say(room, ada, "hello")
    shown = seen(server, room, ada)
    assert shown.lines() == ["Ben> menu", "Robot gateway> Which?", "  [A]", "Ada> hello"]
    assert (shown.taps, shown.typed) == (0, 1)
    quote = shown.bubbles[1].answers
    assert quote is not None
    assert (quote.name, quote.text) == ("Ben", "menu")
    assert seen(server, room, ben).taps == 1


async def test_what_was_deleted_is_not_shown_and_a_typed_message_is_counted_once(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    gone = server.say(ada, ada, "oops")
    server.delete(ada, gone)
    said = server.say(ada, ada, "helo")
    server.edit(ada, said, "hello")
    assert await a_menu(api, ada)
    shown = seen(server, ada, ada, every_form=True)
    assert shown.lines() == ["you> helo", "you> hello", "bot> Which?", "  [A] [B]"]
    assert shown.typed == 1
