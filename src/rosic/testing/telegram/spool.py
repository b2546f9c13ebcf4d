"""Large files of a local server: on its disk, never in its memory."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import TYPE_CHECKING, Final

import msgspec

if TYPE_CHECKING:
    from aiohttp import BodyPartReader

HELD_BYTES: Final = 8_000_000
"""What is larger goes to the disk of a server that has one."""
PIECE_BYTES: Final = 1_048_576


class DiskFile(msgspec.Struct, frozen=True, kw_only=True):
    """A file that lies on the server's disk.

    Attributes:
        path: Where.
        size: Bytes.
        sha256: Of its content, hexadecimal.
    """

    path: str
    size: int
    sha256: str


def on_disk(path: str) -> DiskFile:
    """Return what lies there, looked at piece by piece."""
    digest = hashlib.sha256()
    with Path(path).open("rb") as file:
        while piece := file.read(PIECE_BYTES):
            digest.update(piece)
        return DiskFile(path=path, size=file.tell(), sha256=digest.hexdigest())


async def received(part: BodyPartReader, folder: str) -> bytes | DiskFile:
    """Read a file part: into memory, or what is large into a folder as it comes."""
    held = bytearray()
    while len(held) <= HELD_BYTES:
        piece = await part.read_chunk(PIECE_BYTES)
        if not piece:
            return bytes(held)
        held += piece
    path = Path(folder) / "incoming" / os.urandom(8).hex()
    path.parent.mkdir(parents=True, exist_ok=True)
    digest, size = hashlib.sha256(), 0
    with path.open("xb") as file:
        piece = bytes(held)
        held.clear()
        while piece:
            size += len(piece)
            digest.update(piece)
            file.write(piece)
            piece = await part.read_chunk(PIECE_BYTES)
    return DiskFile(path=str(path), size=size, sha256=digest.hexdigest())
