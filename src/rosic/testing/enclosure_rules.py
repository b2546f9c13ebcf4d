"""What every messenger owes whose people send files, and what the others owe: a fault."""

from __future__ import annotations

from typing import TYPE_CHECKING

from msgspec.structs import replace

from rosic.core.message import Enclosure
from rosic.errors import MessengerFault
from rosic.testing.messenger_stage import Ear, listening, until

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.testing.messenger_stage import MessengerHarness

NAME = "hall 2.yaml"
CONTENT = bytes(range(256)) * 700 + b"\r\nend\n"
"""Longer than what a network brings at once."""


class EnclosureRules:
    """The rules about files that people send; a part of `MessengerConformance`."""

    async def test_a_file_of_a_person_comes_as_it_was_sent(self, stage: MessengerHarness) -> None:
        """Under its name, with its size, and byte for byte."""
        if not stage.messenger.fetch_bytes:
            return
        async with listening(stage) as ear:
            enclosure = await _sent(stage, ear)
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
        async with listening(stage) as ear:
            enclosure = await _sent(stage, ear)
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
        unknown = Enclosure(id="document-of-nobody", name=NAME, size=10)
        large = replace(unknown, size=messenger.fetch_bytes + 1)
        async with listening(stage) as ear:
            for enclosure in (unknown, large):
                assert (await _fetched(messenger, enclosure))[1] is not None
            if not messenger.fetch_bytes:
                return
            enclosure = await _sent(stage, ear)
            async with stage.outage():
                assert (await _fetched(messenger, enclosure))[1] is not None


async def _sent(stage: MessengerHarness, ear: Ear) -> Enclosure:
    """Let a person send a file; return what the messenger says of it."""
    before = len(ear.done)
    await stage.enclose(stage.people[0], NAME, CONTENT)
    await until(stage, lambda: len(ear.done) > before, "a file was swallowed")
    enclosure = ear.done[before].enclosed
    assert enclosure is not None, "a file came without a word of it"
    return enclosure


async def _fetched(messenger: Messenger, enclosure: Enclosure) -> tuple[bytes, str | None]:
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
