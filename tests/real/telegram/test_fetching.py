"""Files that people send over Telegram: fetched whole or not at all, and from nowhere else."""

from __future__ import annotations

import os
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from rosic.core.message import ChatKind, GeoPoint, IncomingFile, MessageValidity
from rosic.errors import ConfigurationError, MessengerFault
from rosic.messengers.telegram.files import FETCH_BYTES, GONE
from rosic.testing.telegram import FakeTelegram, Settings
from tests.real.telegram.gateway import Gateway
from tests.testing.telegram.test_files import png

if TYPE_CHECKING:
    from pathlib import Path

    from rosic.testing.telegram.faults import FaultKind

CONTENT = os.urandom(300_000)
MAP = "map of hall 2.zip"


async def sent(
    gateway: Gateway, ada: int, name: str = MAP, content: bytes = CONTENT
) -> IncomingFile:
    gateway.server.send_file(ada, ada, name, content)
    async with gateway.running():
        await gateway.until(lambda: bool(gateway.heard))
    enclosure = gateway.heard[-1].enclosed
    assert enclosure is not None
    return enclosure


async def fetched(gateway: Gateway, enclosure: IncomingFile) -> bytes:
    return b"".join([piece async for piece in gateway.messenger.fetch(enclosure)])


async def yielded(gateway: Gateway, enclosure: IncomingFile) -> int:
    count = 0
    with suppress(MessengerFault):
        async for piece in gateway.messenger.fetch(enclosure):
            count += len(piece)
    return count


async def fault(gateway: Gateway, enclosure: IncomingFile) -> str:
    with pytest.raises(MessengerFault) as found:
        await fetched(gateway, enclosure)
    return str(found.value)


def downloads(server: FakeTelegram) -> list[dict[str, Any]]:
    return server.world.journal.since(0, ("download",))


async def test_a_document_comes_with_what_is_said_of_it(gateway: Gateway, ada: int) -> None:
    enclosure = await sent(gateway, ada)
    assert (enclosure.name, enclosure.size) == (MAP, len(CONTENT))
    assert await fetched(gateway, enclosure) == CONTENT
    assert gateway.heard[-1].text == ""


async def test_a_photo_comes_without_a_name(gateway: Gateway, ada: int) -> None:
    content = png(32, 24)
    enclosure = await sent(gateway, ada, "x.png", content)
    assert (enclosure.name, enclosure.media_type) == ("", "image/jpeg")
    assert await fetched(gateway, enclosure) == content


async def test_what_is_written_beneath_comes_as_its_text(gateway: Gateway, ada: int) -> None:
    document = {"file_id": "x", "file_size": 3, "file_name": "a.txt"}
    gateway.server.say(ada, ada, "", extra={"caption": "stop", "document": document})
    gateway.server.say(ada, ada, "", extra={"caption": "stop", "document": {"file_id": ["x"]}})
    async with gateway.running():
        await gateway.until(lambda: len(gateway.heard) == 2)
    assert gateway.texts == ["stop", "stop"], "a malformed file hid what was written beneath"
    assert [one.enclosed is None for one in gateway.heard] == [False, True]


async def test_a_forwarded_file_says_so(gateway: Gateway, ada: int) -> None:
    gateway.server.send_file(ada, ada, MAP, CONTENT, forward_origin="somebody")
    async with gateway.running():
        await gateway.until(lambda: bool(gateway.heard))
    assert gateway.heard[0].standing is MessageValidity.FORWARDED
    assert gateway.heard[0].chat.kind is ChatKind.PRIVATE


async def test_a_location_is_a_place_unless_it_moves(gateway: Gateway, ada: int) -> None:
    here = {"latitude": 47.07, "longitude": 15}
    for extra in (
        {"location": here},
        {"location": here | {"live_period": 60}},
        {"location": here, "venue": {"title": "x"}},
        {"location": {"latitude": "x"}},
        {"location": {"latitude": 91, "longitude": 0}},
    ):
        gateway.server.say(ada, ada, "", extra=extra)
    gateway.server.say(ada, ada, "last")
    async with gateway.running():
        await gateway.until(lambda: "last" in gateway.texts)
    assert [one.place for one in gateway.heard if one.place] == [GeoPoint(47.07, 15.0)]
    assert all(one.text == "" for one in gateway.heard if one.place)


async def test_too_large_a_file_is_refused_before_anything_is_asked(gateway: Gateway) -> None:
    enclosure = IncomingFile(id="document-1", name="all.zip", size=25_000_000)
    assert gateway.messenger.fetch_bytes == FETCH_BYTES
    sentence = await fault(gateway, enclosure)
    assert all(word in sentence for word in ("25.0 MB", "20 MB", "local_mode"))
    assert gateway.server.calls == []


async def test_a_file_of_unknown_size_is_measured_by_telegram(gateway: Gateway, ada: int) -> None:
    enclosure = replace(await sent(gateway, ada), size=0)
    assert await fetched(gateway, enclosure) == CONTENT


