"""A photo or a document becomes a file in the person's container, and nothing else happens."""

from __future__ import annotations

import asyncio
import hashlib
import io
import os
import zipfile
from typing import TYPE_CHECKING, Any

import pytest
from msgspec.structs import replace

from rosic.container.files import PART, PART_BYTES, FileQuota, FileStore
from rosic.core.message import Button, ChatKind, MessageValidity
from rosic.errors import NotUnderstood, TooManyRequests
from rosic.gateway.unverified_messages import MAY_LOOK
from rosic.testing.clock import ManualClock
from tests.features.personal_data.data_gateway import Ward, a_ward
from tests.gateway.place import ADA, BO, STRANGER
from tests.pace import pace

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from pathlib import Path

    from rosic.core.message import IncomingFile

MAP = b"\x89PNG\r\n\x1a\n" + os.urandom(600_000)
NOTE = b"speed: 0.2\n"
NOT_OWN = [s for s in MessageValidity if s.value not in {"fresh", "unverified"}]


async def send(ward: Ward, name: str = "map.png", content: bytes = MAP, **how: Any) -> str:  # noqa: ANN401
    """Send a file; return what was told because of it, newest last."""
    before = len(ward.chat.told)
    how.setdefault("chat", how.setdefault("account", ADA))
    ward.chat.enclose(name, content, **how)
    await come(ward)
    return "\n".join(told.outbound.text for told in list(ward.chat.told)[before:])


async def come(ward: Ward) -> None:
    """Wait until every file has come, and was told."""
    await ward.quiet()
    async with asyncio.timeout(60 * pace()):
        while ward.receiving._coming:  # noqa: ASYNC110 - the disk takes real time
            await asyncio.sleep(0.002)
    await ward.quiet()


async def parts(ward: Ward) -> int:
    return len(await ward.kept.facts(PART, "", 1_000))


