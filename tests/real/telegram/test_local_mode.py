"""A Bot API server of one's own: large files go to it piece by piece, whole or not at all."""

from __future__ import annotations

import hashlib
import re
import tracemalloc
from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.core.message import Attachment, Button, StreamedContent
from rosic.errors import MessengerFault, RecordUnavailable
from rosic.messengers.telegram.files import FILE_BYTES, LOCAL_BYTES
from rosic.testing.telegram import FakeTelegram, Settings
from tests.real.telegram.gateway import Gateway, to

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, AsyncIterator
    from pathlib import Path

    from rosic.testing.telegram.faults import FaultKind

PIECE = bytes(range(256)) * 1_024
COUNT = FILE_BYTES // len(PIECE) + 10
"""So many of them are more than Telegram's own servers take."""


def large(*, count: int = COUNT, promised: int = COUNT) -> Attachment:
    async def read() -> AsyncGenerator[bytes]:
        for _ in range(count):
            yield PIECE
        if count != promised:
            raise RecordUnavailable("The file does not read as it was kept.")

    return Attachment(
        "hall 2.zip", "application/zip", pieces=StreamedContent(promised * len(PIECE), read)
    )


@pytest.fixture
async def local(tmp_path: Path) -> AsyncIterator[FakeTelegram]:
    settings = Settings(
        local_folder=str(tmp_path), max_upload_bytes=LOCAL_BYTES, max_download_bytes=LOCAL_BYTES
    )
    async with FakeTelegram(limits=None, settings=settings) as running:
        yield running
    assert running.violations == []


@pytest.fixture
def near(local: FakeTelegram, tmp_path: Path) -> Gateway:
    return Gateway(local, local_mode=True, local_folder=str(tmp_path))


async def test_more_than_telegram_takes_arrives_and_is_never_whole_in_memory(
    local: FakeTelegram, near: Gateway
) -> None:
    ada, file = local.create_user("Ada"), large()
    said = replace(
        to(ada, "All of it.", buttons=((Button("Yes", "x", "nonce"),),)), attachment=file
    )
    sent = await near.messenger.send(said)
    (seen,) = local.messages(ada, by_bot=True)
    assert (str(seen["message_id"]), seen["text"]) == (sent, "All of it.")
    assert seen["document"]["file_name"] == "hall 2.zip"
    assert seen["callback_data"] == ["nonce"]
    held = local.file(seen["document"]["file_id"])
    expected = hashlib.sha256()
    for _ in range(COUNT):
        expected.update(PIECE)
    assert hashlib.sha256(held).digest() == expected.digest()


async def test_pieces_are_asked_for_as_they_go(local: FakeTelegram, near: Gateway) -> None:
    """Whoever takes the pieces holds a few of them: the way out is what makes the next one come."""
    from rosic.messengers.telegram.upload_stream import UploadStream  # noqa: PLC0415 - of this test alone

    file = large(count=4_000, promised=4_000)
    upload = UploadStream({"chat_id": 1, "caption": None}, "document", file)
    tracemalloc.start()
    try:
        total = 0
        async for piece in upload.body():
            total += len(piece)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert total == int(upload.headers["Content-Length"]) > 1_000_000_000
    assert peak < 1_000_000
    assert near.messenger.file_bytes == LOCAL_BYTES
    assert local.calls == []


async def test_what_is_not_as_promised_is_not_sent(local: FakeTelegram, near: Gateway) -> None:
    ada = local.create_user("Ada")
    spoilt = replace(to(ada, "x"), attachment=large(count=3, promised=4))
    with pytest.raises(MessengerFault, match="does not read as it was kept"):
        await near.messenger.send(spoilt)
    assert local.messages(ada, by_bot=True) == []
    await near.messenger.send(to(ada, "still here"))
    assert [one["text"] for one in local.messages(ada, by_bot=True)] == ["still here"]


@pytest.mark.parametrize("kind", ["too_many_requests", "bad_gateway", "reset"])
async def test_a_large_file_goes_once_whatever_the_way_does(
    local: FakeTelegram, near: Gateway, kind: FaultKind
) -> None:
    ada = local.create_user("Ada")
    local.fail(kind, "sendDocument", times=1, retry_after_s=1)
    said = replace(to(ada, "x"), attachment=large(count=3, promised=3))
    try:
        await near.messenger.send(said)
    except MessengerFault:
        assert kind != "too_many_requests"
        assert local.messages(ada, by_bot=True) == []
    else:
        assert len(local.messages(ada, by_bot=True)) == 1


async def test_a_name_stays_inside_its_quotes(local: FakeTelegram, near: Gateway) -> None:
    ada = local.create_user("Ada")
    faulty = replace(large(count=1, promised=1), name='a"; name="chat_id')
    await near.messenger.send(replace(to(ada, "x"), attachment=faulty))
    (seen,) = local.messages(ada, by_bot=True)
    assert re.fullmatch(r"a(%22|\").*", seen["document"]["file_name"])


async def test_without_one_the_limit_is_telegrams(gateway: Gateway, ada: int) -> None:
    assert gateway.messenger.file_bytes == FILE_BYTES
    with pytest.raises(MessengerFault, match="larger than Telegram takes"):
        await gateway.messenger.send(replace(to(ada, "x"), attachment=large()))
    assert gateway.server.calls == []
