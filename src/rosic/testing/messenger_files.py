"""What every messenger owes that sends files, and what the others owe: a fault."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.message import Attachment, Button, IncomingFile, Outbound, StreamedContent
from rosic.errors import MessengerFault, RecordUnavailable
from rosic.testing.messenger_harness import HarnessInbox, faults_only, listening, until

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.contracts.messenger import Messenger
    from rosic.testing.messenger_harness import MessengerHarness


# ---- sending files ----

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

    return Attachment(FILE.name, FILE.media_type, pieces=StreamedContent(size, read))


async def _reads(stage: MessengerHarness, message: str, text: str) -> bool:
    """Whether that message shows that text, whatever stands beneath."""
    seen = await stage.screen(stage.people[0])
    return any(one.message == message and one.text.startswith(text) for one in seen)


# ---- files that people send ----

NAME = "hall 2.yaml"
CONTENT = bytes(range(256)) * 700 + b"\r\nend\n"
"""Longer than what a network brings at once."""


class EnclosureRules:
    """The rules about files that people send; a part of `MessengerConformance`."""

    async def test_a_file_of_a_person_comes_as_it_was_sent(self, stage: MessengerHarness) -> None:
        """Under its name, with its size, and byte for byte."""
        if not stage.messenger.fetch_bytes:
            return
        async with listening(stage) as inbox:
            enclosure = await _sent(stage, inbox)
            assert enclosure.name == NAME, "a file came under another name"
            assert enclosure.size == len(CONTENT), "a file came with another size"
            content, fault = await _fetched(stage.messenger, enclosure)
        assert fault is None, f"a file could not be fetched: {fault}"
        assert content == CONTENT, "another file was fetched than was sent"

    async def test_a_file_that_is_not_as_long_as_was_said_is_a_messenger_fault(
        self, stage: MessengerHarness
    ) -> None:
        """Room is kept for what was said, so no more than that is ever yielded."""
        if not stage.messenger.fetch_bytes:
            return
        async with listening(stage) as inbox:
            enclosure = await _sent(stage, inbox)
            less, fault = await _fetched(stage.messenger, replace(enclosure, size=1_000))
            assert len(less) <= 1_000, "more was yielded than was said"
            assert fault is not None, "a file that is longer than was said was fetched"
            more = replace(enclosure, size=len(CONTENT) + 1)
            _, fault = await _fetched(stage.messenger, more)
            assert fault is not None, "a file that is shorter than was said was fetched"

    async def test_a_file_that_cannot_be_fetched_is_a_messenger_fault(
        self, stage: MessengerHarness
    ) -> None:
        """Because it is too large, unknown, or the platform is away; nothing of it counts."""
        messenger = stage.messenger
        unknown = IncomingFile(id="document-of-nobody", name=NAME, size=10)
        large = replace(unknown, size=messenger.fetch_bytes + 1)
        async with listening(stage) as inbox:
            for enclosure in (unknown, large):
                assert (await _fetched(messenger, enclosure))[1] is not None
            if not messenger.fetch_bytes:
                return
            enclosure = await _sent(stage, inbox)
            large = replace(enclosure, size=messenger.fetch_bytes + 1)
            content, fault = await _fetched(messenger, large)
            assert fault is not None, "a file was fetched that is too large"
            assert not content, "a file that is too large was begun"
            async with stage.outage():
                assert (await _fetched(messenger, enclosure))[1] is not None


async def _sent(stage: MessengerHarness, inbox: HarnessInbox) -> IncomingFile:
    """Let a person send a file; return what the messenger says of it."""
    before = len(inbox.done)
    await stage.enclose(stage.people[0], NAME, CONTENT)
    await until(stage, lambda: len(inbox.done) > before, "a file was swallowed")
    enclosure = inbox.done[before].enclosed
    assert enclosure is not None, "a file came without a word of it"
    return enclosure


async def _fetched(messenger: Messenger, enclosure: IncomingFile) -> tuple[bytes, str | None]:
    """Fetch; return what came, and the sentence of the fault if there was one."""
    content = bytearray()
    try:
        async for piece in messenger.fetch(enclosure):
            content += piece
    except MessengerFault as fault:
        return bytes(content), str(fault)
    except Exception as error:
        raise AssertionError(f"fetching raised {type(error).__name__}") from error
    return bytes(content), None
