"""The test's door: every verb of the control side as `POST /_control/VERB` with a JSON object.

The answer is `{"ok": true, "result": ...}`, or 400 with `{"ok": false, "error": "..."}`. GET works
for verbs whose parameters are numbers and words. Telegram has nothing like it.
"""

from __future__ import annotations

import base64
import inspect
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, Unpack

import msgspec
from aiohttp import web

from rosic.testing.telegram.refusals import ControlError

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.testing.telegram.people import MessageOptions
    from rosic.testing.telegram.state import JsonObject
    from rosic.testing.telegram.world import World

VERBS = (
    "create_user",
    "set_language",
    "say",
    "edit",
    "tap",
    "react",
    "delete",
    "backlog",
    "create_chat",
    "create_topic",
    "topics",
    "set_member",
    "block",
    "link",
    "migrate",
    "fail",
    "calm",
    "set_latency",
    "set_limits",
    "advance",
    "shift_dates",
    "duplicate",
    "reorder",
    "jump",
    "put_update",
    "foreign_webhook",
    "message",
    "messages",
    "press",
    "presses",
    "pending",
    "changes",
    "wait",
    "clear_record",
    "save",
)


class ControlledServer(Protocol):
    """What the door needs of the server besides the verbs, which it finds by their names."""

    world: World

    @property
    def violations(self) -> list[JsonObject]:
        """What no correct client does."""
        ...

    @property
    def calls(self) -> list[JsonObject]:
        """Every call."""
        ...

    @property
    def seq(self) -> int:
        """The number of the newest change."""
        ...

    def file(self, file_id: str) -> bytes:
        """Return the content of a file."""
        ...

    def send_file(
        self,
        chat: int,
        user: int,
        name: str,
        content: bytes | Path,
        **unusual: Unpack[MessageOptions],
    ) -> int:
        """Send a file as a person does."""
        ...

    def swap_file(self, file_id: str, content: bytes) -> None:
        """Let a file hold something else."""
        ...


class ControlDoor:
    """Serves the verbs of one server."""

    def __init__(self, server: ControlledServer) -> None:
        self._server = server
        self._verbs: dict[str, Callable[..., Any]] = {name: getattr(server, name) for name in VERBS}
        self._verbs |= {
            "violations": lambda: server.violations,
            "calls": lambda: server.calls,
            "seq": lambda: server.seq,
            "file": lambda file_id: base64.b64encode(server.file(file_id)).decode(),
            "send_file": self._send_file,
            "swap_file": lambda file_id, content: self._server.swap_file(
                file_id, base64.b64decode(content)
            ),
            "commands": lambda: server.world.state.commands,
            "health": lambda: {
                "bot": server.world.bot.username,
                "now_s": server.world.clock.now_s(),
            },
        }

    def routes(self) -> list[web.RouteDef]:
        """Return what to serve."""
        return [
            web.get("/_control/{verb}", self._serve, allow_head=False),
            web.post("/_control/{verb}", self._serve),
        ]

    def _send_file(
        self,
        chat: int,
        user: int,
        name: str,
        content: str = "",
        path: str = "",
        **unusual: Unpack[MessageOptions],
    ) -> int:
        sent = Path(path) if path else base64.b64decode(content)
        return self._server.send_file(chat, user, name, sent, **unusual)

    async def _serve(self, request: web.Request) -> web.Response:
        verb = self._verbs.get(request.match_info["verb"])
        if verb is None:
            return _answer(404, {"ok": False, "error": "there is no such verb"})
        try:
            result = await self._call(verb, await _parameters(request))
        except (ControlError, KeyError, TypeError, msgspec.MsgspecError) as error:
            return _answer(400, {"ok": False, "error": str(error)})
        return _answer(200, {"ok": True, "result": result})

    async def _call(self, verb: Callable[..., Any], parameters: dict[str, Any]) -> object:
        # React takes its emoji one by one; JSON has them in a list.
        emoji = parameters.pop("emoji", None)
        if isinstance(emoji, list):
            chat, user, message = (parameters.pop(name) for name in ("chat", "user", "message"))
            result = verb(chat, user, message, *emoji, **parameters)
        else:
            result = verb(**parameters)
        return await result if inspect.isawaitable(result) else result


async def _parameters(request: web.Request) -> dict[str, Any]:
    if request.method == "GET":
        return {name: _guess(value) for name, value in request.query.items()}
    body = await request.read()
    return msgspec.json.decode(body, type=dict[str, Any]) if body else {}


def _guess(value: str) -> object:
    """Read a word of a query as JSON when it is some, else as it stands."""
    try:
        return msgspec.json.decode(value)
    except msgspec.DecodeError:
        return value


def _answer(status: int, body: dict[str, Any]) -> web.Response:
    return web.Response(
        status=status, body=msgspec.json.encode(body), content_type="application/json"
    )
