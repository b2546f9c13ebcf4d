"""Files on the account's own server (XEP-0363), and from nowhere else."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Any, Final

from slixmpp.exceptions import IqError, IqTimeout

from rosic.core.i18n import said
from rosic.errors import MessengerFault
from rosic.messengers.http_files import HttpFiles, place_of

if TYPE_CHECKING:
    from collections.abc import AsyncIterator
    from ssl import SSLContext

    from rosic.core.message import Attachment, IncomingFile

FILE_BYTES: Final = 50_000_000
WITHIN_S: Final = 10.0
HEADERS: Final = frozenset({"authorization", "cookie", "expires"})


class UploadedFiles:
    """Puts files where the server says, and fetches what its people have put there.

    An address in a message is anybody's: only the place that the server itself named is asked.
    """

    def __init__(self, upload: Any, trust: SSLContext, *, is_local: bool) -> None:  # noqa: ANN401
        self._upload = upload  # the plugin of the library, which has no types
        self._schemes = {"https", "http"} if is_local else {"https"}
        self._http = HttpFiles(FILE_BYTES, trust)
        self._place = ("", "")

    async def put(self, attachment: Attachment) -> str:
        """Upload a file, and return its address; see `HttpFiles.put`."""
        put, get, headers = await self._slot(attachment.name, attachment.size)
        await self._http.put(put, attachment, headers)
        return get

    async def size(self, url: str) -> int:
        """Return how large a file is; 0 where nobody says."""
        return await self._http.size(url) if await self._is_here(url) else 0

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield a file that somebody sent; see `HttpFiles.fetch`."""
        self._http.check(enclosure)
        if not await self._is_here(enclosure.id):
            raise MessengerFault(said("Only files on the robots' own server can be taken."))
        async for piece in self._http.fetch(enclosure):
            yield piece

    async def _is_here(self, url: str) -> bool:
        with suppress(MessengerFault):
            if not any(self._place):
                await self._slot("place", 1)
        return any(self._place) and place_of(url) == self._place

    async def _slot(self, name: str, size: int) -> tuple[str, str, dict[str, str]]:
        try:
            service = await self._upload.find_upload_service(timeout=WITHIN_S)
            answer = await self._upload.request_slot(service["from"], name, size, timeout=WITHIN_S)
        except (IqError, IqTimeout, TypeError) as error:  # a type error: there is no such service
            raise MessengerFault(said("The server takes no such file.")) from error
        slot = answer["http_upload_slot"]
        put, get = slot["put"]["url"], slot["get"]["url"]
        self._place = place_of(get)
        if not {self._place[0], place_of(put)[0]} <= self._schemes:
            raise MessengerFault(said("The server takes files without encryption only."))
        headers = {one["name"]: one["value"] for one in slot["put"]["headers"]}
        return put, get, {key: headers[key] for key in headers if key.lower() in HEADERS}
