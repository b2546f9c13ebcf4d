"""From an HTTP request to parameters (https://core.telegram.org/bots/api#making-requests)."""

from __future__ import annotations

import msgspec
from aiohttp import BodyPartReader, MultipartReader, web

from rosic.testing.telegram.parameters import Raw, Upload
from rosic.testing.telegram.refusals import ApiError, bad_request
from rosic.testing.telegram.spool import OnDisk, received


async def read(request: web.Request, folder: str = "") -> Raw:
    """Return the parameters of the query string and the body; the body wins.

    Args:
        request: As it comes.
        folder: Where large files are left while they come; empty to hold them in memory.

    Raises:
        ApiError: 400 for a JSON body that is no object, 413 for more than the server takes.
    """
    values: dict[str, object] = dict(request.query)
    content_type = request.content_type if request.can_read_body else ""
    try:
        if content_type == "application/json":
            body = _json_object(await request.read())
            return Raw(values=values | body, files={}, typed=frozenset(body))
        if content_type == "multipart/form-data":
            return await _multipart(request, values, folder)
        if content_type == "application/x-www-form-urlencoded":
            values.update(await request.post())
    except web.HTTPRequestEntityTooLarge:
        raise ApiError(413, "Request Entity Too Large") from None
    return Raw(values=values, files={})


def _json_object(body: bytes) -> dict[str, object]:
    try:
        parsed = msgspec.json.decode(body)
    except msgspec.DecodeError:
        raise bad_request("can't parse request: invalid JSON") from None
    if not isinstance(parsed, dict):
        raise bad_request("can't parse request: JSON object expected")
    return parsed


async def _multipart(request: web.Request, values: dict[str, object], folder: str) -> Raw:
    files: dict[str, Upload] = {}
    reader = await request.multipart()
    while (part := await reader.next()) is not None:
        if isinstance(part, MultipartReader):
            raise bad_request("can't parse request: nested multipart")
        if part.filename is not None and folder:
            files[part.name or ""] = await _spooled(part, part.filename, folder)
        else:
            await _keep(part, values, files)
    return Raw(values=values, files=files)


async def _spooled(part: BodyPartReader, name: str, folder: str) -> Upload:
    found, kind = await received(part, folder), part.headers.get("Content-Type", "")
    if isinstance(found, OnDisk):
        return Upload(name=name, content_type=kind, on_disk=found)
    return Upload(name=name, content_type=kind, content=found)


async def _keep(part: BodyPartReader, values: dict[str, object], files: dict[str, Upload]) -> None:
    name = part.name or ""
    content = bytes(await part.read(decode=True))
    if part.filename is None:
        values[name] = content.decode("utf-8", "replace")
        return
    files[name] = Upload(
        name=part.filename,
        content_type=part.headers.get("Content-Type", ""),
        content=content,
    )
