"""What the record keeps so that another run can answer: sealed by the store, never in the open."""

from __future__ import annotations

import msgspec

from rosic.core.message import Chat


class ReplyTo(msgspec.Struct, frozen=True, gc=False, array_like=True):
    """Where a request came from and how its life is shown.

    Attributes:
        messenger: Name of the configured messenger.
        message: Id of the message answered; empty for a tap.
        title: First line of the card: ``KUKA iiwa: grasp, 15 N``.
        values: What the order was given in the end, SI: completed, within limits. Of records of
            before, None.
        live: They are where it began: it was steered from then on.
    """

    messenger: str
    chat: Chat
    message: str
    title: str
    values: dict[str, float | int | str] | None = None
    live: bool = False


class KeptAnswer(msgspec.Struct, frozen=True):
    """A refusal as it was or would have been told.

    Attributes:
        asked: What it refuses, as it was said; empty in records of before.
    """

    messenger: str
    chat: Chat
    message: str
    text: str
    asked: str = ""


encode = msgspec.msgpack.Encoder().encode
read_reply_to = msgspec.msgpack.Decoder(ReplyTo).decode
read_answer = msgspec.msgpack.Decoder(KeptAnswer).decode
