"""A wire between a gateway and its homeserver that a test can cut."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

if TYPE_CHECKING:
    from asyncio import StreamReader, StreamWriter
    from collections.abc import AsyncIterator


class Relay:
    """Passes bytes on in both directions.

    Attributes:
        url: Where a client connects to.
    """

    def __init__(self, homeserver: str) -> None:
        parts = urlsplit(homeserver)
        self._to = (str(parts.hostname), int(parts.port or 0))
        self._open: set[StreamWriter] = set()
        self._cut = False
        self.url = ""

    @asynccontextmanager
    async def running(self) -> AsyncIterator[Relay]:
        server = await asyncio.start_server(self._serve, "127.0.0.1", 0)
        self.url = f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"
        try:
            yield self
        finally:
            server.close()
            self._close()

    @asynccontextmanager
    async def outage(self) -> AsyncIterator[None]:
        """Have nobody reach the homeserver while inside."""
        self._cut = True
        self._close()
        try:
            yield
        finally:
            self._cut = False

    def _close(self) -> None:
        for writer in list(self._open):
            writer.transport.abort()

    async def _serve(self, reader: StreamReader, writer: StreamWriter) -> None:
        if self._cut:
            writer.transport.abort()
            return
        try:
            other_reader, other_writer = await asyncio.open_connection(*self._to)
        except OSError:
            writer.transport.abort()
            return
        both = {writer, other_writer}
        self._open |= both
        try:
            await asyncio.gather(_pass_on(reader, other_writer), _pass_on(other_reader, writer))
        finally:
            self._open -= both
            for one in both:
                one.transport.abort()


async def _pass_on(reader: StreamReader, writer: StreamWriter) -> None:
    try:
        while piece := await reader.read(2**16):
            writer.write(piece)
            await writer.drain()
    except OSError:
        pass
    writer.transport.abort()
