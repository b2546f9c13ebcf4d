"""The routes of what is no text: what robots show, and files that people send and are sent."""

from __future__ import annotations

import asyncio
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal
from urllib.parse import quote

from litestar import Request, Response, get, post
from litestar.params import FromPath, QueryParameter
from litestar.status_codes import HTTP_201_CREATED

from rosic.api.lines import one_line
from rosic.api.ordering import RefusedOrder
from rosic.api.problems import problem
from rosic.api.resource_schemas import FileOut
from rosic.api.routes import Api, Who
from rosic.api.schemas import moment
from rosic.core.i18n import said
from rosic.core.identity import PAGE
from rosic.core.message import AnswerState
from rosic.core.robot.view import ViewKind
from rosic.errors import NotFound, NothingToSee
from rosic.gateway.requests import FILE, line_id

if TYPE_CHECKING:
    from rosic.api.callers import ApiCaller
    from rosic.api.context import ApiContext
    from rosic.core.message import Inbound
    from rosic.messengers.program.calls import ToolCall

NO_PICTURES: Final = said("This gateway draws no pictures.")
NOT_KEPT: Final = said("This gateway keeps no files.")
BROKEN_OFF: Final = said("An upload was broken off. Nothing was kept.")
NOT_SENT: Final = said("There is no such file in your conversation on the page, or not any more.")
WITHIN_S: Final = 300.0
FILE_ID: Final = 32
"""Of the message that brought it, so many digits are the id of a file."""
SHOWN: Final = frozenset({"image/png", "image/jpeg", "image/webp", "image/gif"})
"""What a browser may show: pictures that can hold no script. It only saves everything else."""


@get(
    "/robots/{robot:str}/views/{kind:str}",
    summary="What a robot shows now",
    tags=["robots"],
    media_type="image/png",
)
async def view(
    api: Api,
    caller: Who,
    robot: FromPath[str],
    kind: FromPath[Literal["picture", "map"]],
    low: Annotated[bool, QueryParameter(name="low")] = False,
) -> Response[bytes]:
    """Return a picture of what a robot sees (`picture`) or of its `map`; it may take seconds.

    `Rosic-Taken` says when it was taken. Pictures are counted with those of the chat.
    """
    found, views = api.profile(caller, robot), api.kernel.shared.views.find()
    if views is None:
        raise NothingToSee(NO_PICTURES)
    shown = await views.picture(caller.principal, found.id, ViewKind(kind), low=low)
    headers = {"Cache-Control": "no-store", "Rosic-Taken": moment(shown.taken_ns)}
    return Response(shown.content, media_type=shown.media_type, headers=headers)


@post("/files", status_code=HTTP_201_CREATED, summary="Send a file", tags=["files"])
async def send_file(
    api: Api,
    caller: Who,
    request: Request[Any, Any, Any],
    name: Annotated[str, QueryParameter(name="name", min_length=1, max_length=200)],
) -> FileOut:
    """Keep a file, as one sends it in a chat: the body is its content, of at most 25 MB.

    It is read while it comes, looked at, never opened, and kept in the caller's own container.
    """
    if api.kernel.containers is None:
        raise NotFound(NOT_KEPT)
    length = request.headers.get("content-length", "")
    size = int(length) if length.isdecimal() else 0
    messenger = api.messenger(caller)
    call, inbound = messenger.begin_file(caller.address, one_line(name), size, request.stream())
    try:
        return await _kept(api, caller, call, inbound)
    finally:
        messenger.drop_file(inbound)
        messenger.calls.close(call)


async def _kept(api: ApiContext, caller: ApiCaller, call: ToolCall, inbound: Inbound) -> FileOut:
    """Return a file once it is kept.

    Raises:
        RefusedOrder: It is not; the problem says why. Nothing of it is left.
    """
    containers = api.kernel.containers
    assert containers is not None  # noqa: S101 - asked before
    file = line_id(inbound, FILE).hex()[:FILE_ID]
    try:
        async with asyncio.timeout(WITHIN_S):
            while True:
                _, outbound = await call.news()
                for one in containers.files.of(caller.principal):
                    if one.id == file:
                        digest = one.digest.hex()
                        at = moment(one.at_ns)
                        return FileOut(one.id, one.name, one.size, one.media_type, digest, at)
                if outbound.state is not AnswerState.GOES_ON:
                    code, again_s = outbound.code or "not-understood", outbound.retry_after_s
                    raise RefusedOrder(problem(code, outbound.text, retry_after_s=again_s))
    except TimeoutError:
        sentence = api.callers.read_by(BROKEN_OFF, caller)
        raise RefusedOrder(problem("too-slow", sentence, status=408)) from None


@get(
    "/chat/{message:str}/file",
    summary="A file that I was sent on the page",
    tags=["chat"],
    media_type="application/octet-stream",
)
async def said_file(api: Api, caller: Who, message: FromPath[str]) -> Response[bytes]:
    """Return the file of a message of the caller's conversation on the page, to be saved.

    Only the newest ten are kept; a program has none.
    """
    found = None
    if caller.address.platform == PAGE and not api.is_locked_out(caller):
        found = api.page.conversation(caller.address.account).file(message)
    if found is None:
        raise NotFound(NOT_SENT)
    kind = found.media_type if found.media_type in SHOWN else "application/octet-stream"
    headers = {
        "Content-Disposition": f"attachment; filename*=UTF-8''{quote(found.name, safe='')}",
        "Cache-Control": "no-store",
    }
    return Response(found.content, media_type=kind, headers=headers)


ROUTES: Final = (view, send_file, said_file)
