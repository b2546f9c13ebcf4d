"""Fetches files that people sent, decrypted where they were encrypted."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from nio.crypto import decrypt_attachment
from nio.exceptions import EncryptionError

from rosic.core.i18n import said
from rosic.errors import MessengerFault
from rosic.messengers.matrix.content import enclosed_file

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from rosic.core.message import IncomingFile
    from rosic.messengers.matrix.client import MatrixClient
    from rosic.messengers.matrix.content import EncryptedFile

PIECE_BYTES: Final = 2**16


class MediaFetcher:
    """Fetches for one account.

    Args:
        most: How large a file may be.
    """

    def __init__(self, client: MatrixClient, most: int) -> None:
        self._client = client
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
            async for piece in self._client.download(file.url):
                came += len(piece)
                if came > most:
                    raise _not_as_said()
                yield piece
        if enclosure.size and came != enclosure.size:
            raise _not_as_said()

    async def _decrypted(self, file: EncryptedFile, most: int) -> bytes:
        """Return all of a file: nothing of it counts before its digest was compared."""
        content = bytearray()
        async for piece in self._client.download(file.url):
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
