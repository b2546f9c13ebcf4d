"""Files that are never in memory as a whole: shown on their way, past what the chat waits for."""

from __future__ import annotations

import asyncio
import hashlib
import os
import tracemalloc
from typing import TYPE_CHECKING

import pytest

from rosic.container.files import PART, pieces_of
from rosic.core.records import Fact, Letter
from rosic.errors import ChatGone, MessengerFault
from tests.features.files.test_transfer import asked, held, place, tapped
from tests.features.files.test_upload import send
from tests.features.personal_data.data_gateway import Ward, a_ward
from tests.gateway.place import ADA
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from rosic.core.message import Outbound

LARGE = b"\x89PNG\r\n\x1a\n" + os.urandom(2_500_000)
DIGEST = hashlib.sha256(LARGE).hexdigest()


async def until(ward: Ward, so: Callable[[], bool]) -> None:
    for _ in range(3_000):
        if so():
            return
        await asyncio.sleep(0.005)
        await ward.quiet()
    raise AssertionError([told.outbound.text for told in ward.chat.told])


def files(ward: Ward) -> list[bytes]:
    given = [told.outbound.attachment for told in ward.chat.told]
    return [one.content for one in given if one is not None]


def texts(ward: Ward) -> list[str]:
    return [told.outbound.text for told in ward.chat.told]


def room_for(ward: Ward) -> None:
    for messenger in (ward.chat, ward.gateway._messengers[0]):
        messenger.file_bytes = messenger.fetch_bytes = 10_000_000


