"""Connections: how long one may take to say what it wants and to take its answer, and how many.

uvicorn waits for ever for the rest of a request's head, keeps whatever it is sent of one, and waits
for ever for a client that takes nothing of its answer. Here each of these has an end, and whoever
comes now is served before whoever has said nothing so far.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from typing import TYPE_CHECKING, Any

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

if TYPE_CHECKING:
    from rosic.api.settings import ServingLimits


class IdleConnections:
    """The connections that have not said yet what they want, the oldest first.

    Args:
        limits: What clients may take.
        most: Connections at a time.
    """

    def __init__(self, limits: ServingLimits, most: int) -> None:
        self.limits, self._most = limits, most
        self._silent: OrderedDict[LimitedHttp, None] = OrderedDict()

    def begun(self, connection: LimitedHttp, count: int) -> None:
        """Let one more in; at the limit the oldest that asks nothing gives way to it."""
        self.put(connection)
        if count > self._most:
            oldest, _ = self._silent.popitem(last=False)
            oldest.transport.abort()

    def put(self, connection: LimitedHttp) -> None:
        """Note that a connection asks nothing now."""
        self._silent[connection] = None

    def drop(self, connection: LimitedHttp) -> None:
        """Note that a connection asks something, or is gone."""
        self._silent.pop(connection, None)


class ClientWatchdog:
    """Breaks a connection off whose client takes nothing of what it is sent.

    Args:
        seconds: For so long.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._handle: asyncio.TimerHandle | None = None

    def begin(self, transport: asyncio.Transport) -> None:
        """Count from now on: more waits for the client than is kept for it."""
        self.end()
        loop = asyncio.get_running_loop()
        self._handle = loop.call_later(self._seconds, transport.abort)

    def end(self) -> None:
        """Count no more."""
        if self._handle is not None:
            self._handle.cancel()
            self._handle = None


class WatchedConnection(asyncio.Protocol):
    """A connection that is ended when its client takes nothing for too long.

    It stands before the protocol that it ends, whose transport is its own.
    """

    transport: asyncio.Transport
    _stalled: ClientWatchdog

    def pause_writing(self) -> None:
        """Count how long the client takes nothing."""
        super().pause_writing()
        self._stalled.begin(self.transport)

    def resume_writing(self) -> None:
        """Count no more."""
        super().resume_writing()
        self._stalled.end()

    def connection_lost(self, exc: Exception | None) -> None:
        """Count no more."""
        self._stalled.end()
        super().connection_lost(exc)


class LimitedHttp(WatchedConnection, HttpToolsProtocol):
    """A connection of HTTP.

    Args:
        silent: Those that ask nothing.
        of_uvicorn: What uvicorn gives to a connection.
    """

    def __init__(self, silent: IdleConnections, **of_uvicorn: Any) -> None:  # noqa: ANN401
        super().__init__(**of_uvicorn)
        self._silent = silent
        self._stalled = ClientWatchdog(silent.limits.stalled_s)
        self._waiting: asyncio.TimerHandle | None = None
        self._head_bytes = 0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for the head of the first request."""
        super().connection_made(transport)
        self._await_head(self._silent.limits.head_s)
        self._silent.begun(self, len(self.connections))

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing any more."""
        self._head_is_here()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Take in what comes, if the head does not grow too long."""
        super().data_received(data)
        if self._waiting is not None:
            self._head_bytes += len(data)
            if self._head_bytes > self._silent.limits.head_bytes:
                self.transport.abort()

    def on_headers_complete(self) -> None:
        """Wait no more: what is wanted is known."""
        self._head_is_here()
        super().on_headers_complete()

    def on_response_complete(self) -> None:
        """Wait for the head of the next request, unless it is there."""
        super().on_response_complete()
        if self.cycle.response_complete and not self.transport.is_closing():
            self._await_head(self._silent.limits.idle_s)
            self._silent.put(self)

    def _await_head(self, seconds: float) -> None:
        self._head_is_here()
        self._head_bytes = 0
        self._waiting = self.loop.call_later(seconds, self.transport.abort)

    def _head_is_here(self) -> None:
        self._silent.drop(self)
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None


class LimitedSocket(WatchedConnection, WebSocketsSansIOProtocol):
    """A connection that has become a WebSocket.

    Args:
        limits: What clients may take.
        of_uvicorn: What uvicorn gives to a connection.
    """

    def __init__(self, limits: ServingLimits, **of_uvicorn: Any) -> None:  # noqa: ANN401
        super().__init__(**of_uvicorn)
        self._stalled = ClientWatchdog(limits.stalled_s)
