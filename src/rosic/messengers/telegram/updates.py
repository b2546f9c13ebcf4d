"""The part of Telegram's updates that ROSIC reads. Whatever else is in them is passed over.

https://core.telegram.org/bots/api#update
"""

from __future__ import annotations

import json
import re
from typing import Any

import msgspec

KINDS = (
    "message",
    "edited_message",
    "channel_post",
    "edited_channel_post",
    "callback_query",
    "my_chat_member",
    "chat_member",
    "message_reaction",
)
"""Asked for by name, because Telegram remembers what the last program asked for."""

GROUP_ANONYMOUS_BOT = 1087968824
CHANNEL_BOT = 136817688
TELEGRAM = 777000
"""Stand-ins: Telegram writes these as the sender where it does not tell who wrote."""


class TelegramUser(msgspec.Struct):
    """Somebody who writes. Names are only shown; the user name is only used for the bot's own."""

    id: int
    is_bot: bool = False
    first_name: str = ""
    language_code: str | None = None


class TelegramChat(msgspec.Struct):
    """A place; also what writes in somebody's stead (``sender_chat``)."""

    id: int
    type: str = ""
    title: str = ""


class RepliedMessage(msgspec.Struct):
    """A message that is spoken of: tapped under, or replied to. Of an old one this much is left."""

    message_id: int
    chat: TelegramChat
    sender: Any = msgspec.field(name="from", default=None)
    message_thread_id: int | None = None
    is_topic_message: bool = False


class TelegramMessage(msgspec.Struct, kw_only=True):
    """A message in any of its guises.

    Attributes:
        date: Unix time in whole seconds, cut off.
        message_thread_id: Of a forum topic; of any other thread where ``is_topic_message`` is not.
        left_chat_member: Whoever left, as it came: what is said must not depend on its form.
        entities, document, photo, location: As they came: read by `links`, `enclosed` and `placed`,
            so that what is malformed hides no stop that was written beneath.
    """

    message_id: int
    date: int
    chat: TelegramChat
    sender: TelegramUser | None = msgspec.field(name="from", default=None)
    sender_chat: TelegramChat | None = None
    text: str | None = None
    caption: str | None = None
    entities: Any = None
    caption_entities: Any = None
    document: Any = None
    photo: Any = None
    location: Any = None
    venue: Any = None
    reply_to_message: RepliedMessage | None = None
    external_reply: Any = None
    edit_date: int | None = None
    forward_origin: Any = None
    forward_date: int | None = None
    via_bot: Any = None
    sender_business_bot: Any = None
    business_connection_id: Any = None
    is_automatic_forward: bool = False
    is_from_offline: bool = False
    migrate_to_chat_id: int | None = None
    migrate_from_chat_id: int | None = None
    message_thread_id: int | None = None
    is_topic_message: bool = False
    left_chat_member: Any = None


class Document(msgspec.Struct):
    """A file of any kind. What is said of it is its sender's word."""

    file_id: str
    file_name: str = ""
    mime_type: str = ""
    file_size: int = 0


class PhotoSize(msgspec.Struct):
    """A photo in one of several sizes."""

    file_id: str
    width: int = 0
    height: int = 0
    file_size: int = 0


class Location(msgspec.Struct):
    """A point on the map. A live one moves along with its sender."""

    latitude: float
    longitude: float
    live_period: int | None = None


class CallbackQuery(msgspec.Struct, kw_only=True):
    """A tap on a button. It has no date."""

    id: str
    sender: TelegramUser = msgspec.field(name="from")
    message: RepliedMessage | None = None
    data: str | None = None


class Member(msgspec.Struct):
    """Somebody's place in a chat.

    Attributes:
        status: ``creator``, ``administrator``, ``member``, ``restricted``, ``left``, ``kicked``.
        is_member: Of somebody restricted: whether they are in the chat.
    """

    user: TelegramUser
    status: str
    is_member: bool = True

    @property
    def present(self) -> bool:
        """Whether they are in the chat."""
        return self.status not in {"left", "kicked"} and self.is_member


class MemberUpdate(msgspec.Struct, kw_only=True):
    """Somebody's place in a chat has changed."""

    chat: TelegramChat
    sender: TelegramUser = msgspec.field(name="from")
    old_chat_member: Member
    new_chat_member: Member


