"""Files that go out: as a picture where Telegram takes it for one, else as a document.

https://core.telegram.org/bots/api#sending-files: 50 MB, and 10 MB for photos, whose sides together
are at most 10,000 pixels. A photo is compressed anew, so only pictures for eyes go this way. A Bot
API server of one's own takes 2000 MB, and what is large goes to it piece by piece.
"""

from __future__ import annotations

import json
import struct
from typing import TYPE_CHECKING, Final

from telegram import InputFile, InputMediaPhoto

from rosic.errors import MessengerFault
from rosic.messengers.telegram import text as texts
from rosic.messengers.telegram.formatting import inert

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Mapping

    from telegram import InlineKeyboardMarkup, Message, ReplyParameters

    from rosic.core.message import Attachment, Outbound
    from rosic.messengers.telegram.bot_client import ApiBot

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


class Sendable:
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
            said = {
                "chat_id": chat,
                "caption": caption or None,
                "caption_entities": marks and json.dumps([mark.to_dict() for mark in marks]),
                "reply_parameters": reply,
                "reply_markup": markup,
                "message_thread_id": thread,
            }
            return await bot.raw_document(said, attachment, self.within_s)
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


def prepared(attachment: Attachment, most: int = FILE_BYTES) -> Sendable:
    """Return a file as it can be sent.

    Raises:
        MessengerFault: It is too large. Nothing was sent.
    """
    if attachment.size > most:
        raise MessengerFault("The file is larger than Telegram takes. Nothing was sent.")
    return Sendable(attachment)


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
        attachment.content, caption=outbound.text or None, filename=attachment.name,
        caption_entities=inert(outbound.text),
    )  # fmt: skip


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
