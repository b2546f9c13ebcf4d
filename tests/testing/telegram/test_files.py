"""Photos, documents, downloads: https://core.telegram.org/bots/api#sending-files."""

from __future__ import annotations

import json
import struct
import zlib
from typing import Any

import aiohttp

from rosic.testing.telegram import FakeTelegram, Settings
from tests.testing.telegram.asking import Api


def png(width: int, height: int) -> bytes:
    def chunk(kind: bytes, data: bytes) -> bytes:
        checksum = struct.pack(">I", zlib.crc32(kind + data))
        return struct.pack(">I", len(data)) + kind + data + checksum

    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    pixels = zlib.compress(b"\0" * (width + 1) * height)
    start = b"\x89PNG\r\n\x1a\n"
    return start + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


async def upload(
    api: Api, method: str, field: str, content: bytes, **fields: str
) -> dict[str, Any]:
    form = aiohttp.FormData(fields)
    form.add_field(field, content, filename=fields.get("name", f"{field}.bin"))
    fields.pop("name", None)
    async with api.session.post(api.url(method), data=form) as response:
        answer: dict[str, Any] = await response.json()
        return answer


async def test_a_photo_goes_out_and_comes_back(server: FakeTelegram, api: Api, ada: int) -> None:
    content = png(32, 24)
    answer = await upload(
        api,
        "sendPhoto",
        "photo",
        content,
        chat_id=str(ada),
        caption="<b>now</b>",
        parse_mode="HTML",
    )
    (size,) = answer["result"]["photo"]
    assert (size["width"], size["height"]) == (32, 24)
    assert answer["result"]["caption_entities"][0]["type"] == "bold"
    held = await api.ok("getFile", file_id=size["file_id"])
    async with api.session.get(f"{server.file_base}{server.token}/{held['file_path']}") as file:
        assert await file.read() == content
    assert server.file(size["file_id"]) == content
    again = await api.ok("sendPhoto", chat_id=ada, photo=size["file_id"])
    assert again["photo"][0]["file_id"] == size["file_id"]
    assert server.violations == []


async def test_a_caption_can_be_edited_and_a_missing_text_cannot(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    answer = await upload(api, "sendDocument", "document", b"log", chat_id=str(ada))
    number = answer["result"]["message_id"]
    assert answer["result"]["document"]["file_name"] == "document.bin"
    await api.ok("editMessageCaption", chat_id=ada, message_id=number, caption="later")
    assert server.message(ada, number)["text"] == "later"
    assert await api.refusal("editMessageText", chat_id=ada, message_id=number, text="x") == (
        "400 Bad Request: there is no text in the message to edit"
    )
    assert await api.refusal(
        "editMessageCaption", chat_id=ada, message_id=number, caption="x" * 1025
    ) == ("400 Bad Request: message caption is too long")


async def test_what_is_no_photo(api: Api, ada: int) -> None:
    for content, reason in (
        (b"text", "IMAGE_PROCESS_FAILED"),
        (b"", "file must be non-empty"),
        (png(1, 30), "PHOTO_INVALID_DIMENSIONS"),
    ):
        answer = await upload(api, "sendPhoto", "photo", content, chat_id=str(ada))
        assert answer["description"] == f"Bad Request: {reason}"
    assert await api.refusal("sendPhoto", chat_id=ada, photo="nothing") == (
        "400 Bad Request: wrong file identifier/HTTP URL specified"
    )
    assert await api.refusal("sendPhoto", chat_id=ada) == (
        "400 Bad Request: there is no photo in the request"
    )


async def test_no_url_is_ever_fetched(server: FakeTelegram, api: Api, ada: int) -> None:
    await api.refusal("sendPhoto", chat_id=ada, photo="https://example.org/x.png")
    assert "not supported" in server.violations[0]["reason"]


async def test_sizes() -> None:
    settings = Settings(max_upload_bytes=100, max_download_bytes=50)
    async with FakeTelegram(settings=settings) as server, Api(server) as api:
        ada = server.create_user("Ada")
        answer = await upload(api, "sendDocument", "document", b"x" * 101, chat_id=str(ada))
        assert (answer["error_code"], answer["description"]) == (413, "Request Entity Too Large")
        answer = await upload(api, "sendDocument", "document", b"x" * 100, chat_id=str(ada))
        file_id = answer["result"]["document"]["file_id"]
        assert await api.refusal("getFile", file_id=file_id) == "400 Bad Request: file is too big"
        assert await api.refusal("getFile", file_id="x") == "400 Bad Request: invalid file_id"


async def test_no_path_survives_in_a_name(server: FakeTelegram, api: Api, ada: int) -> None:
    server.send_file(ada, ada, "../../etc/passwd", b"x")
    (update,) = await api.ok("getUpdates")
    assert update["message"]["document"]["file_name"] == "passwd"


async def test_an_unknown_part_is_written_down(server: FakeTelegram, api: Api, ada: int) -> None:
    form = aiohttp.FormData({"chat_id": str(ada), "document": "attach://log"})
    form.add_field("log", b"x", filename="log.txt")
    form.add_field("stray", b"x", filename="stray.txt")
    async with api.session.post(api.url("sendDocument"), data=form) as response:
        assert response.status == 200
    assert [violation["reason"] for violation in server.violations] == ["unknown file 'stray'"]


async def test_people_send_photos_and_documents(server: FakeTelegram, api: Api, ada: int) -> None:
    server.send_file(ada, ada, "x.png", png(4, 4))
    (update,) = await api.ok("getUpdates")
    assert update["message"]["photo"][0]["width"] == 4


async def test_a_picture_comes_into_a_message_that_was_text(
    server: FakeTelegram, api: Api, ada: int
) -> None:
    sent = await api.ok("sendMessage", chat_id=ada, text="a card")
    which = {"chat_id": ada, "message_id": sent["message_id"]}
    fields = {name: str(value) for name, value in which.items()}
    fields["media"] = json.dumps({"type": "photo", "media": "attach://one", "caption": "beneath"})
    answer = await upload(api, "editMessageMedia", "one", png(32, 24), **fields)
    assert (answer["result"]["caption"], "text" in answer["result"]) == ("beneath", False)
    (size,) = answer["result"]["photo"]
    again = {"type": "photo", "media": size["file_id"], "caption": "beneath"}
    assert await api.refusal("editMessageMedia", **which, media=again) == (
        "400 Bad Request: message is not modified: specified new message content and reply markup"
        " are exactly the same as a current content and reply markup of the message"
    )
    assert await api.refusal("editMessageText", **which, text="x") == (
        "400 Bad Request: there is no text in the message to edit"
    )
    assert server.violations == []
    for wrong in (
        {"type": "photo", "media": "https://example.org/x.png"},
        {"type": "photo", "media": size["file_id"], "wrong": 1},
        {"type": "sticker", "media": size["file_id"]},
    ):
        await api.raw("editMessageMedia", **which, media=wrong)
    assert len(server.violations) == 3
    theirs = {"chat_id": ada, "message_id": server.say(ada, ada, "x")}
    assert await api.refusal("editMessageMedia", **theirs, media=again) == (
        "400 Bad Request: message can't be edited"
    )