class ReactionUpdate(msgspec.Struct, kw_only=True):
    """Somebody's reactions to a message have changed.

    Attributes:
        user: None for somebody anonymous.
        old_reaction, new_reaction: As they came: read by `added`.
    """

    chat: TelegramChat
    message_id: int
    user: TelegramUser | None = None
    old_reaction: list[Any] = []
    new_reaction: list[Any] = []


class Update(msgspec.Struct, kw_only=True):
    """One update; at most one of its parts is there."""

    update_id: int
    message: TelegramMessage | None = None
    edited_message: TelegramMessage | None = None
    channel_post: TelegramMessage | None = None
    edited_channel_post: TelegramMessage | None = None
    callback_query: CallbackQuery | None = None
    my_chat_member: MemberUpdate | None = None
    chat_member: MemberUpdate | None = None
    message_reaction: ReactionUpdate | None = None


def written(update: Update) -> TelegramMessage | None:
    """Return the message in an update, in whatever guise it came."""
    return (
        update.message or update.edited_message or update.channel_post or update.edited_channel_post
    )


class ApiAnswer(msgspec.Struct, kw_only=True):
    """What the Bot API says to a request for updates, each of them as it came over the wire."""

    ok: bool = False
    result: list[msgspec.Raw] | None = None


class _Numbered(msgspec.Struct):
    """The least of an update."""

    update_id: int


_NUMBER = re.compile(rb'\s*\{\s*"update_id"\s*:\s*([0-9]{1,19})\s*[,}]')
"""How every update begins; another order of its parts costs only more time."""


def update_id(raw: object) -> int | None:
    """Return the number of an update that may otherwise be malformed; None when it has none.

    Of what came over the wire no more is read than that takes: most of what a poll brings while
    people wait was brought before.
    """
    if isinstance(raw, msgspec.Raw):
        if found := _NUMBER.match(raw):
            return int(found[1])
        try:
            return msgspec.json.decode(raw, type=_Numbered).update_id
        except msgspec.ValidationError:
            return None
        except msgspec.DecodeError:
            raw = _loaded(raw)
    number = raw.get("update_id") if isinstance(raw, dict) else None
    return number if type(number) is int else None


def parse(raw: object) -> Update:
    """Read one update, as it came over the wire or taken apart already.

    Raises:
        msgspec.ValidationError: It is not what Telegram's documentation says.
    """
    if isinstance(raw, msgspec.Raw):
        try:
            return msgspec.json.decode(raw, type=Update)
        except msgspec.ValidationError:
            raise
        except (msgspec.DecodeError, UnicodeDecodeError):
            raw = _loaded(raw)
    return msgspec.convert(raw, Update)


def _loaded(raw: msgspec.Raw) -> object:
    """Return an update that holds halves of characters, which msgspec does not read."""
    try:
        loaded: object = json.loads(bytes(raw).decode("utf-8", "replace"))
    except (ValueError, RecursionError):
        return None
    return loaded


def added(update: ReactionUpdate) -> tuple[str, ...]:
    """Return the plain emoji that somebody has put beside a message now; no custom or paid ones."""
    old, new = (
        {one.get("emoji") for one in reactions if isinstance(one, dict)}
        for reactions in (update.old_reaction, update.new_reaction)
    )
    return tuple(sorted(one for one in new - old if isinstance(one, str)))


def enclosed(message: TelegramMessage) -> Document | None:
    """Return the file that a message brings: a document, or the largest size of a photo."""
    try:
        if message.document is not None:
            return msgspec.convert(message.document, Document)
        if message.photo:
            sizes = msgspec.convert(message.photo, list[PhotoSize])
            photo = max(sizes, key=lambda size: size.width * size.height)
            return Document(photo.file_id, "", "image/jpeg", photo.file_size)
    except msgspec.ValidationError:
        return None
    return None


def links(message: TelegramMessage) -> tuple[str, ...]:
    """Return the addresses behind words of a message, each once."""
    found = message.entities or message.caption_entities
    marks = found if isinstance(found, list) else []
    urls = (mark.get("url") for mark in marks if isinstance(mark, dict))
    return tuple(dict.fromkeys(url for url in urls if isinstance(url, str)))


def placed(message: TelegramMessage) -> Location | None:
    """Return the place that a message is.

    None for a live location, which follows its sender about, and for a venue.
    """
    if message.location is None or message.venue is not None:
        return None
    try:
        location = msgspec.convert(message.location, Location)
    except msgspec.ValidationError:
        return None
    near = abs(location.latitude) <= 90 and abs(location.longitude) <= 180  # noqa: PLR2004
    return location if near and location.live_period is None else None
