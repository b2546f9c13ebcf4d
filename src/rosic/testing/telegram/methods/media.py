"""Photos, documents and files (https://core.telegram.org/bots/api#sending-files)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.testing.telegram import files
from rosic.testing.telegram.methods.call import Call, Method, unsupported
from rosic.testing.telegram.methods.messages import (
    CAPTIONED,
    MAX_CAPTION,
    SENDING,
    formatted,
    sent,
)
from rosic.testing.telegram.parameters import Kind, Upload
from rosic.testing.telegram.refusals import ApiError, bad_request
from rosic.testing.telegram.state import Content, JsonObject, StoredFile

if TYPE_CHECKING:
    from rosic.testing.telegram.world import World

MAX_PHOTO = 10 * 1024 * 1024
MAX_PHOTO_SIDES = 10_000
MAX_PHOTO_RATIO = 20
GIF_HEAD = 13


def send_photo(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#sendphoto: 10 MB, sides together 10000, ratio 20."""
    upload = _upload(world, call, "photo")
    if isinstance(upload, StoredFile):
        return _send(world, call, {"photo": [upload.show]})
    if len(upload.content) > MAX_PHOTO:
        raise ApiError(413, "Request Entity Too Large")
    size = files.image_size(upload.content)
    if size is None:
        raise bad_request("IMAGE_PROCESS_FAILED")
    if sum(size) > MAX_PHOTO_SIDES or max(size) > MAX_PHOTO_RATIO * min(size):
        raise bad_request("PHOTO_INVALID_DIMENSIONS")
    return _send(world, call, {"photo": [files.store_photo(world, upload, size).show]})


def send_document(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#senddocument: 50 MB."""
    upload = _upload(world, call, "document")
    if isinstance(upload, Upload):
        upload = files.store_document(world, upload)
    return _send(world, call, {"document": upload.show})


def send_animation(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#sendanimation: GIF or silent H.264, 50 MB.

    "For backward compatibility, when this field is set, the document field will also be set."
    """
    upload = _upload(world, call, "animation")
    if isinstance(upload, Upload):
        if not upload.content.startswith((b"GIF87a", b"GIF89a")) or len(upload.content) < GIF_HEAD:
            raise unsupported(world, call, "animations other than GIF")
        upload = files.store_animation(world, upload)
    return _send(world, call, {"animation": upload.show, "document": upload.show})


def _upload(world: World, call: Call, field: str) -> Upload | StoredFile:
    """Return what was sent: new content, or a file that Telegram holds already."""
    given = call.args.file(field)
    if given is None or given == "":
        raise bad_request(f"there is no {field} in the request")
    if isinstance(given, str):
        if given.startswith(("http://", "https://")):
            raise unsupported(world, call, "sending by URL")
        held = world.state.files.get(given)
        if held is None or held.kind != field:
            raise bad_request("wrong file identifier/HTTP URL specified")
        return held
    if len(given.content) > world.settings.max_upload_bytes:
        raise ApiError(413, "Request Entity Too Large")
    if not given.content:
        raise bad_request("file must be non-empty")
    return given


def _send(world: World, call: Call, media: JsonObject) -> JsonObject:
    caption, marked = formatted(call.args, "caption", "caption_entities", MAX_CAPTION)
    return sent(world, call, Content(caption=caption or None, caption_entities=marked, media=media))


def get_file(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#getfile: "up to 20MB in size"."""
    held = world.state.files.get(call.args.text("file_id"))
    if held is None:
        raise bad_request("invalid file_id")
    if len(held.content) > world.settings.max_download_bytes:
        raise bad_request("file is too big")
    held.link_until_s = world.clock.now_s() + world.settings.link_lifetime_s
    folder = world.settings.local_folder
    return {
        "file_id": held.id,
        "file_unique_id": held.unique_id,
        "file_size": held.show["file_size"],
        "file_path": files.left_in(folder, held) if folder else held.path,
    }


METHODS = {
    "sendPhoto": Method(
        {**SENDING, **CAPTIONED, "photo": Kind.FILE, "has_spoiler": Kind.FLAG}, send_photo
    ),
    "sendDocument": Method(
        {
            **SENDING,
            **CAPTIONED,
            "document": Kind.FILE,
            "thumbnail": Kind.FILE,
            "disable_content_type_detection": Kind.FLAG,
        },
        send_document,
    ),
    "sendAnimation": Method(
        {
            **SENDING,
            **CAPTIONED,
            "animation": Kind.FILE,
            "duration": Kind.INTEGER,
            "width": Kind.INTEGER,
            "height": Kind.INTEGER,
            "thumbnail": Kind.FILE,
            "has_spoiler": Kind.FLAG,
        },
        send_animation,
    ),
    "getFile": Method({"file_id": Kind.TEXT}, get_file),
}
