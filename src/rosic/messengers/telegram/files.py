"""Files that go out: as a picture where Telegram takes it for one, else as a document.

https://core.telegram.org/bots/api#sending-files: 50 MB, and 10 MB for photos, whose sides together
are at most 10,000 pixels. A photo is compressed anew, so only pictures for eyes go this way.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Final

from telegram import InputFile

from rosic.errors import MessengerFault

if TYPE_CHECKING:
    from telegram import Bot, InlineKeyboardMarkup, ReplyParameters

    from rosic.core.message import Attachment

FILE_BYTES: Final = 50_000_000
PHOTO_BYTES: Final = 10_000_000
PHOTO_SIDES: Final = 10_000
PHOTO_RATIO: Final = 20
FILE_S: Final = 120.0
"""How long a file may take on its way."""
_PNG: Final = b"\x89PNG\r\n\x1a\n"


class Sendable:
    """A file as Telegram takes it."""

    def __init__(self, attachment: Attachment) -> None:
        self._attachment = attachment
        self.is_picture = _is_picture(attachment)

    async def send(
        self,
        bot: Bot,
        chat: int,
        caption: str,
        reply: ReplyParameters | None,
        markup: InlineKeyboardMarkup | None,
    ) -> str:
        """Send it and return the message's id."""
        attachment = self._attachment
        file = InputFile(attachment.content, filename=attachment.name)
        how = bot.send_photo if self.is_picture else bot.send_document
        message = await how(
            chat,
            file,
            caption=caption or None,
            reply_parameters=reply,
            reply_markup=markup,
            write_timeout=FILE_S,
            read_timeout=FILE_S,
        )
        return str(message.message_id)


def prepared(attachment: Attachment) -> Sendable:
    """Return a file as it can be sent.

    Raises:
        MessengerFault: It is too large. Nothing was sent.
    """
    if len(attachment.content) > FILE_BYTES:
        raise MessengerFault("The file is larger than Telegram takes. Nothing was sent.")
    return Sendable(attachment)


def _is_picture(attachment: Attachment) -> bool:
    content = attachment.content
    if attachment.media_type != "image/png" or len(content) > PHOTO_BYTES:
        return False
    if not content.startswith(_PNG) or len(content) < 24:  # noqa: PLR2004 - up to its two sides
        return False
    sides: list[int] = sorted(struct.unpack(">II", content[16:24]))
    return bool(sides[0]) and sum(sides) <= PHOTO_SIDES and sides[1] <= PHOTO_RATIO * sides[0]
