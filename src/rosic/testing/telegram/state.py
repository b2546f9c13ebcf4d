"""What the pretended Telegram knows: people, chats, messages, files and the queue of one bot.

Plain records, so that the whole state can be written to a file and read back (`--state`). Objects
that only travel (entities, keyboards, origins) stay the JSON objects they are on the wire.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import msgspec

JsonObject: TypeAlias = dict[str, Any]

ANONYMOUS_ADMIN_ID = 1087968824
"""Sender of what an anonymous group admin writes (https://core.telegram.org/bots/api#message)."""
CHANNEL_BOT_ID = 136817688
"""Sender of what is written in the name of a channel. Telegram's docs are silent on the number."""
SERVICE_ID = 777000
"""Sender of posts of the linked channel, forwarded into its discussion group by Telegram itself."""


class User(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One account.

    Attributes:
        started: This person has opened the private chat with the bot; before that the bot may not
        write.
        blocked: This person has blocked the bot.
    """

    id: int
    first_name: str
    last_name: str | None = None
    username: str | None = None
    language_code: str | None = None
    is_bot: bool = False
    started: bool = False
    blocked: bool = False


class ServerChat(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One chat.

    Attributes:
        kind: "private", "group", "supergroup" or "channel".
        members: Status by user id: "creator", "administrator", "member", "restricted", "left",
        "kicked".
        topics: Names of forum topics by thread id.
        topics_by: Who created each.
        instance: The `chat_instance` of button presses here.
        withheld: Rights that an administrator was not given, by user id.
        last_bot_id: The bot that wrote last; in privacy mode a bare `/command` goes to that one.
    """

    id: int
    kind: str
    title: str | None = None
    username: str | None = None
    members: dict[int, str] = {}
    topics: dict[int, str] = {}
    topics_by: dict[int, int] = {}
    is_forum: bool = False
    linked_chat_id: int | None = None
    migrated_to: int | None = None
    pinned: list[int] = []
    instance: str = ""
    withheld: dict[int, list[str]] = {}
    last_bot_id: int | None = None


class Content(msgspec.Struct, kw_only=True, omit_defaults=True):
    """The part of a message that an edit can change.

    Attributes:
        text: Of a text message; a message with media has a caption instead.
        media: The `photo` or `document` field as Telegram shows it, under its own name.
        received_s: Server time of the call or act that made it, in seconds with a fraction.
    """

    text: str | None = None
    entities: list[JsonObject] = []
    caption: str | None = None
    caption_entities: list[JsonObject] = []
    media: JsonObject = {}
    reply_markup: JsonObject | None = None
    received_s: float = 0.0


class Message(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One message, with every form it ever had.

    Attributes:
        date: Unix time in whole seconds, as Telegram dates it.
        versions: Oldest first; the last one is what the person sees now.
        own: The bot sent it; in a channel, nobody is named as its sender.
        extra: Further fields of Telegram's Message (origin, via_bot, service fields), as they are.
    """

    chat_id: int
    message_id: int
    date: int
    versions: list[Content]
    from_id: int | None = None
    sender_chat_id: int | None = None
    edit_date: int | None = None
    reply_to: int | None = None
    thread_id: int | None = None
    deleted: bool = False
    silent: bool = False
    own: bool = False
    reactions: dict[int, list[str]] = {}
    extra: JsonObject = {}

    @property
    def content(self) -> Content:
        """What the person sees now."""
        return self.versions[-1]


class ButtonPress(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One press of a button, and what the bot answered.

    Attributes:
        answers: Each with text, show_alert, url, cache_time and time_s.
    """

    id: str
    user_id: int
    chat_id: int
    message_id: int
    data: str
    pressed_s: float
    answers: list[JsonObject] = []


class ServerFile(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One file held by Telegram.

    Attributes:
        path: What getFile gives as `file_path`.
        show: The Document or PhotoSize object, without its content.
        left: Where a large file of a local server lies; then ``content`` is empty.
        link_until_s: Server time until which it can be downloaded; 0 before getFile.
    """

    id: str
    unique_id: str
    name: str
    path: str
    kind: str
    content: bytes
    show: JsonObject
    left: str = ""
    link_until_s: float = 0.0


class Pending(msgspec.Struct, kw_only=True, omit_defaults=True):
    """One update that waits for the bot.

    Attributes:
        expires_s: Server time after which Telegram forgets it.
    """

    update_id: int
    kind: str
    payload: JsonObject
    expires_s: float


class Webhook(msgspec.Struct, kw_only=True, omit_defaults=True):
    """The webhook as set; an empty `url` means none."""

    url: str = ""
    max_connections: int = 40
    ip_address: str | None = None


class State(msgspec.Struct, kw_only=True, omit_defaults=True):
    """Everything that outlives a restart of the server.

    Attributes:
        counters: Last message id by chat; 0 stands for private chats and basic groups, which share
        one.
        allowed: Update types that are kept; None is Telegram's default selection.
        commands: By scope and language, as `setMyCommands` left them.
        names: `name`, `description`, `short_description` by kind and language.
    """

    bot: User
    users: dict[int, User] = {}
    chats: dict[int, ServerChat] = {}
    messages: dict[int, dict[int, Message]] = {}
    counters: dict[int, int] = {}
    queue: list[Pending] = []
    next_update_id: int = 100_000_001
    allowed: list[str] | None = None
    queries: dict[str, ButtonPress] = {}
    files: dict[str, ServerFile] = {}
    commands: dict[str, list[JsonObject]] = {}
    names: dict[str, str] = {}
    webhook: Webhook = msgspec.field(default_factory=Webhook)
    logged_out: bool = False
    serial: int = 0
    clock_shift_s: float = 0.0
