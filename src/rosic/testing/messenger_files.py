"""What every messenger owes that sends files, and what the others owe: a fault."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.message import Attachment, Button, Outbound, Pieces
from rosic.errors import MessengerFault, RecordUnavailable
from rosic.testing.messenger_stage import faults_only, listening

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.testing.messenger_stage import MessengerHarness

PIECE = bytes(range(256)) * 20
LONG = " ".join(f"word{number}" for number in range(1_500))
YES = Button("Yes", "omni move 1 m", "nonce-1")
FILE = Attachment("my times.ics", "text/calendar", bytes(range(256)) + b"\r\nBEGIN\n")
PICTURE = Attachment(
    "way in.png",
    "image/png",
    bytes.fromhex(
        "89504e470d0a1a0a0000000d4948445200000001000000010802000000907753de"
        "0000000c49444154789c63f8ffff3f0005fe02fe0def46b80000000049454e44ae426082"
    ),
)
"""One white pixel."""


class FileRules:
    """The rules about files; a part of `MessengerConformance`."""

    async def test_a_file_arrives_whole_and_under_its_name(self, stage: MessengerHarness) -> None:
        """With what is said of it, and with a text that is longer than a caption may be."""
        person, chat = stage.people[0], stage.chat(stage.people[0])
        if not stage.messenger.file_bytes:
            return
        async with listening(stage):
            for text in ("Your times.", LONG):
                await stage.messenger.send(Outbound(chat=chat, text=text, attachment=FILE))
        assert await stage.files(person) == [(FILE.name, FILE.content)] * 2
        shown = [word for seen in await stage.screen(person) for word in seen.text.split()]
        assert shown == ["Your", "times.", *LONG.split()]

    async def test_a_picture_arrives_and_what_is_said_of_it_can_be_changed(
        self, stage: MessengerHarness
    ) -> None:
        """Beside its buttons; the text changes, the picture stays."""
        messenger, person = stage.messenger, stage.people[0]
        chat = stage.chat(person)
        if not messenger.file_bytes:
            return
        offer = Outbound(chat=chat, text="Scan me.", buttons=((YES,),), attachment=PICTURE)
        async with listening(stage):
            message = await messenger.send(offer)
            assert len(await stage.files(person)) == 1, "a picture was lost"
            assert await _reads(stage, message, "Scan me.")
            if not messenger.edits:
                return
            try:
                await messenger.edit(message, Outbound(chat=chat, text="Used."))
            except MessengerFault as fault:
                raise AssertionError("what has a picture could not be changed") from fault
        assert await _reads(stage, message, "Used.")
        assert len(await stage.files(person)) == 1

    async def test_a_file_in_pieces_arrives_whole_or_not_at_all(
        self, stage: MessengerHarness
    ) -> None:
        """What is read while it is sent may turn out not to be what was promised."""
        messenger, person = stage.messenger, stage.people[0]
        if not messenger.file_bytes:
            return
        whole = in_pieces(len(PIECE) * 3, PIECE, PIECE, PIECE)
        broken = in_pieces(len(PIECE) * 3, PIECE, PIECE)
        said = Outbound(chat=stage.chat(person), text="All of it.", attachment=whole)
        async with listening(stage):
            await messenger.send(said)
            spoilt = replace(said, attachment=broken)
            await faults_only("sending what is not as promised", messenger.send(spoilt))
        assert await stage.files(person) == [(whole.name, PIECE * 3)]

    async def test_a_file_that_is_too_large_is_a_messenger_fault(
        self, stage: MessengerHarness
    ) -> None:
        """Whoever sends no files takes every file for too large; a part of one is nothing."""
        person, most = stage.people[0], stage.messenger.file_bytes
        large = Attachment("all.jsonl", "application/x-ndjson", bytes(most + 1))
        outbound = Outbound(chat=stage.chat(person), text="All of it.", attachment=large)
        async with listening(stage):
            await faults_only("sending too large a file", stage.messenger.send(outbound))
        assert await stage.files(person) == []


def in_pieces(size: int, *pieces: bytes) -> Attachment:
    """Return a file of so many bytes; one that promises more than comes is found out."""

    async def read() -> AsyncGenerator[bytes]:
        for piece in pieces:
            yield piece
        if sum(map(len, pieces)) != size:
            raise RecordUnavailable("The file is not what it was. Nothing was sent.")

    return Attachment(FILE.name, FILE.media_type, pieces=Pieces(size, read))


async def _reads(stage: MessengerHarness, message: str, text: str) -> bool:
    """Whether that message shows that text, whatever stands beneath."""
    seen = await stage.screen(stage.people[0])
    return any(one.message == message and one.text.startswith(text) for one in seen)
