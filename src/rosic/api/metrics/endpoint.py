"""``/metrics``, ``/livez`` and ``/readyz``: three pages on a port of their own.

So few requests come here, and all of them so short, that no web framework is needed; it works
without the extra of the API. Nothing here says who anybody is, and nothing can be changed.
"""

from __future__ import annotations

import asyncio
import logging
from contextlib import suppress
from http import HTTPStatus
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.api.metrics.exposition import MEDIA_TYPE
from rosic.api.metrics.gateway_metrics import GatewayMetrics
from rosic.api.settings import HostPort, hostname
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from rosic.gateway.feature import Kernel

HEAD_BYTES: Final = 8_192
WITHIN_S: Final = 5.0
CONNECTIONS: Final = 32
PLAIN: Final = "text/plain; charset=utf-8"

log = logging.getLogger("rosic.metrics")


class MetricsSettings(msgspec.Struct, frozen=True, kw_only=True):
    """Where metrics are served.

    Attributes:
        hosts: Names by which it may be reached, besides the address it listens on.
    """

    listen: HostPort
    hosts: tuple[str, ...] = ()


class MetricsEndpoint:
    """Serves metrics until cancelled.

    Args:
        kernel: Of a gateway that is open.
        settings: Where, and by which names.

    Attributes:
        port: On which it listens; 0: not yet.
    """

    def __init__(self, kernel: Kernel, settings: MetricsSettings) -> None:
        self._settings = settings
        self._metrics = GatewayMetrics(kernel)
        self._open = 0
        self.port = 0
        self._hosts = settings.listen.names.union(settings.hosts)

    async def run(self) -> None:
        """Listen until cancelled.

        Raises:
            ConfigurationError: It cannot listen there.
        """
        listen = self._settings.listen
        try:
            server = await asyncio.start_server(
                self._serve, listen.host, listen.port, limit=HEAD_BYTES
            )
        except OSError as error:
            raise ConfigurationError(
                f"{listen} of this machine cannot be listened on ({error.strerror}).",
                hint="Name another address and port as listen of [metrics].",
            ) from error
        self.port = server.sockets[0].getsockname()[1]
        log.info("metrics are served on %s", listen)
        measuring = asyncio.create_task(self._metrics.loop.run())
        try:
            async with server:
                await server.serve_forever()
        finally:
            self.port = 0
            self._metrics.close()
            measuring.cancel()
            await asyncio.gather(measuring, return_exceptions=True)

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Answer one request, and close: whoever asks comes again in some seconds."""
        self._open += 1
        try:
            if self._open <= CONNECTIONS:
                async with asyncio.timeout(WITHIN_S):
                    writer.write(self._answer(await reader.readuntil(b"\r\n\r\n")))
                    await writer.drain()
        except (TimeoutError, OSError, asyncio.IncompleteReadError):
            pass
        except asyncio.LimitOverrunError:
            writer.write(_response(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE))
        finally:
            self._open -= 1
            writer.close()
            with suppress(OSError, TimeoutError):
                async with asyncio.timeout(WITHIN_S):
                    await writer.wait_closed()

    def _answer(self, head: bytes) -> bytes:
        first, *fields = head.decode("latin-1").split("\r\n")
        words = first.split(" ")
        if len(words) != 3 or not words[2].startswith("HTTP/1."):  # noqa: PLR2004 - what it is
            return _response(HTTPStatus.BAD_REQUEST)
        hosts = [field.partition(":")[2] for field in fields if field.lower().startswith("host:")]
        if len(hosts) != 1 or hostname(hosts[0].strip()) not in self._hosts:
            return _response(HTTPStatus.MISDIRECTED_REQUEST)
        method, path = words[0], words[1].partition("?")[0]
        if method not in {"GET", "HEAD"}:
            return _response(HTTPStatus.METHOD_NOT_ALLOWED)
        return self._page(path, body=method == "GET")

    def _page(self, path: str, *, body: bool) -> bytes:
        if path == "/metrics":
            return _response(HTTPStatus.OK, self._metrics.page(), MEDIA_TYPE, body=body)
        if path == "/livez":
            return _response(HTTPStatus.OK, b"ok\n", body=body)
        if path == "/readyz":
            why = self._metrics.not_ready
            status = HTTPStatus.SERVICE_UNAVAILABLE if why else HTTPStatus.OK
            return _response(status, ("\n".join(why or ("ok",)) + "\n").encode(), body=body)
        return _response(HTTPStatus.NOT_FOUND, body=body)


def _response(
    status: HTTPStatus, content: bytes = b"", media_type: str = PLAIN, *, body: bool = True
) -> bytes:
    content = content or f"{status.phrase}\n".encode()
    head = (
        f"HTTP/1.1 {status.value} {status.phrase}",
        f"Content-Type: {media_type}",
        f"Content-Length: {len(content)}",
        "Cache-Control: no-store",
        "X-Content-Type-Options: nosniff",
        "Connection: close",
    )
    return "\r\n".join((*head, "", "")).encode() + (content if body else b"")
