"""The bot's door: `/bot<token>/METHOD_NAME` and `/file/bot<token>/<file_path>` over HTTP."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import json
import re
import socket
import struct
from typing import TYPE_CHECKING, NamedTuple

import msgspec
from aiohttp import BodyPartReader, MultipartReader, web

from rosic.testing.telegram import files
from rosic.testing.telegram.faults import AFTER, BAD_GATEWAY, ServerFault, ServerFaults
from rosic.testing.telegram.methods import bot, chats, media, messages
from rosic.testing.telegram.methods.call import ApiResult, Call, Method
from rosic.testing.telegram.parameters import CallParameters, Raw, Upload, check
from rosic.testing.telegram.refusals import ApiError, bad_request, too_many
from rosic.testing.telegram.spool import DiskFile, received

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.testing.telegram.state import JsonObject
    from rosic.testing.telegram.world import World


# ---- methods ----

METHODS: dict[str, Method] = {
    **bot.METHODS,
    **messages.METHODS,
    **media.METHODS,
    **chats.METHODS,
}
BY_LOWER = {name.lower(): name for name in METHODS}
"""Method names are case-insensitive (https://core.telegram.org/bots/api#making-requests)."""


class Prepared(NamedTuple):
    """A call whose method and parameters are known."""

    method: Method
    call: Call


def prepare(world: World, name: str, raw: Raw, alive: Callable[[], bool]) -> Prepared:
    """Find the method and check the parameters; what no correct client sends is written down.

    Raises:
        ApiError: 404 for an unknown method, 400 for parameters that cannot be parsed.
    """
    known = BY_LOWER.get(name.lower())
    if known is None:
        world.journal.violation(name, "unknown method, or one that this server lacks")
        raise ApiError(404, "Not Found: method not found")
    args, problems = check(METHODS[known].signature, raw)
    for problem in problems:
        world.journal.violation(known, problem)
    return Prepared(METHODS[known], Call(known, args, alive))


async def perform(world: World, prepared: Prepared) -> JsonObject:
    """Carry out the call.

    Returns:
        The answer with `ok` true.

    Raises:
        ApiError: Telegram would refuse.
    """
    if world.state.logged_out:
        raise ApiError(400, "Logged out")
    result = prepared.method.run(world, prepared.call)
    if inspect.isawaitable(result):
        result = await result
    if isinstance(result, ApiResult):
        return {"ok": True, "result": result.result, "description": result.description}
    return {"ok": True, "result": result}


def refused(error: ApiError) -> JsonObject:
    """Return the answer with `ok` false (https://core.telegram.org/bots/api#making-requests)."""
    shown: JsonObject = {
        "ok": False,
        "error_code": error.code,
        "description": error.description,
    }
    if error.parameters:
        shown["parameters"] = error.parameters
    return shown


def recorded(raw: Raw) -> JsonObject:
    """Return what the record keeps of a call that could not be read."""
    return CallParameters(dict(raw.values), raw.files).shown()


# ---- parameters (https://core.telegram.org/bots/api#making-requests) ----


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
    if isinstance(found, DiskFile):
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


# ---- HTTP ----

TOKEN_SHAPE = re.compile(r"[0-9]+:[^/]+\Z")


class HttpReply(NamedTuple):
    """What goes back: a status, and JSON."""

    status: int
    body: JsonObject


class BotDoor:
    """Serves the Bot API for one token."""

    def __init__(self, world: World, faults: ServerFaults, token: str) -> None:
        self._world = world
        self._faults = faults
        self._token = token
        self._closing = asyncio.Event()

    def routes(self) -> list[web.RouteDef]:
        """Return what to serve. Only GET and POST are supported (#making-requests)."""
        return [
            web.get(r"/bot{token:[^/]*}/{method:.*}", self._call, allow_head=False),
            web.post(r"/bot{token:[^/]*}/{method:.*}", self._call),
            web.get(r"/file/bot{token:[^/]*}/{path:.+}", self._download, allow_head=False),
        ]

    def close(self) -> None:
        """End everything that waits, so that the server can stop at once."""
        self._closing.set()
        self._world.queue.release()

    def _check_token(self, token: str) -> None:
        """404 for what cannot be a token, 401 for a foreign one, as the hosted server does."""
        if not TOKEN_SHAPE.match(token):
            raise ApiError(404, "Not Found")
        if token != self._token:
            raise ApiError(401, "Unauthorized")

    async def _call(self, request: web.Request) -> web.StreamResponse:
        method = request.match_info["method"]
        try:
            self._check_token(request.match_info["token"])
        except ApiError as error:
            return _respond(HttpReply(error.code, refused(error)))
        broken: ApiError | None = None
        try:
            raw = await read(request, self._world.settings.local_folder)
        except ApiError as error:
            raw, broken = Raw(values={}, files={}), error
        entry = self._world.journal.call(method, recorded(raw))
        await self._delay(self._faults.way_s(request.content_length or 0))
        fault = self._faults.next_for(method, raw.values.get("chat_id"))
        if fault is not None:
            entry["fault"] = fault.kind
        if fault is not None and fault.kind not in AFTER:
            response = await self._fail(request, fault, raw)
            entry["code"] = response.status
            return response
        reply = await self._answer(request, method, raw, broken)
        entry["code"] = reply.status
        entry["description"] = reply.body.get("description")
        if self._faults.latency_s or self._faults.bits_per_s:
            await self._delay(self._faults.way_s(len(_encoded(reply.body))))
        if fault is not None:
            return await self._spoil(request, fault, reply)
        return _respond(reply)

    async def _answer(
        self, request: web.Request, method: str, raw: Raw, broken: ApiError | None
    ) -> HttpReply:
        def alive() -> bool:
            return request.transport is not None and not request.transport.is_closing()

        try:
            if broken is not None:
                raise broken
            prepared = prepare(self._world, method, raw, alive)
            return HttpReply(200, await perform(self._world, prepared))
        except ApiError as error:
            return HttpReply(error.code, refused(error))

    async def _fail(self, request: web.Request, fault: ServerFault, raw: Raw) -> web.StreamResponse:
        """Fail the call before it takes effect."""
        match fault.kind:
            case "too_many_requests":
                self._tell_to_wait(fault, raw)
                error = too_many(fault.retry_after_s)
            case "error":
                error = ApiError(fault.code, fault.description)
            case "bad_gateway":
                return web.Response(status=502, body=BAD_GATEWAY, content_type="text/html")
            case _:
                if fault.kind == "hang":
                    await self._delay(fault.seconds)
                return _reset(request)
        return _respond(HttpReply(error.code, refused(error)))

    def _tell_to_wait(self, fault: ServerFault, raw: Raw) -> None:
        chat = raw.values.get("chat_id")
        if isinstance(chat, int | str) and str(chat).lstrip("-").isdigit():
            now_s = self._world.clock.now_s()
            self._world.limiter.told(int(chat), fault.retry_after_s, now_s)

    async def _spoil(
        self, request: web.Request, fault: ServerFault, reply: HttpReply
    ) -> web.StreamResponse:
        """Spoil the answer of a call that took effect."""
        if fault.kind == "truncated":
            body = msgspec.json.encode(reply.body)
            return web.Response(
                status=reply.status,
                body=body[: len(body) // 2],
                content_type="application/json",
            )
        if fault.kind == "hang_after":
            await self._delay(fault.seconds)
        return _reset(request)

    async def _delay(self, seconds: float) -> None:
        """Wait, but not longer than the server lives."""
        if seconds > 0:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._closing.wait(), seconds)

    async def _download(self, request: web.Request) -> web.StreamResponse:
        """https://core.telegram.org/bots/api#getfile."""
        try:
            self._check_token(request.match_info["token"])
        except ApiError as error:
            return _respond(HttpReply(error.code, refused(error)))
        path = request.match_info["path"]
        self._world.journal.add("download", path=path)
        fault = self._faults.next_for("download", None)
        if fault is not None and fault.kind == "bad_gateway":
            return web.Response(status=502, body=BAD_GATEWAY, content_type="text/html")
        held = None if self._world.settings.local_folder else files.by_path(self._world, path)
        if held is None:
            return _respond(HttpReply(404, refused(ApiError(404, "Not Found"))))
        if fault is not None:
            return await self._break_off(request, held.content)
        return web.Response(body=held.content, content_type="application/octet-stream")

    async def _break_off(self, request: web.Request, content: bytes) -> web.StreamResponse:
        """Reset the connection in the middle of a file."""
        response = web.StreamResponse(headers={"Content-Length": str(len(content))})
        await response.prepare(request)
        await response.write(content[: len(content) // 2])
        return _reset(request)


def _respond(reply: HttpReply) -> web.Response:
    headers = {}
    if wait_s := reply.body.get("parameters", {}).get("retry_after"):
        headers["Retry-After"] = str(wait_s)
    return web.Response(
        status=reply.status,
        body=_encoded(reply.body),
        content_type="application/json",
        headers=headers,
    )


def _encoded(body: object) -> bytes:
    """Return JSON; what is no text, such as half of a pair of surrogates, as the escapes for it."""
    try:
        return msgspec.json.encode(body)
    except UnicodeEncodeError:
        return json.dumps(msgspec.to_builtins(body)).encode()


def _reset(request: web.Request) -> web.Response:
    """Reset the connection: the peer reads ECONNRESET, not the end of a stream."""
    transport = request.transport
    if transport is not None:
        connection: socket.socket | None = transport.get_extra_info("socket")
        if connection is not None:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        transport.abort()
    return web.Response(status=499)
