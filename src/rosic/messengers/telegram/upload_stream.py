"""A file on its way to the Bot API, read while it goes: python-telegram-bot holds files whole.

https://core.telegram.org/bots/api#making-requests: multipart/form-data. Its length is said first,
so that a body which ends early is no call.
"""

from __future__ import annotations

import secrets
from typing import TYPE_CHECKING

from telegram import TelegramObject
from telegram.error import TelegramError

if TYPE_CHECKING:
    from collections.abc import AsyncGenerator, Iterator, Mapping

    from rosic.core.message import Attachment


class ChangedUpload(TelegramError):
    """What was to be sent is not what was promised, and was not sent.

    Attributes:
        sentence: Why not.
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(sentence)
        self.sentence = sentence


class UploadStream:
    """The parameters of a call, and one file; stands where python-telegram-bot has its own."""

    def __init__(self, fields: Mapping[str, object], field: str, attachment: Attachment) -> None:
        self._attachment = attachment
        self._boundary = secrets.token_hex(16)
        parts = [_part(self._boundary, f'name="{key}"', value) for key, value in _spoken(fields)]
        about = f'name="{field}"; filename="{_quoted(attachment.name)}"'
        kind = f"\r\nContent-Type: {_quoted(attachment.media_type)}"
        self._head = b"".join(parts) + _part(self._boundary, about + kind, b"")[:-2]
        self._tail = f"\r\n--{self._boundary}--\r\n".encode()

    @property
    def headers(self) -> dict[str, str]:
        """What is said before the body."""
        length = len(self._head) + self._attachment.size + len(self._tail)
        return {
            "Content-Type": f"multipart/form-data; boundary={self._boundary}",
            "Content-Length": str(length),
        }

    async def body(self) -> AsyncGenerator[bytes]:
        """Yield it, from the start each time.

        Raises:
            RosicError: The file is not what was promised.
        """
        yield self._head
        async for piece in self._attachment.read():
            yield piece
        yield self._tail


def _spoken(fields: Mapping[str, object]) -> Iterator[tuple[str, bytes]]:
    for key, value in fields.items():
        if value is not None:
            text = value.to_json() if isinstance(value, TelegramObject) else str(value)
            yield key, text.encode()


def _part(boundary: str, about: str, content: bytes) -> bytes:
    head = f"--{boundary}\r\nContent-Disposition: form-data; {about}\r\n\r\n"
    return head.encode() + content + b"\r\n"


def _quoted(text: str) -> str:
    """Return a name that stays inside its quotes, as browsers write it."""
    return text.replace('"', "%22").replace("\r", "%0D").replace("\n", "%0A")
