"""Files that go out: as a picture where Telegram takes it for one, else as a document.

https://core.telegram.org/bots/api#sending-files: 50 MB, and 10 MB for photos, whose sides together
are at most 10,000 pixels. A photo is compressed anew, so only pictures for eyes go this way. A Bot
API server of one's own takes 2000 MB, and what is large goes to it piece by piece.
"""

from __future__ import annotations

import asyncio
import json
import os
import re
import stat
import struct
from contextlib import aclosing
from pathlib import PurePosixPath
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

from telegram import InputFile, InputMediaPhoto

from rosic.core.i18n import said
from rosic.errors import MessengerFault
from rosic.messengers.telegram import formatting as texts
from rosic.messengers.telegram.formatting import inert

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Awaitable, Callable, Mapping

    from telegram import InlineKeyboardMarkup, Message, ReplyParameters

    from rosic.core.message import Attachment, IncomingFile, Outbound
    from rosic.messengers.telegram.bot_client import ApiBot, BotClient
    from rosic.messengers.telegram.settings import TelegramSettings


# ---- files that go out ----

FILE_BYTES: Final = 50_000_000
PHOTO_BYTES: Final = 10_000_000
PHOTO_SIDES: Final = 10_000
PHOTO_RATIO: Final = 20
LOCAL_BYTES: Final = 2_000_000_000
FILE_S: Final = 120.0
SLOWEST_BYTES_S: Final = 500_000
"""How long a file may take on its way: so long, and longer by a second for each so many bytes."""
JPEG: Final = "image/jpeg"
_JPEG: Final = b"\xff\xd8\xff"
_JPEG_SIZES: Final = frozenset({0xC0, 0xC1, 0xC2, 0xC3})
GIF: Final = "image/gif"
_PNG: Final = b"\x89PNG\r\n\x1a\n"


class SendableFile:
    """A file as Telegram takes it.

    Attributes:
        within_s: How long it may take on its way.
    """

    def __init__(self, attachment: Attachment) -> None:
        self._attachment = attachment
        self.is_picture = _is_picture(attachment)
        self.within_s = FILE_S + attachment.size / SLOWEST_BYTES_S

    async def send(
        self,
        bot: ApiBot,
        chat: int,
        caption: str,
        reply: ReplyParameters | None,
        markup: InlineKeyboardMarkup | None,
        thread: int | None = None,
    ) -> str:
        """Send it and return the message's id."""
        attachment, marks = self._attachment, inert(caption)
        if attachment.pieces is not None:
            fields = {
                "chat_id": chat,
                "caption": caption or None,
                "caption_entities": marks and json.dumps([mark.to_dict() for mark in marks]),
                "reply_parameters": reply,
                "reply_markup": markup,
                "message_thread_id": thread,
            }
            return await bot.raw_document(fields, attachment, self.within_s)
        file = InputFile(attachment.content, filename=attachment.name)
        how: Callable[..., Awaitable[Message]] = bot.send_document
        if self.is_picture:
            how = bot.send_photo
        elif attachment.media_type == GIF:
            how = bot.send_animation
        message = await how(
            chat,
            file,
            caption=caption or None,
            caption_entities=marks,
            reply_parameters=reply,
            reply_markup=markup,
            message_thread_id=thread,
            write_timeout=self.within_s,
            read_timeout=self.within_s,
        )
        return str(message.message_id)


def prepared(attachment: Attachment, most: int = FILE_BYTES) -> SendableFile:
    """Return a file as it can be sent.

    Raises:
        MessengerFault: It is too large. Nothing was sent.
    """
    if attachment.size > most:
        raise MessengerFault("The file is larger than Telegram takes. Nothing was sent.")
    return SendableFile(attachment)


def picture_of(outbound: Outbound) -> InputMediaPhoto:
    """Return a picture and the text beneath it, for a message that is there already.

    Raises:
        MessengerFault: It is none that Telegram takes, or the text does not fit beneath it.
    """
    attachment = outbound.attachment
    fits = texts.units(outbound.text) <= texts.CAPTION_UNITS
    if attachment is None or not _is_picture(attachment) or not fits:
        raise MessengerFault("That cannot be shown as a picture. Nothing was changed.")
    return InputMediaPhoto(
        attachment.content,
        caption=outbound.text or None,
        filename=attachment.name,
        caption_entities=inert(outbound.text),
    )


def _is_picture(attachment: Attachment) -> bool:
    content = attachment.content
    if len(content) > PHOTO_BYTES:
        return False
    sides = sorted(_SIDES.get(attachment.media_type, _unknown)(content))
    return bool(sides[0]) and sum(sides) <= PHOTO_SIDES and sides[1] <= PHOTO_RATIO * sides[0]


def _png_sides(content: bytes) -> tuple[int, int]:
    if not content.startswith(_PNG) or len(content) < 24:  # noqa: PLR2004 - up to its two sides
        return 0, 0
    width, height = struct.unpack(">II", content[16:24])
    return width, height


def _jpeg_sides(content: bytes) -> tuple[int, int]:
    at = 2
    while content.startswith(_JPEG) and at + 9 < len(content) and content[at] == 0xFF:  # noqa: PLR2004
        if content[at + 1] in _JPEG_SIZES:
            height, width = struct.unpack(">HH", content[at + 5 : at + 9])
            return width, height
        at += 2 + int(struct.unpack(">H", content[at + 2 : at + 4])[0])
    return 0, 0


def _unknown(_content: bytes) -> tuple[int, int]:
    return 0, 0


_SIDES: Final[Mapping[str, Callable[[bytes], tuple[int, int]]]] = {
    "image/png": _png_sides,
    JPEG: _jpeg_sides,
}


# ---- files that people send ----

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


class FileFetcher:
    """Fetches for one bot.

    Attributes:
        most: How large a file may be.
    """

    def __init__(self, line: BotClient, settings: TelegramSettings) -> None:
        self._line = line
        self._folder = settings.local_folder
        self.most = LOCAL_BYTES if settings.local_mode else FETCH_BYTES

    async def fetch(self, enclosure: IncomingFile) -> AsyncGenerator[bytes]:
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

    async def _ask(self, enclosure: IncomingFile) -> tuple[str, int]:
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
