"""Files that people send: asked for, then read piece by piece, never more than was said.

https://core.telegram.org/bots/api#getfile: 20 MB over Telegram's own servers, through a link
that is good for an hour. A Bot API server of one's own in local mode gives a path on this computer
(https://core.telegram.org/bots/api#using-a-local-bot-api-server); what it names is read
below the configured folder alone, and never through a link.
"""

from __future__ import annotations

import asyncio
import os
import re
import stat
from contextlib import aclosing
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

from rosic.core.i18n import said
from rosic.errors import MessengerFault
from rosic.messengers.telegram.files import LOCAL_BYTES

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator

    from rosic.core.message import Enclosure
    from rosic.messengers.telegram.bot_client import BotClient
    from rosic.messengers.telegram.settings import TelegramSettings

FETCH_BYTES: Final = 20_000_000
PIECE_BYTES: Final = 65_536
FILE_ID: Final = re.compile(r"[A-Za-z0-9_-]{1,256}")

GONE = said("The file cannot be had from Telegram any more. Send it again.")
BROKEN_OFF = said("The file did not come through to its end. Send it again.")
NOT_AS_LONG = said("The file is not as long as Telegram said. Send it again.")
ELSEWHERE = said(
    "The Bot API server put the file where I may not read. "
    "The operator has to look at local_folder."
)


class Fetcher:
    """Fetches for one bot.

    Attributes:
        most: How large a file may be.
    """

    def __init__(self, line: BotClient, settings: TelegramSettings) -> None:
        self._line = line
        self._folder = settings.local_folder
        self.most = LOCAL_BYTES if settings.local_mode else FETCH_BYTES

    async def fetch(self, enclosure: Enclosure) -> AsyncGenerator[bytes]:
        """Yield a file's content.

        Raises:
            MessengerFault: As the contract says.
        """
        if enclosure.size > self.most:
            raise MessengerFault(self._too_large(enclosure.size))
        if not FILE_ID.fullmatch(enclosure.id):
            raise MessengerFault(GONE)
        path, size = await self._ask(enclosure)
        size = enclosure.size or size
        most = size or self.most
        if size > self.most:
            raise MessengerFault(self._too_large(size))
        read = self._read(path) if self._folder else self._download(path)
        count = 0
        async with aclosing(read) as pieces:
            async for piece in pieces:
                count += len(piece)
                if count > most:
                    raise MessengerFault(NOT_AS_LONG if size else self._too_large(count))
                yield piece
        if size and count != size:
            raise MessengerFault(NOT_AS_LONG)

    async def _ask(self, enclosure: Enclosure) -> tuple[str, int]:
        """Return where a file is, and how large."""
        found = await self._line.ask(lambda bot: bot.raw_file(enclosure.id))
        path, size = found.get("file_path"), found.get("file_size", 0)
        if not isinstance(path, str) or not path or "\0" in path or type(size) is not int:
            raise MessengerFault(GONE)
        return path, max(size, 0)

    async def _download(self, path: str) -> AsyncGenerator[bytes]:
        """Read over the network.

        Raises:
            MessengerFault: The path is none below the bot's own, or the way broke.
        """
        if path.startswith("/") or ".." in PurePosixPath(path).parts:
            raise MessengerFault(GONE)
        try:
            async with (
                self._line.held() as bot,
                aclosing(bot.raw_content(quote(path), PIECE_BYTES)) as pieces,
            ):
                async for piece in pieces:
                    yield piece
        except MessengerFault:
            raise
        except Exception:  # noqa: BLE001 - what a library raises may hold the token
            broken = True
        else:
            broken = False
        if broken:
            raise MessengerFault(BROKEN_OFF)

    async def _read(self, path: str) -> AsyncGenerator[bytes]:
        """Read from the disk that the Bot API server writes to.

        Raises:
            MessengerFault: It is not below the folder, or no plain file.
        """
        handle = await asyncio.to_thread(opened_below, self._folder, path)
        try:
            while piece := await asyncio.to_thread(os.read, handle, PIECE_BYTES):
                yield piece
        except OSError as error:
            raise MessengerFault(GONE) from error
        finally:
            os.close(handle)

    def _too_large(self, size: int) -> str:
        if self._folder:
            return said(
                "The file has {size:.1f} MB. A Bot API server gives at most {most:.0f} MB.",
                size=size / 1e6,
                most=self.most / 1e6,
            )
        return said(
            "The file has {size:.1f} MB. Telegram gives me files of up to {most:.0f} MB. With a "
            "Bot API server of your own (api_base and local_mode) it is up to 2000 MB; the "
            "operator can set one up. Or send it in parts.",
            size=size / 1e6,
            most=self.most / 1e6,
        )


def opened_below(folder: str, path: str) -> int:
    """Open a plain file below a folder, following no link on the way; return its handle.

    Raises:
        MessengerFault: It lies elsewhere, is no plain file, or is not there.
    """
    try:
        parts = PurePosixPath(path).relative_to(folder).parts
    except ValueError:
        raise MessengerFault(ELSEWHERE) from None
    if not parts or ".." in parts:
        raise MessengerFault(ELSEWHERE)
    plain = os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK
    try:
        at = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        for place, part in enumerate(parts):
            last = place == len(parts) - 1
            try:
                below = os.open(part, plain if last else plain | os.O_DIRECTORY, dir_fd=at)
            finally:
                os.close(at)
            at = below
    except OSError as error:
        raise MessengerFault(ELSEWHERE) from error
    if not stat.S_ISREG(os.fstat(at).st_mode):
        os.close(at)
        raise MessengerFault(ELSEWHERE)
    return at
