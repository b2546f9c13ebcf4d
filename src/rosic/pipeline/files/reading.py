"""The content of a file, put together from its parts and checked against its digest."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Final

from rosic.container import words_files as words
from rosic.container.drawer import PART
from rosic.errors import RecordUnavailable, StoreFault

if TYPE_CHECKING:
    from rosic.container.drawer import Filed
    from rosic.pipeline.containers.parts import Vault

AT_ONCE: Final = 4


async def content_of(vault: Vault, filed: Filed) -> bytes:
    """Return what is in a file; a few parts at a time, so that writes pass between.

    Raises:
        RecordUnavailable: It cannot be read now, or is not what was kept.
    """
    content = bytearray()
    after = f"{filed.id}."
    while len(content) < filed.size:
        try:
            page = await vault.facts(PART, after, AT_ONCE)
        except StoreFault as fault:
            raise RecordUnavailable(words.DAMAGED) from fault
        ours = [one for one in page if one.key.startswith(f"{filed.id}.") and one.letter]
        if not ours:
            break
        for fact in ours:
            assert fact.letter is not None  # noqa: S101 - for the type checker
            content += fact.letter.content
        after = ours[-1].key
    if hashlib.sha256(content).digest() != filed.digest:
        raise RecordUnavailable(words.DAMAGED)
    return bytes(content)
