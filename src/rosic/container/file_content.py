"""The content of a file, read from its parts and checked against its digest."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Final

from rosic.container import file_messages as words
from rosic.container.files import PART
from rosic.core.message import Attachment, StreamedContent
from rosic.errors import RecordUnavailable, StoreFault

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.container.files import StoredFile
    from rosic.contracts.store import ContainerStore

AT_ONCE: Final = 4
IN_PIECES_FROM: Final = 1_000_000
"""What is larger is never in memory as a whole, and its way is shown."""


async def pieces_of(container_store: ContainerStore, filed: StoredFile) -> AsyncGenerator[bytes]:
    """Yield what is in a file; a few parts at a time, so that writes pass between.

    Raises:
        RecordUnavailable: It cannot be read now, or is not what was kept; before the last piece.
    """
    digest, count, after, held = hashlib.sha256(), 0, f"{filed.id}.", b""
    while count < filed.size:
        try:
            page = await container_store.facts(PART, after, AT_ONCE)
        except StoreFault as fault:
            raise RecordUnavailable(words.DAMAGED) from fault
        ours = [one for one in page if one.key.startswith(f"{filed.id}.") and one.letter]
        if not ours:
            break
        for fact in ours:
            assert fact.letter is not None  # noqa: S101 - for the type checker
            if held:
                yield held
            held = fact.letter.content
            digest.update(held)
            count += len(held)
        after = ours[-1].key
    if digest.digest() != filed.digest:
        raise RecordUnavailable(words.DAMAGED)
    yield held


async def content_of(container_store: ContainerStore, filed: StoredFile) -> bytes:
    """Return what is in a small file.

    Raises:
        RecordUnavailable: It cannot be read now, or is not what was kept.
    """
    return b"".join([piece async for piece in pieces_of(container_store, filed)])


async def attachment_of(container_store: ContainerStore, filed: StoredFile) -> Attachment:
    """Return a file as it goes with a message: a large one is read only while it is sent.

    Raises:
        RecordUnavailable: A small one cannot be read now, or is not what was kept.
    """
    if filed.size <= IN_PIECES_FROM:
        return Attachment(filed.name, filed.media_type, await content_of(container_store, filed))
    pieces = StreamedContent(filed.size, lambda: pieces_of(container_store, filed))
    return Attachment(filed.name, filed.media_type, pieces=pieces)
