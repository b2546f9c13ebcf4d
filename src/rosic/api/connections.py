"""Connections: how long one may take to say what it wants and to take its answer, and how many.

uvicorn waits for ever for the rest of a request's head, keeps whatever it is sent of one, and waits
for ever for a client that takes nothing of its answer. Here each of these has an end, and whoever
comes now is served before whoever has not said yet all that they want.

What comes in one piece is looked at in small ones, each in a turn of the loop of its own: a stop
does not wait for 80,000 empty frames of a stranger.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
from collections import OrderedDict
from typing import TYPE_CHECKING, Any, Final, cast

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol
from uvicorn.protocols.utils import ClientDisconnected
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame, Opcode

if TYPE_CHECKING:
    from collections.abc import Callable, MutableMapping

    from rosic.api.settings import ServingLimits


STEP_BYTES: Final = 4_096
"""So much is looked at in one turn of the loop: some 700 frames, or 150 requests, at most."""


STEP_S: Final = 0.002
"""After so long at one client's messages the loop has its turn: a stop waits for no flood."""


LATE_S: Final = 0.2
"""A loop that is so late stood still, and more may have come meanwhile than it has read."""
GRACE_S: Final = 1.0
"""So much longer it then waits."""


class StepLimit:
    """How long one client's messages may keep the loop, of which many may be there at once."""

    def __init__(self) -> None:
        self._loop = asyncio.get_running_loop()
        self._until_s = self._loop.time() + STEP_S

    async def rest(self) -> None:
        """Let the loop have its turn, if it is time."""
        if self._loop.time() > self._until_s:
            await asyncio.sleep(0)
            self._until_s = self._loop.time() + STEP_S