async def test_a_large_file_comes_back_beside_the_chat(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        room_for(ward)
        await send(ward, "hall.png", LARGE)
        open_now, go_on = asyncio.Event(), asyncio.Event()
        honest = ward.chat.send

        async def slow(outbound: Outbound) -> str:
            if outbound.attachment is not None:
                open_now.set()
                await go_on.wait()
            return await honest(outbound)

        ward.chat.send = slow  # type: ignore[method-assign]
        ward.chat.say("/files get hall.png", account=ADA, chat=ADA)
        await asyncio.wait_for(open_now.wait(), 60 * pace())
        await until(ward, lambda: "Sending hall.png: 0 % of 2.5 MB." in texts(ward))
        assert "omni" in await asked(ward, "status"), "the chat waited for the file"
        go_on.set()
        await until(ward, lambda: "hall.png is sent." in texts(ward))
        assert files(ward) == [LARGE]
        (said,) = [told.outbound for told in ward.chat.told if told.outbound.attachment]
        assert said.text == f"hall.png, 2.5 MB, SHA-256 {DIGEST}"


async def test_a_damaged_one_is_not_sent(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        room_for(ward)
        await send(ward, "hall.png", LARGE)
        (filed,) = ward.data_context.files.of(ward.id_of(ADA))
        spoilt = Fact(
            kind=PART,
            key=f"{filed.id}.000000",
            body=b"1",
            letter=Letter(filed.owner, os.urandom(262_144)),
        )
        await ward.kept.write(spoilt)
        ward.chat.say("/files get hall.png", account=ADA, chat=ADA)
        await until(ward, lambda: any("does not read as it was kept" in t for t in texts(ward)))
        assert files(ward) == []


@pytest.mark.parametrize("fault", [MessengerFault("The way broke."), ChatGone("Gone.")])
async def test_what_breaks_on_its_way_is_said_once(tmp_path: Path, fault: MessengerFault) -> None:
    async with a_ward(tmp_path) as ward:
        room_for(ward)
        await send(ward, "hall.png", LARGE)
        honest, tries = ward.chat.send, 0

        async def broken(outbound: Outbound) -> str:
            nonlocal tries
            if outbound.attachment is None:
                return await honest(outbound)
            tries += 1
            raise fault

        ward.chat.send = broken  # type: ignore[method-assign]
        ward.chat.say("/files get hall.png", account=ADA, chat=ADA)
        await until(ward, lambda: tries > 0 and not ward.aside._under_way)
        await ward.quiet()
        assert texts(ward).count("The way broke.") == (not isinstance(fault, ChatGone))
        assert tries == 1


async def test_a_content_is_read_a_few_parts_at_a_time(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        room_for(ward)
        await send(ward, "hall.png", LARGE * 3)
        (filed,) = ward.data_context.files.of(ward.id_of(ADA))
        tracemalloc.start()
        try:
            digest = hashlib.sha256()
            async for piece in pieces_of(ward.kept, filed):
                digest.update(piece)
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
        assert digest.digest() == filed.digest
        assert peak < filed.size / 2


async def test_a_large_file_goes_to_a_robot_and_one_comes_back(tmp_path: Path) -> None:
    async with place(tmp_path, max_mb=5) as ward:
        room_for(ward)
        await send(ward, "hall.png", LARGE)
        await asked(ward, "/files send hall.png to omni")
        await tapped(ward, "Put it there")
        await until(ward, lambda: any("lies in the inbox of omni" in t for t in texts(ward)))
        assert any("Handing hall.png to omni: 0 % of 2.5 MB." in t for t in texts(ward))
        assert held(tmp_path) == {"hall.png", "hall.png.sha256"}
        assert (tmp_path / "in" / "hall.png").read_bytes() == LARGE
        (tmp_path / "out" / "way.png").write_bytes(LARGE[::-1])
        ward.chat.say("/files from omni way.png", account=ADA, chat=ADA)
        await until(ward, lambda: any("none of the kinds" in t for t in texts(ward)))
        (tmp_path / "out" / "way.png").write_bytes(LARGE)
        ward.chat.say("/files from omni way.png", account=ADA, chat=ADA)
        await until(ward, lambda: "way.png is sent." in texts(ward))
        assert files(ward) == [LARGE]


async def test_what_changes_while_it_goes_is_not_sent(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        room_for(ward)
        there = tmp_path / "out" / "way.png"
        there.write_bytes(LARGE)
        honest = ward.chat.send

        async def meanwhile(outbound: Outbound) -> str:
            if outbound.attachment is not None:
                there.write_bytes(LARGE[:-1] + bytes([LARGE[-1] ^ 1]))
            return await honest(outbound)

        ward.chat.send = meanwhile  # type: ignore[method-assign]
        ward.chat.say("/files from omni way.png", account=ADA, chat=ADA)
        await until(ward, lambda: any("changed while I read it" in t for t in texts(ward)))
        assert files(ward) == []


async def test_limits_are_said_before_they_are_met(tmp_path: Path) -> None:
    async with place(tmp_path) as ward:
        (tmp_path / "out" / "small.log").write_bytes(b"x\n")
        (tmp_path / "out" / "large.log").write_bytes(b"x" * 1_500_000)
        said = await asked(ward, "/files")
        assert "Here I take files of up to 1.0 MB and send files of up to 1.0 MB." in said
        said = await asked(ward, "/files from omni")
        assert "large.log: 1.5 MB, 0 s ago, too large to send here" in said
        ward.button("small.log")
        with pytest.raises(AssertionError):
            ward.button("large.log")


async def test_only_so_many_are_under_way(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        room_for(ward)
        await send(ward, "hall.png", LARGE)
        never = asyncio.Event()
        honest = ward.chat.send

        async def stuck(outbound: Outbound) -> str:
            if outbound.attachment is not None:
                await never.wait()
            return await honest(outbound)

        ward.chat.send = stuck  # type: ignore[method-assign]
        for _ in range(3):
            ward.chat.say("/files get hall.png", account=ADA, chat=ADA)
        await until(ward, lambda: any("under way already" in t for t in texts(ward)))
        assert len(ward.aside._under_way) == 2
        await ward.aside.end(ward.id_of(ADA))
        assert not ward.aside._under_way
