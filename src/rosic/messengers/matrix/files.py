"""Files that people sent, decrypted where they were encrypted, and those that we send."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

import nio
from nio.crypto import decrypt_attachment
from nio.exceptions import EncryptionError

from rosic.core.i18n import said
from rosic.errors import MessengerFault
from rosic.messengers.matrix.connection import FILE_S, OK
from rosic.messengers.matrix.content import enclosed_file
from rosic.messengers.matrix.errors import MatrixError, MatrixErrorKind, refusal

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, AsyncIterator, Callable

    from rosic.core.message import IncomingFile
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.content import EncryptedFile

PIECE_BYTES: Final = 2**16


class MediaCalls:
    """Brings files to the homeserver, and from there."""

    def __init__(self, client: MatrixClient) -> None:
        self._client = client

    async def upload(
        self,
        source: Callable[[], AsyncIterator[bytes]],
        size: int,
        media_type: str,
        *,
        encrypt: bool,
    ) -> tuple[str, dict[str, Any] | None]:
        """Put a file there; return its address, and how to decrypt it where it was encrypted.

        Raises:
            MatrixError: It is not there, or not as promised.
        """
        broken: list[Exception] = []

        async def read() -> AsyncGenerator[bytes]:
            try:
                async for piece in source():
                    yield piece
            except Exception as error:
                broken.append(error)
                raise

        async def act() -> Any:  # noqa: ANN401 - matrix-nio has no types
            answer, keys = await self._client.library.upload(
                lambda *_: read(),
                "application/octet-stream" if encrypt else media_type,
                encrypt=encrypt,
                filesize=size,
            )
            return answer if isinstance(answer, nio.ErrorResponse) else (answer, keys)

        try:
            answer, keys = await self._client.ask(act, within_s=FILE_S)
        except MatrixError:
            if broken:
                raise MatrixError(
                    str(broken[0]), MatrixErrorKind.REFUSED, "its content broke"
                ) from None
            raise
        return str(answer.content_uri), keys

    async def download(self, address: str) -> AsyncGenerator[bytes]:
        """Yield what is stored at an address of Matrix's (``mxc://``), piece by piece.

        Raises:
            MatrixError: It cannot be had.
        """
        server, _, media = address.removeprefix("mxc://").partition("/")
        if not address.startswith("mxc://") or not server or not media:
            raise MatrixError("That is no file of Matrix.", MatrixErrorKind.REFUSED, "address")
        path = f"/_matrix/client/v1/media/download/{quote(server, safe='')}/{quote(media, safe='')}"
        response = await self._client.ask(lambda: self._get(path))
        try:
            if response.status not in OK:
                raise refusal(response.status, None)
            pieces = response.content.iter_chunked(2**16)
            while (piece := await self._client.ask(lambda: anext(pieces, None))) is not None:
                yield piece
        finally:
            response.close()

    async def _get(self, path: str) -> Any:  # noqa: ANN401 - matrix-nio has no types
        client = self._client
        return await client.library.send("GET", path, headers=client.headers(), timeout=FILE_S)


class MediaFetcher:
    """Fetches for one account.

    Args:
        most: How large a file may be.
    """

    def __init__(self, client: MatrixClient, most: int) -> None:
        self._media = MediaCalls(client)
        self._most = most

    async def fetch(self, enclosure: IncomingFile) -> AsyncIterator[bytes]:
        """Yield a file, byte for byte; one that was encrypted only once all of it was checked.

        Raises:
            MessengerFault: It cannot be had, is too large, is not as long as was said, or was
                changed on the way.
        """
        if enclosure.size > self._most:
            raise MessengerFault(
                said("Files of at most {most} MB can be taken.", most=self._most // 1_000_000)
            )
        file = enclosed_file(enclosure.id)
        if file is None:
            raise MessengerFault(said("There is no such file."))
        most = enclosure.size or self._most
        if file.key:
            content = await self._decrypted(file, most)
            for at in range(0, len(content), PIECE_BYTES):
                yield content[at : at + PIECE_BYTES]
            came = len(content)
        else:
            came = 0
            async for piece in self._media.download(file.url):
                came += len(piece)
                if came > most:
                    raise _not_as_said()
                yield piece
        if enclosure.size and came != enclosure.size:
            raise _not_as_said()

    async def _decrypted(self, file: EncryptedFile, most: int) -> bytes:
        """Return all of a file: nothing of it counts before its digest was compared."""
        content = bytearray()
        async for piece in self._media.download(file.url):
            content += piece
            if len(content) > most:
                raise _not_as_said()
        try:
            return bytes(decrypt_attachment(bytes(content), file.key, file.sha256, file.iv))
        except (EncryptionError, ValueError, TypeError):
            raise MessengerFault(
                said("The file cannot be decrypted, or was changed on the way.")
            ) from None


def _not_as_said() -> MessengerFault:
    return MessengerFault(said("The file is not as long as was said."))