class ConnectionDeadline:
    """Ends a connection after so long, but has the loop read first what has come by then.

    After a standstill of the process the loop knows what is due before it looks at what came
    meanwhile, and a stop may be in that.

    Args:
        loop: Of the connection.
        seconds: After so long.
        end: Ends it.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, seconds: float, end: Callable[[], object]
    ) -> None:
        self._loop, self._end = loop, end
        self._due_s = loop.time() + seconds
        self._handle: asyncio.Handle = loop.call_at(self._due_s, self._note_due)

    def cancel(self) -> None:
        """End nothing."""
        self._handle.cancel()

    def _note_due(self) -> None:
        if self._loop.time() - self._due_s > LATE_S:
            self._handle = self._loop.call_later(GRACE_S, self._read)
        else:
            self._read()

    def _read(self) -> None:
        # What is called in the next turn is called before what is read in it: it takes two.
        self._handle = self._loop.call_soon(self._note_read)

    def _note_read(self) -> None:
        self._handle = self._loop.call_soon(self._end)


class PacedTransport:
    """The transport of a connection, and what has come over it and was not looked at yet.

    Whatever it is asked besides is its transport's business.
    """

    def __init__(self, transport: asyncio.Transport, loop: asyncio.AbstractEventLoop) -> None:
        self._transport, self._loop = transport, loop
        self._held = bytearray()
        self._paused = False
        self._step: asyncio.Handle | None = None

    def __getattr__(self, name: str) -> Any:  # noqa: ANN401 - as the transport has it
        return getattr(self._transport, name)

    @property
    def holds(self) -> bool:
        """Whether something has come that was not looked at yet."""
        return bool(self._held)

    def came(self, data: bytes) -> None:
        """Take in what has come: at once, or a step at a time."""
        if not self._held and len(data) <= STEP_BYTES:
            self._hand_on(data)
            return
        self._held += data
        self._transport.pause_reading()
        self._begin_step()

    def drop(self) -> None:
        """Let go of what was not looked at: the connection is gone."""
        self._held.clear()

    def pause_reading(self) -> None:
        """Look at nothing more for now."""
        self._paused = True
        self._transport.pause_reading()

    def resume_reading(self) -> None:
        """Look at what was kept first, then at what comes."""
        self._paused = False
        self._go_on()

    def _go_on(self) -> None:
        if self._paused or self._transport.is_closing():
            return
        if self._held:
            self._begin_step()
        else:
            self._transport.resume_reading()

    def _begin_step(self) -> None:
        if self._step is None and not self._paused:
            self._step = self._loop.call_soon(self._take_step)

    def _take_step(self) -> None:
        self._step = None
        if self._paused or self._transport.is_closing():
            return
        data = bytes(self._held[:STEP_BYTES])
        del self._held[:STEP_BYTES]
        self._hand_on(data)
        self._go_on()

    def _hand_on(self, data: bytes) -> None:
        protocol = cast("WatchedConnection", self._transport.get_protocol())
        protocol.take_in(data)


class IdleConnections:
    """The connections that have not said yet all that they want, the oldest first.

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
        self._handle: ConnectionDeadline | None = None

    def begin(self, transport: asyncio.Transport) -> None:
        """Count from now on: more waits for the client than is kept for it."""
        self.end()
        loop = asyncio.get_running_loop()
        self._handle = ConnectionDeadline(loop, self._seconds, transport.abort)

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

    def data_received(self, data: bytes) -> None:
        """Take in what comes, in steps."""
        self._paced.came(data)

    @property
    def _paced(self) -> PacedTransport:
        return cast("PacedTransport", self.transport)

    def take_in(self, data: bytes) -> None:
        """Take in one step of it."""
        super().data_received(data)

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
        self._paced.drop()
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
        self._waiting: ConnectionDeadline | None = None
        self._head_bytes = 0
        self._whole = True

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for the head of the first request."""
        paced = PacedTransport(transport, self.loop)
        super().connection_made(cast("asyncio.Transport", paced))
        self._await_head(self._silent.limits.head_s)
        self._silent.begun(self, len(self.connections))

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait for nothing any more."""
        self._silent.drop(self)
        self._head_is_here()
        super().connection_lost(exc)

    def take_in(self, data: bytes) -> None:
        """Take in one step of what comes, if the head does not grow too long."""
        super().take_in(data)
        if self._waiting is not None and self._whole:
            self._head_bytes += len(data)
            if self._head_bytes > self._silent.limits.head_bytes:
                self.transport.abort()

    def on_headers_complete(self) -> None:
        """Wait for the head no more; what it announces may be yet to come."""
        self._whole = False
        self._head_is_here()
        if self.parser.should_upgrade():
            self._silent.drop(self)
        super().on_headers_complete()

    def on_message_complete(self) -> None:
        """Wait no more: all that is wanted is known; or was answered before it was."""
        self._whole = True
        if self._waiting is None:
            self._silent.drop(self)
        super().on_message_complete()

    def on_response_complete(self) -> None:
        """Wait for the head of the next request, unless it is there."""
        super().on_response_complete()
        if self.cycle.response_complete and not self.transport.is_closing():
            self._await_head(self._silent.limits.idle_s)
            self._silent.put(self)

    def timeout_keep_alive_handler(self) -> None:
        """Do nothing: it would not look at what has come, and we wait for the head ourselves."""

    def _await_head(self, seconds: float) -> None:
        self._head_is_here()
        self._head_bytes = 0
        self._waiting = ConnectionDeadline(self.loop, seconds, self._end)

    def _end(self) -> None:
        if self._paced.holds:
            self._waiting = ConnectionDeadline(self.loop, GRACE_S, self._end)
        else:
            self.transport.abort()

    def _head_is_here(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None


UNSENT_BYTES: Final = 65_536
"""So little of what was sent may wait in the system for its turn on the network."""
FRAGMENTS_AT_MOST: Final = 1_024
"""Of one message: empty ones count for nothing against its size, and could come for ever."""
TOO_BIG: Final = 1009
FRAGMENTED: Final = "That message has too many fragments."


def frame_of(content: bytes, *, text: bool) -> bytes:
    """Return a message as it goes over the network, to any client."""
    return Frame(Opcode.TEXT if text else Opcode.BINARY, content).serialize(mask=False)


class LimitedSocket(WatchedConnection, WebSocketsSansIOProtocol):
    """A connection that has become a WebSocket.

    Args:
        limits: What clients may take.
        of_uvicorn: What uvicorn gives to a connection.
    """

    def __init__(self, limits: ServingLimits, **of_uvicorn: Any) -> None:  # noqa: ANN401
        super().__init__(**of_uvicorn)
        self._stalled = ClientWatchdog(limits.stalled_s)

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Keep nothing of what is sent here: what waits for a slow client waits where it is newest.

        What has left this process and not this machine is little, too.
        """
        super().connection_made(transport)
        transport.set_write_buffer_limits(high=0)
        connected = transport.get_extra_info("socket")
        with contextlib.suppress(OSError, AttributeError):  # no such option, or no such socket
            connected.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT_BYTES)

    async def send(self, message: MutableMapping[str, Any]) -> None:  # type: ignore[override]
        """Send, and return when it has left this process: what a client is told waits nowhere else.

        Beside what ASGI has there is ``frame``: a message that was made into a frame before, once
        for many clients. That a connection is closed is told to a client that takes nothing, too:
        it reads so when it takes what is on its way.

        Raises:
            ClientDisconnected: The client is gone.
        """
        if message["type"] == "websocket.close":
            self.writable.set()
        frame = message.get("frame")
        if frame is None:
            await super().send(message)  # type: ignore[arg-type]
        else:
            await self.writable.wait()
            if self.disconnected or self.close_sent:
                raise ClientDisconnected
            self.transport.write(frame)
        if not self.close_sent:
            await self.writable.wait()

    def data_received(self, data: bytes) -> None:
        """Take in what comes, in steps; first the head, which was looked at already."""
        if self.transport.get_protocol() is self:
            super().data_received(data)
        else:
            self.take_in(data)

    def keepalive_timeout(self) -> None:
        """Fail a connection whose client answers no ping, once what has come was looked at."""
        unanswered = self.pending_ping_payload

        def end() -> None:
            if self.pending_ping_payload == unanswered:
                super(LimitedSocket, self).keepalive_timeout()

        ConnectionDeadline(self.loop, GRACE_S, end)

    def handle_cont(self, event: Frame) -> None:
        """Take in one more fragment of a message, unless there are too many."""
        if len(self.frames) < FRAGMENTS_AT_MOST:
            super().handle_cont(event)
        elif not self.close_sent:
            self.queue.put_nowait({"type": "websocket.disconnect", "code": TOO_BIG})
            self.conn.send_close(TOO_BIG, FRAGMENTED)
            self.transport.write(b"".join(self.conn.data_to_send()))
            self.close_sent = True
            self.transport.close()
