"""Streamable HTTP for programs of this machine: loopback alone, each request with a secret."""

from __future__ import annotations

import logging
import socket
import time
from collections import deque
from contextlib import contextmanager
from typing import TYPE_CHECKING, Final

import uvicorn
from mcp.server.auth.middleware.bearer_auth import AuthenticatedUser
from mcp.server.auth.provider import AccessToken
from mcp.server.streamable_http_manager import StreamableHTTPSessionManager
from mcp.server.transport_security import TransportSecurityMiddleware, TransportSecuritySettings
from mcp.shared.inbound import MCP_PROTOCOL_VERSION_HEADER
from mcp_types.version import HANDSHAKE_PROTOCOL_VERSIONS
from starlette.requests import Request
from starlette.responses import PlainTextResponse

from rosic.core.secret import Secret
from rosic.errors import ConfigurationError, RosicError
from rosic.messengers.mcp.server import LineSpeaker, ProgramCaller, server_of

if TYPE_CHECKING:
    from collections.abc import Iterator

    from starlette.responses import Response
    from starlette.types import Receive, Scope, Send

    from rosic.core.identity import Address
    from rosic.messengers.mcp.server import Context

HOST: Final = "127.0.0.1"
PATH: Final = "/mcp"
CALLER: Final = "rosic.caller"
BODY_BYTES: Final = 262_144
SESSIONS_AT_MOST: Final = 64
SESSION_IDLE_S: Final = 120
OPENED_AT_MOST: Final = 8
"""So many sessions one program opens within the time in which idle ones end: others need some."""
MANY_OPENED: Final = "This program opens too many sessions. Go on in one, or try again later."
CONNECTIONS_AT_MOST: Final = 512
CLOSE_WITHIN_S: Final = 1
SESSION_HEADER: Final = "mcp-session-id"
NO_KEY: Final = "Show the key of a program: Authorization: Bearer rosic_..."

log = logging.getLogger("rosic.mcp")


class HttpEndpoint:
    """One port of this machine.

    Args:
        speaker: Says what programs call.
        port: On which to listen.
    """

    def __init__(self, speaker: LineSpeaker, port: int) -> None:
        self._speaker, self._port = speaker, port
        hosts = [f"{name}:{port}" for name in (HOST, "localhost")]
        # A page in a browser has an origin, and no business here, whatever name it reached us by.
        security = TransportSecuritySettings(allowed_hosts=hosts, allowed_origins=[])
        self._checks = TransportSecurityMiddleware(security)
        self._sessions = StreamableHTTPSessionManager(
            server_of(speaker, _caller_of),
            security_settings=security,
            max_request_body_size=BODY_BYTES,
            max_sessions=SESSIONS_AT_MOST,
            session_idle_timeout=SESSION_IDLE_S,
        )
        self._opened: dict[Address, deque[float]] = {}

    async def serve(self) -> None:
        """Listen until cancelled.

        Raises:
            ConfigurationError: The port is taken.
        """
        with socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP) as listener:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                listener.bind((HOST, self._port))
            except OSError as error:
                raise ConfigurationError(
                    f"Port {self._port} of this machine cannot be listened on ({error.strerror}).",
                    hint="Name another as port of the messenger of kind mcp.",
                ) from error
            server = _Uvicorn(
                uvicorn.Config(
                    self._answer,
                    log_config=None,
                    access_log=False,
                    interface="asgi3",
                    lifespan="off",
                    ws="none",
                    limit_concurrency=CONNECTIONS_AT_MOST,
                    server_header=False,
                    timeout_graceful_shutdown=CLOSE_WITHIN_S,
                )
            )
            async with self._sessions.run():
                try:
                    await server.serve(sockets=[listener])
                finally:
                    server.force_exit = True
                    await server.shutdown(sockets=[listener])

    async def _answer(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve whoever comes from this machine, reached us by its name, and shows a good key."""
        if scope["type"] != "http":
            return
        request = Request(scope, receive)
        refusal: Response | None = await self._checks.validate_request(request)
        if refusal is None and request.url.path != PATH:
            refusal = PlainTextResponse(f"There is only {PATH} here.", status_code=404)
        if refusal is None:
            try:
                scope[CALLER] = caller = self._caller(request)
            except RosicError as why:
                refusal = _unauthorised(str(why))
            else:
                token = AccessToken(token="-", client_id=str(caller.address), scopes=[])  # noqa: S106
                scope["user"] = AuthenticatedUser(token)  # a session is its program's alone
                if self._opens_too_many(request, caller.address):
                    refusal = PlainTextResponse(MANY_OPENED, status_code=429)
        if refusal is not None:
            await refusal(scope, receive, send)
        else:
            await self._sessions.handle_request(scope, receive, send)

    def _opens_too_many(self, request: Request, program: Address) -> bool:
        """Count the sessions that a program opens; those of whoever needs none are none."""
        version = request.headers.get(MCP_PROTOCOL_VERSION_HEADER)
        has_none = version is not None and version not in HANDSHAKE_PROTOCOL_VERSIONS
        if has_none or SESSION_HEADER in request.headers:
            return False
        now_s = time.monotonic()
        self._opened = {
            other: opened
            for other, opened in self._opened.items()
            if opened and now_s - opened[-1] < SESSION_IDLE_S
        }
        opened = self._opened.setdefault(program, deque())
        while opened and now_s - opened[0] >= SESSION_IDLE_S:
            opened.popleft()
        if len(opened) >= OPENED_AT_MOST:
            return True
        opened.append(now_s)
        return False

    def _caller(self, request: Request) -> ProgramCaller:
        kind, _, text = request.headers.get("Authorization", "").partition(" ")
        if kind.lower() != "bearer" or not text.strip():
            raise RosicError(NO_KEY)
        secret = Secret(text.strip())
        return ProgramCaller(self._speaker.programs.identify(secret), secret)


def _caller_of(ctx: Context) -> ProgramCaller:
    assert ctx.request is not None  # noqa: S101 - what comes over HTTP has one
    caller: ProgramCaller = ctx.request.scope[CALLER]
    return caller


def _unauthorised(sentence: str) -> Response:
    return PlainTextResponse(sentence, status_code=401, headers={"WWW-Authenticate": "Bearer"})


class _Uvicorn(uvicorn.Server):
    """Signals are the gateway's business."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Leave them alone."""
        yield
