"""Files by HTTP, for messengers whose servers keep them there: bounded, and never redirected."""

from __future__ import annotations

from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import urlsplit

import aiohttp

from rosic.core.i18n import said
from rosic.errors import MessengerFault, RosicError

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Mapping
    from ssl import SSLContext

    from rosic.core.message import Attachment, IncomingFile

WITHIN_S: Final = 60.0
PIECE_BYTES: Final = 2**16


class HttpFiles:
    """Puts files, and fetches them, at addresses that whoever calls it has checked.

    Args:
        most: How large a file may be.
        trust: Whose certificates are believed.
    """

    def __init__(self, most: int, trust: SSLContext) -> None:
        self._most = most
        self._trust = trust

    async def put(self, url: str, attachment: Attachment, headers: Mapping[str, str]) -> None:
        """Upload a file.

        Raises:
            MessengerFault: It is not there, or not all of it.
        """
        if attachment.size > self._most:
            raise MessengerFault(said("The file is larger than the server takes. It was not sent."))
        about = {"Content-Length": str(attachment.size), "Content-Type": attachment.media_type}
        async with self._asked("PUT", url, data=attachment.read(), headers={**headers, **about}):
            pass

    async def size(self, url: str) -> int:
        """Return how large a file is; 0 where that cannot be known."""
        try:
            async with self._asked("HEAD", url) as answer:
                return answer.content_length or 0
        except MessengerFault:
            return 0

    def check(self, enclosure: IncomingFile) -> None:
        """Refuse a file that is said to be too large.

        Raises:
            MessengerFault: It is.
        """
        if enclosure.size > self._most:
            most = self._most // 1_000_000
            raise MessengerFault(said("Files of at most {most} MB can be taken.", most=most))

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield a file, whose id is its address; see `contracts.messenger.Messenger.fetch`.

        Raises:
            MessengerFault: It cannot be had, or is not as long as was said.
        """
        self.check(enclosure)
        most, came = enclosure.size or self._most, 0
        async with self._asked("GET", enclosure.id) as answer:
            async for piece in answer.content.iter_chunked(PIECE_BYTES):
                came += len(piece)
                if came > most:
                    break
                yield piece
        if came > most or enclosure.size not in {0, came}:
            raise MessengerFault(said("The file is not as long as was said."))

    @asynccontextmanager
    async def _asked(
        self,
        method: str,
        url: str,
        **more: Any,  # noqa: ANN401 - aiohttp's own
    ) -> AsyncIterator[aiohttp.ClientResponse]:
        within = aiohttp.ClientTimeout(total=WITHIN_S)
        try:
            async with (
                aiohttp.ClientSession(timeout=within) as http,
                http.request(method, url, ssl=self._trust, allow_redirects=False, **more) as answer,
            ):
                answer.raise_for_status()
                yield answer
        except RosicError as error:  # it is not what was promised
            raise MessengerFault(error.sentence) from error
        except (aiohttp.ClientError, TimeoutError, OSError, ValueError) as error:
            raise MessengerFault(
                said("The file could not be brought to the server, or fetched.")
            ) from error


def place_of(url: str) -> tuple[str, str]:
    """Return which server an address leads to, and how; empty where it is none."""
    try:
        parts = urlsplit(url)
    except ValueError:
        return "", ""
    return parts.scheme, parts.netloc
