"""Files in Telegram: pictures as pictures, everything else as it is, and what cannot be sent."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from rosic.authoriser.invite_codes import qr_png
from rosic.core.message import Attachment, Button
from rosic.core.robot.view import Clip, RawFrame
from rosic.errors import MessageGone, MessengerFault
from rosic.messengers.telegram.files import FILE_BYTES
from rosic.rendering.draw import draw
from tests.real.telegram.gateway import Gateway, to

if TYPE_CHECKING:
    from rosic.testing.telegram import FakeTelegram

BACK = Button("Take it back", "/invite back", "n" * 64)
DATA = Attachment("my-data.jsonl", "application/x-ndjson", b'{"kind":"card"}\n')
CODE = Attachment("invitation.png", "image/png", qr_png("https://t.me/rosic_test_bot?start=x"))


def one(server: FakeTelegram, chat: int) -> dict[str, Any]:
    (seen,) = server.messages(chat, by_bot=True)
    return seen


async def test_a_code_is_a_picture_over_its_text_and_buttons(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    asked = server.say(ada, ada, "/invite viewer")
    shown = to(ada, "Scan <b>me</b>.", reply_to=str(asked), buttons=((BACK,),))
    sent = await gateway.messenger.send(replace(shown, attachment=CODE))
    seen = one(server, ada)
    assert (str(seen["message_id"]), seen["text"], seen["reply_to"]) == (
        sent,
        "Scan <b>me</b>.",
        asked,
    )
    assert seen["callback_data"] == ["n" * 64]
    (photo,) = seen["photo"]
    assert server.file(photo["file_id"]) == CODE.content
    await gateway.messenger.edit(sent, to(ada, "Taken back."))
    await gateway.messenger.edit(sent, to(ada, "Taken back."))
    seen = one(server, ada)
    assert (seen["text"], seen["callback_data"]) == ("Taken back.", [])
    with pytest.raises(MessageGone):  # there is no room for it under the picture
        await gateway.messenger.edit(sent, to(ada, "x" * 1_025))


@pytest.mark.parametrize("content", [b"no picture", qr_png("x") + bytes(10_000_000)])
async def test_what_telegram_takes_for_no_picture_goes_as_it_is(
    server: FakeTelegram, gateway: Gateway, ada: int, content: bytes
) -> None:
    attachment = replace(CODE, content=content)
    await gateway.messenger.send(replace(to(ada, "Look."), attachment=attachment))
    held = one(server, ada)["document"]
    assert server.file(held["file_id"]) == content


@pytest.mark.parametrize(("name", "method"), [("jpeg", "photo"), ("gif", "animation")])
async def test_what_was_drawn_is_shown_as_a_picture_or_as_an_animation(
    server: FakeTelegram, gateway: Gateway, ada: int, name: str, method: str
) -> None:
    frame = RawFrame(64, 48, "mono8", 64, bytes(range(64)) * 48)
    drawing = draw(Clip((frame, frame), 0.2) if name == "gif" else frame)
    attachment = Attachment(f"omni.{name}", drawing.media_type, drawing.content)
    await gateway.messenger.send(replace(to(ada, "omni, 0.4 s ago"), attachment=attachment))
    seen = one(server, ada)
    held = seen[method][-1] if method == "photo" else seen[method]
    assert server.file(held["file_id"]) == drawing.content
    assert seen["text"] == "omni, 0.4 s ago"


@pytest.mark.parametrize("sides", [(2_000, 40), (1, 30)])
async def test_a_picture_of_an_odd_shape_goes_as_it_is(
    server: FakeTelegram, gateway: Gateway, ada: int, sides: tuple[int, int]
) -> None:
    width, height = sides
    drawing = draw(RawFrame(width, height, "mono8", width, bytes(width * height)))
    attachment = Attachment("odd.jpg", drawing.media_type, drawing.content)
    await gateway.messenger.send(replace(to(ada, "Look."), attachment=attachment))
    assert one(server, ada)["document"]["file_name"] == "odd.jpg"


async def test_a_file_goes_once_when_its_text_is_long(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    sent = await gateway.messenger.send(replace(to(ada, "y" * 1_025), attachment=DATA))
    file, text = server.messages(ada, by_bot=True)
    assert (file["document"]["file_name"], file["text"]) == (DATA.name, None)
    assert (str(text["message_id"]), text["text"]) == (sent, "y" * 1_025)


async def test_a_file_is_not_sent_twice_when_its_answer_is_lost(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    server.fail("drop_answer", "sendDocument", times=1)
    with pytest.raises(MessengerFault):
        await gateway.messenger.send(replace(to(ada, "Here."), attachment=DATA))
    assert one(server, ada)["text"] == "Here."


async def test_what_is_too_large_is_not_tried(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    large = replace(DATA, content=bytes(FILE_BYTES + 1))
    with pytest.raises(MessengerFault, match="larger than Telegram takes"):
        await gateway.messenger.send(replace(to(ada, "Here."), attachment=large))
    assert server.calls == []
