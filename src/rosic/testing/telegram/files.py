"""Files that Telegram holds."""

from __future__ import annotations

import os
import struct
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from rosic.testing.telegram.state import JsonObject, ServerFile

if TYPE_CHECKING:
    from rosic.testing.telegram.parameters import Upload
    from rosic.testing.telegram.world import World

PNG = b"\x89PNG\r\n\x1a\n"
JPEG = b"\xff\xd8\xff"
JPEG_SIZE_MARKERS = frozenset({0xC0, 0xC1, 0xC2, 0xC3})


def image_size(content: bytes) -> tuple[int, int] | None:
    """Return width and height in pixels of a PNG or JPEG, else None."""
    if content.startswith(PNG) and len(content) >= 24:
        width, height = struct.unpack(">II", content[16:24])
        return (width, height) if width and height else None
    return _jpeg_size(content) if content.startswith(JPEG) else None


def _jpeg_size(content: bytes) -> tuple[int, int] | None:
    at = 2
    while at + 9 < len(content) and content[at] == 0xFF:
        if content[at + 1] in JPEG_SIZE_MARKERS:
            height, width = struct.unpack(">HH", content[at + 5 : at + 9])
            return width, height
        at += 2 + int(struct.unpack(">H", content[at + 2 : at + 4])[0])
    return None


def store_document(world: World, upload: Upload) -> ServerFile:
    """Keep a document; its name is the last part of what was given."""
    name = PurePosixPath(upload.name.replace("\\", "/")).name or "file"
    show = {"file_name": name, "mime_type": upload.content_type or "application/octet-stream"}
    return _store(world, upload, "document", show)


def store_animation(world: World, upload: Upload) -> ServerFile:
    """Keep a GIF; how long it lasts is not looked into."""
    width, height = struct.unpack("<HH", upload.content[6:10])
    show = {"width": width, "height": height, "duration": 1, "mime_type": "image/gif"}
    return _store(world, upload, "animation", show)


def store_photo(world: World, upload: Upload, size: tuple[int, int]) -> ServerFile:
    """Keep a photo of this width and height."""
    return _store(world, upload, "photo", {"width": size[0], "height": size[1]})


def _store(world: World, upload: Upload, kind: str, show: JsonObject) -> ServerFile:
    """https://core.telegram.org/bots/api#file: the unique id names content and opens nothing."""
    number = world.serial()
    digest = upload.sha256
    suffix = PurePosixPath(upload.name).suffix[:10] or ".bin"
    held = ServerFile(
        id=f"{kind}-{number}-{digest[:24]}",
        unique_id=f"u{digest[:15]}",
        name=upload.name,
        path=f"{kind}s/file_{number}{suffix}",
        kind=kind,
        content=upload.content,
        show={},
        left="" if upload.on_disk is None else upload.on_disk.path,
    )
    held.show = {
        "file_id": held.id,
        "file_unique_id": held.unique_id,
        "file_size": upload.size,
        **show,
    }
    world.state.files[held.id] = held
    return held


def by_path(world: World, path: str) -> ServerFile | None:
    """Return the file behind a `file_path`, while the link that getFile gave is good."""
    held = next((held for held in world.state.files.values() if held.path == path), None)
    now_s = world.clock.now_s()
    return held if held is not None and now_s < held.link_until_s else None


def left_in(folder: str, held: ServerFile) -> str:
    """Leave a file where a local server does, and return its absolute path."""
    path = Path(folder) / held.path
    path.parent.mkdir(parents=True, exist_ok=True)
    if not held.left:
        path.write_bytes(held.content)
    elif not path.exists():
        os.link(held.left, path)
    return str(path)