async def test_a_file_comes_and_is_given_back(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        said = await send(ward, "../../map of hall 2.png")
        assert "map of hall 2.png (png, 600 KB) is kept for you" in said
        assert "Nothing was done with it" in said
        assert hashlib.sha256(MAP).hexdigest() in said
        assert "map of hall 2.png: png, 600 KB" in await ward.said("files")
        back = await ward.ask("files", "get Map of Hall 2.png")
        assert back.attachment is not None
        assert (back.attachment.content, back.attachment.media_type) == (MAP, "image/png")
        assert ward.acted() == 0
        (decided,) = [one for one in await ward.kept.decisions(10) if one.act == "file"]
        assert (decided.by, decided.digest) == (ward.id_of(ADA), hashlib.sha256(MAP).digest())
    async with a_ward(tmp_path) as ward:  # after a restart
        assert (await ward.ask("files", "get map of hall 2.png")).attachment == back.attachment
        assert await ward.said("files", "delete map of hall 2.png") == (
            "map of hall 2.png is deleted."
        )
        assert await parts(ward) == 0
        assert "no file" in await ward.said("files")


async def test_content_is_not_in_memory_after_a_start(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        await send(ward)
        assert await parts(ward) == -(-len(MAP) // PART_BYTES)
    async with a_ward(tmp_path) as ward:
        assert PART not in ward.kept.memory.facts
        held = await ward.kept.container_facts(ward.id_of(ADA))
        assert not any(fact.kind == PART for fact in held)


async def test_nobody_sees_or_gets_the_file_of_another() -> None:
    async with a_ward() as ward:
        await send(ward, account=BO)
        assert "no file" in await ward.said("files", account=ADA)
        for what in ("get", "delete"):
            assert "You have no file" in await ward.said("files", f"{what} map.png", account=ADA)
        assert "private chat" in await ward.said("files", account=BO, kind=ChatKind.GROUP)
        assert "map.png" in await ward.said("files", account=BO)


async def test_what_is_written_beneath_is_followed_if_it_means_something() -> None:
    async with a_ward() as ward:
        said = await send(ward, text="omni wave")
        assert ward.acted() == 1
        assert "kept for you" in said
        said = await send(ward, "b.png", text="the hall, seen from the door")
        assert ward.acted() == 1
        assert said.count("\n") == 1, said  # two lines about the file, none about the words


async def test_a_stop_beneath_a_file_stops() -> None:
    async with a_ward() as ward:
        await send(ward, text="stop")
        assert ward.gateway.rooms.stops["omni"].latched


@pytest.mark.parametrize("standing", NOT_OWN)
async def test_what_is_not_somebodys_own_is_not_taken(standing: MessageValidity) -> None:
    async with a_ward() as ward:
        assert await send(ward, standing=standing) == ""
        assert await parts(ward) == 0


async def test_what_somebody_else_may_have_sent_is_not_taken_and_its_author_told() -> None:
    async with a_ward() as ward:
        assert await send(ward, standing=MessageValidity.UNVERIFIED) == MAY_LOOK
        assert await parts(ward) == 0


async def test_strangers_and_groups_leave_nothing() -> None:
    async with a_ward() as ward:
        said = await send(ward, account=STRANGER)
        assert "kept" not in said
        assert await send(ward, chat="g", kind=ChatKind.GROUP) == ""
        assert await send(ward, chat="g", kind=ChatKind.GROUP, text="look at this") == ""
        assert await parts(ward) == 0


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.png", b"\x7fELF" + bytes(900_000)),
        ("a.txt", b"a" * 600_000 + b"\0"),
        ("a.exe", b"MZ\0\0"),
    ],
)
async def test_what_is_no_known_kind_leaves_nothing(name: str, content: bytes) -> None:
    async with a_ward() as ward:
        assert "none of the kinds" in await send(ward, name, content)
        assert await parts(ward) == 0
        assert ward.data_context.files.used(ward.id_of(ADA)) == (0, 0)


async def test_an_archive_is_kept_as_it_is() -> None:
    """A bomb and an archive with bad names: nothing looks inside."""
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as packed:
        packed.writestr("../../../etc/cron.d/x", b"\0" * 50_000_000)
        packed.writestr("/absolute", b"x")
    async with a_ward() as ward:
        assert "bomb.zip (zip," in await send(ward, "bomb.zip", bomb.getvalue())
        back = await ward.ask("files", "get bomb.zip")
        assert back.attachment is not None
        assert back.attachment.content == bomb.getvalue()


async def test_a_second_file_of_a_name_gets_another() -> None:
    async with a_ward() as ward:
        await send(ward, "a.yaml", NOTE)
        assert "A (2).yaml" in await send(ward, "A.yaml", NOTE)
        assert {one.name for one in ward.data_context.files.of(ward.id_of(ADA))} == {
            "a.yaml",
            "A (2).yaml",
        }


async def test_the_same_message_again_is_the_same_file() -> None:
    async with a_ward() as ward:
        inbound = ward.chat.enclose("a.yaml", NOTE, account=ADA, chat=ADA)
        await come(ward)
        ward.chat.deliver(inbound)
        await come(ward)
        assert ward.data_context.files.used(ward.id_of(ADA))[0] == 1


async def test_too_large_is_said_at_once() -> None:
    async with a_ward() as ward:
        said = await send(ward, "big.zip", b"PK\x03\x04" + bytes(1_100_000))
        assert "up to 1000000 bytes" in said
        assert "%" not in said
        assert await parts(ward) == 0


async def test_a_messenger_without_files_says_so() -> None:
    async with a_ward() as ward:
        ward.gateway._messengers[0].fetch_bytes = 0
        assert await send(ward) == "I cannot take files over this messenger."


async def test_there_is_only_so_much_room() -> None:
    async with a_ward() as ward:
        ward.data_context.files.room = FileQuota(
            files=2, person_bytes=900_000, place_bytes=1_000_000
        )
        await send(ward)
        assert "you have 300 KB left here" in await send(ward, "b.png")
        assert "kept for you" in await send(ward, "c.yaml", NOTE)
        assert "2 files for each person" in await send(ward, "d.yaml", NOTE)
        assert "kept for you" in await send(ward, "e.yaml", NOTE, account=BO)
        assert "no room for files here" in await send(ward, account=BO)
        await ward.said("files", "delete map.png")
        assert "kept for you" in await send(ward, account=BO)


class Slow:
    """Fetches in a way that a test owns."""

    def __init__(self, ward: Ward) -> None:
        self.go = asyncio.Event()
        self.broken: type[BaseException] | None = None
        self.extra = b""
        ward.gateway._messengers[0].fetch = self.fetch  # type: ignore[method-assign]
        self._honest = ward.chat.fetch

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        async for piece in self._honest(enclosure):
            yield piece
            await self.go.wait()
            if self.broken is not None:
                raise self.broken
        if self.extra:
            yield self.extra


async def test_progress_is_shown_in_one_message_that_becomes_the_answer() -> None:
    async with a_ward() as ward:
        ward.chat.fetch_bytes = ward.gateway._messengers[0].fetch_bytes = 5_000_000
        slow = Slow(ward)
        content = b"PK\x03\x04" + bytes(2_000_000)
        ward.chat.enclose("log.zip", content, account=ADA, chat=ADA)
        await ward.quiet()
        shown, outbound = ward.last()
        assert outbound.text == "Taking the file in: 3 % of 2.0 MB."
        await ward.say("omni wave")  # nothing waits for a file
        assert ward.acted() == 1
        slow.go.set()
        await come(ward)
        assert "log.zip (zip, 2.0 MB) is kept" in ward.chat.shown(shown).text


@pytest.mark.parametrize("broken", [ValueError, OSError, TimeoutError])
async def test_what_breaks_off_leaves_nothing(broken: type[Exception]) -> None:
    async with a_ward() as ward:
        slow = Slow(ward)
        slow.broken = broken
        slow.go.set()
        assert "Something went wrong" in await send(ward)
        assert await parts(ward) == 0
        assert ward.data_context.files.used(ward.id_of(ADA)) == (0, 0)


async def test_a_messenger_that_sends_more_than_it_said_is_not_believed() -> None:
    async with a_ward() as ward:
        slow = Slow(ward)
        slow.extra = b"x"
        slow.go.set()
        assert "Something went wrong" in await send(ward)
        assert await parts(ward) == 0


async def test_an_interrupted_file_is_taken_away_and_said(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        files, who = ward.data_context.files, ward.id_of(ADA)
        async with ward.data_context.changes.turn() as turn:
            await turn.write(files.begin(who, "f1", "map.txt", len(MAP)))
            await turn.write((files.part(who, "f1", 0, MAP[:PART_BYTES]),))
        assert files.of(who) == ()  # not whole, so not there
    async with a_ward(tmp_path) as ward:
        await ward.quiet()
        assert await parts(ward) == 0
        assert ward.data_context.files.used(ward.id_of(ADA)) == (0, 0)
        assert ward.last()[1].text == (
            "map.txt had not come whole when I was restarted. Send it again."
        )


async def test_only_so_many_come_at_once() -> None:
    async with a_ward() as ward:
        slow = Slow(ward)
        for number in range(12):
            ward.chat.enclose(f"{number}.yaml", NOTE, account=ADA, chat=ADA)
        await ward.quiet()
        refused = [t for t in ward.chat.told if "still taking in" in t.outbound.text]
        assert len(refused) == 2
        slow.go.set()
        await come(ward)
        assert ward.data_context.files.used(ward.id_of(ADA))[0] == 10


async def test_who_is_erased_leaves_no_file(tmp_path: Path) -> None:
    async with a_ward(tmp_path) as ward:
        await send(ward, account=BO)
        mine = await ward.said("mydata", account=BO)
        assert "files you sent: 1" in mine
        assert "what is in them: 1 (586 KiB)" in mine
        who = ward.id_of(BO)
        erasing = asyncio.ensure_future(ward.sure("forget", "me", account=BO))
        while not erasing.done():  # the disk takes real time, while 10 s pass on the test's clock
            await ward.clock.advance(0.1)
            await asyncio.sleep(0.002)
        assert "forgotten" in await erasing
        assert await parts(ward) == 0
        assert ward.data_context.files.used(who) == (0, 0)


async def test_delete_is_one_tap() -> None:
    async with a_ward() as ward:
        await send(ward)
        button, under = ward.button("Delete")
        assert isinstance(button, Button)
        assert "map.png is deleted." in await ward.tap(button, under)


async def test_a_damaged_file_is_not_handed_over() -> None:
    async with a_ward() as ward:
        await send(ward)
        (first, *_) = await ward.kept.facts(PART, "", 1)
        assert first.letter is not None
        letter = replace(first.letter, content=b"\0" + first.letter.content[1:])
        await ward.kept.write(replace(first, letter=letter))
        reply = await ward.ask("files", "get map.png")
        assert reply.attachment is None
        assert "does not read as it was kept" in reply.text


def test_the_drawer_keeps_room_for_what_is_coming() -> None:
    drawer = FileStore(ManualClock(), FileQuota(files=3, person_bytes=1_000, place_bytes=1_500))
    for fact in drawer.begin("a", "f1", "x", 900):
        drawer.apply(fact)
    with pytest.raises(TooManyRequests):
        drawer.begin("a", "f2", "x", 101)
    with pytest.raises(TooManyRequests):
        drawer.begin("b", "f2", "x", 601)
    with pytest.raises(NotUnderstood):
        drawer.find("a", "x")
    for fact in drawer.drop("f1"):
        drawer.apply(fact)
    assert drawer.begin("a", "f2", "x", 1_000)
    assert drawer.drop("f9") == ()
