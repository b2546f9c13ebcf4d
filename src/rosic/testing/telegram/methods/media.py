"""Photos, documents and files (https://core.telegram.org/bots/api#sending-files)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.testing.telegram import files
from rosic.testing.telegram.methods.call import Call, Method, unsupported
from rosic.testing.telegram.methods.messages import (
    ADDRESSED,
    CAPTIONED,
    MAX_CAPTION,
    SENDING,
    editable,
    edited,
    formatted,
    sent,
)
from rosic.testing.telegram.parameters import CallParameters, Kind, Upload
from rosic.testing.telegram.refusals import ApiError, bad_request
from rosic.testing.telegram.state import Content, JsonObject, ServerFile

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.testing.telegram.world import World

MAX_PHOTO = 10 * 1024 * 1024
MAX_PHOTO_SIDES = 10_000
MAX_PHOTO_RATIO = 20
GIF_HEAD = 13


def send_photo(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#sendphoto: 10 MB, sides together 10000, ratio 20."""
    return _send(world, call, _photo(world, call, "photo"))


def _photo(world: World, call: Call, field: str) -> JsonObject:
    upload = _upload(world, call, field, "photo")
    if isinstance(upload, ServerFile):
        return {"photo": [upload.show]}
    if upload.size > MAX_PHOTO:
        raise ApiError(413, "Request Entity Too Large")
    size = files.image_size(upload.content)
    if size is None:
        raise bad_request("IMAGE_PROCESS_FAILED")
    if sum(size) > MAX_PHOTO_SIDES or max(size) > MAX_PHOTO_RATIO * min(size):
        raise bad_request("PHOTO_INVALID_DIMENSIONS")
    return {"photo": [files.store_photo(world, upload, size).show]}


def send_document(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#senddocument: 50 MB."""
    return _send(world, call, _document(world, call, "document"))


def _document(world: World, call: Call, field: str) -> JsonObject:
    upload = _upload(world, call, field, "document")
    if isinstance(upload, Upload):
        upload = files.store_document(world, upload)
    return {"document": upload.show}


def send_animation(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#sendanimation: GIF or silent H.264, 50 MB.

    "For backward compatibility, when this field is set, the document field will also be set."
    """
    return _send(world, call, _animation(world, call, "animation"))


def _animation(world: World, call: Call, field: str) -> JsonObject:
    upload = _upload(world, call, field, "animation")
    if isinstance(upload, Upload):
        if not upload.content.startswith((b"GIF87a", b"GIF89a")) or len(upload.content) < GIF_HEAD:
            raise unsupported(world, call, "animations other than GIF")
        upload = files.store_animation(world, upload)
    return {"animation": upload.show, "document": upload.show}


def _upload(world: World, call: Call, field: str, kind: str) -> Upload | ServerFile:
    """Return what was sent: new content, or a file that Telegram holds already."""
    given = call.args.file(field)
    if given is None or given == "":
        raise bad_request(f"there is no {field} in the request")
    if isinstance(given, str):
        if given.startswith(("http://", "https://")):
            raise unsupported(world, call, "sending by URL")
        held = world.state.files.get(given)
        if held is None or held.kind != kind:
            raise bad_request("wrong file identifier/HTTP URL specified")
        return held
    if given.size > world.settings.max_upload_bytes:
        raise ApiError(413, "Request Entity Too Large")
    if not given.size:
        raise bad_request("file must be non-empty")
    return given


def _send(world: World, call: Call, media: JsonObject) -> JsonObject:
    return sent(world, call, _content(call, media))


def _content(call: Call, media: JsonObject) -> Content:
    caption, marked = formatted(call.args, "caption", "caption_entities", MAX_CAPTION)
    return Content(caption=caption or None, caption_entities=marked, media=media)


def edit_message_media(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#editmessagemedia: also "to add media to text messages"."""
    media = call.args.object("media") or {}
    kind = media.get("type")
    if kind not in EDITABLE:
        raise unsupported(world, call, f"a media of type {kind!r}")
    for field in set(media) - INPUT_MEDIA:
        world.journal.violation(call.method, f"unknown field {field!r} in media")
    parts = CallParameters(
        {name: value for name, value in media.items() if name != "type"}, call.args.files
    )
    inner = Call(call.method, parts, call.alive)
    content = EDITABLE[kind](world, inner)
    changes = {
        "text": None,
        "entities": [],
        "media": content.media,
        "caption": content.caption,
        "caption_entities": content.caption_entities,
    }
    return edited(world, call, editable(world, call), changes)


def get_file(world: World, call: Call) -> JsonObject:
    """https://core.telegram.org/bots/api#getfile: "up to 20MB in size"."""
    held = world.state.files.get(call.args.text("file_id"))
    if held is None:
        raise bad_request("invalid file_id")
    size = held.show["file_size"] if held.left else len(held.content)
    if size > world.settings.max_download_bytes:
        raise bad_request("file is too big")
    held.open_link(world.clock.now_s() + world.settings.link_lifetime_s)
    folder = world.settings.local_folder
    return {
        "file_id": held.id,
        "file_unique_id": held.unique_id,
        "file_size": held.show["file_size"],
        "file_path": files.left_in(folder, held) if folder else held.path,
    }


EDITABLE: dict[str, Callable[[World, Call], Content]] = {
    "photo": lambda world, call: _content(call, _photo(world, call, "media")),
    "document": lambda world, call: _content(call, _document(world, call, "media")),
    "animation": lambda world, call: _content(call, _animation(world, call, "media")),
}
"""https://core.telegram.org/bots/api#inputmedia; of the other kinds this server has none."""
INPUT_MEDIA = frozenset(
    {
        "type",
        "media",
        "thumbnail",
        "caption",
        "parse_mode",
        "caption_entities",
        "show_caption_above_media",
        "has_spoiler",
        "width",
        "height",
        "duration",
        "disable_content_type_detection",
    }
)
METHODS = {
    "editMessageMedia": Method({**ADDRESSED, "media": Kind.OBJECT}, edit_message_media),
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