@pytest.mark.parametrize("content", [CONTENT + b"x", CONTENT[:-1], CONTENT * 8, b""])
async def test_a_file_that_is_not_what_was_said_is_worth_nothing(
    server: FakeTelegram, gateway: Gateway, ada: int, content: bytes
) -> None:
    enclosure = await sent(gateway, ada)
    server.swap_file(enclosure.id, content)
    assert "not as long" in await fault(gateway, enclosure)
    assert await yielded(gateway, enclosure) <= len(CONTENT)


@pytest.mark.parametrize("kind", ["reset", "bad_gateway"])
async def test_a_broken_download_is_no_file(
    server: FakeTelegram, gateway: Gateway, ada: int, kind: FaultKind
) -> None:
    enclosure = await sent(gateway, ada)
    server.fail(kind, "download", times=1)
    assert "Send it again" in await fault(gateway, enclosure)
    assert await fetched(gateway, enclosure) == CONTENT


async def test_a_link_that_has_ended_is_asked_for_anew(
    server: FakeTelegram, gateway: Gateway, ada: int
) -> None:
    enclosure = await sent(gateway, ada)
    assert await fetched(gateway, enclosure) == CONTENT
    server.advance(7_200)
    assert await fetched(gateway, enclosure) == CONTENT


@pytest.mark.parametrize("name", ["x/../../y", "", "a b", "../bot", "x\0", "x" * 300])
async def test_no_id_reaches_another_address(gateway: Gateway, name: str) -> None:
    await fault(gateway, IncomingFile(id=name, size=3))
    assert gateway.server.calls == []


@pytest.mark.parametrize("path", ["/etc/passwd", "../getMe", "documents/../../x", "a\0b", ""])
async def test_no_path_of_a_server_is_followed_out(
    server: FakeTelegram, gateway: Gateway, ada: int, path: str
) -> None:
    enclosure = await sent(gateway, ada)
    server.world.state.files[enclosure.id].path = path
    assert await fault(gateway, enclosure) == GONE  # and nothing of what a network said
    assert downloads(server) == []


# ---- a Bot API server of one's own ----


async def local(folder: Path, trusted: Path) -> Gateway:
    settings = Settings(local_folder=str(folder), max_download_bytes=2_000_000_000)
    server = FakeTelegram(limits=None, settings=settings)
    await server.start()
    return Gateway(server, local_mode=True, local_folder=str(trusted))


async def test_a_local_server_leaves_files_on_the_disk(tmp_path: Path) -> None:
    gateway = await local(tmp_path, tmp_path)
    ada = gateway.server.create_user("Ada")
    enclosure = await sent(gateway, ada)
    assert gateway.messenger.fetch_bytes == 2_000_000_000
    assert await fetched(gateway, enclosure) == CONTENT
    assert downloads(gateway.server) == []
    await gateway.server.stop()


@pytest.mark.parametrize("trap", ["elsewhere", "link", "folder link", "pipe", "gone", "dots"])
async def test_nothing_outside_its_folder_is_read(tmp_path: Path, trap: str) -> None:
    trusted, other = tmp_path / "bot", tmp_path / "other"
    trusted.mkdir()
    other.mkdir()
    (other / "secret").write_bytes(CONTENT)
    gateway = await local(trusted, trusted)
    server = gateway.server
    ada = server.create_user("Ada")
    enclosure = await sent(gateway, ada)
    held = server.world.state.files[enclosure.id]
    # The path is what the server says; what lies there is made here.
    server.world.settings = Settings(local_folder="", max_download_bytes=2_000_000_000)
    held.path = str(trusted / "file")
    if trap == "elsewhere":
        held.path = str(other / "secret")
    elif trap == "link":
        (trusted / "file").symlink_to(other / "secret")
    elif trap == "folder link":
        (trusted / "below").symlink_to(other)
        held.path = str(trusted / "below" / "secret")
    elif trap == "pipe":
        os.mkfifo(trusted / "file")
    elif trap == "dots":
        held.path = f"{trusted}/../other/secret"
    assert "may not read" in await fault(gateway, enclosure)
    await server.stop()


@pytest.mark.parametrize(
    "given",
    [
        {"local_mode": True},
        {"local_mode": True, "local_folder": "here"},
        {"local_mode": True, "local_folder": "/"},
        {"local_mode": True, "local_folder": "/x/../etc"},
        {"local_folder": "/x"},
        {"local_mode": "yes", "local_folder": "/x"},
        {"local_mode": True, "local_folder": "/x", "api_base": "https://api.telegram.org"},
    ],
)
async def test_a_local_server_is_configured_wholly(
    server: FakeTelegram, given: dict[str, Any]
) -> None:
    with pytest.raises(ConfigurationError):
        Gateway(server, **given)
