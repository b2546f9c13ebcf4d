"""A file as a whole, for messengers that have nothing to send it in pieces to."""

from __future__ import annotations

from rosic.core.message import Attachment
from rosic.errors import MessengerFault, RosicError


async def whole(attachment: Attachment, most: int) -> Attachment:
    """Return a file with all of its content.

    Raises:
        MessengerFault: It is larger than ``most``, or not what was promised.
    """
    if attachment.size > most:
        raise MessengerFault("The file is too large for this messenger. Nothing was sent.")
    if attachment.pieces is None:
        return attachment
    try:
        content = b"".join([piece async for piece in attachment.read()])
    except RosicError as error:
        raise MessengerFault(error.sentence) from error
    return Attachment(attachment.name, attachment.media_type, content)
